"""``python -m photon_engine``: see cli.py."""

import os
import sys

from .driver import guard

guard.watch(sys.argv[1:])

from .cli import main  # noqa: E402, loads what starts threads

try:
    code = main()
finally:
    guard.done()
sys.stdout.flush()
sys.stderr.flush()
# no teardown: Blender as a module can hang in it, and after a cancel a kernel may still be compiling
os._exit(code)
