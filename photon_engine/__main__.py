"""``python -m photon_engine``: see cli.py."""

import os
import sys

from .cli import main

code = main()
sys.stdout.flush()
sys.stderr.flush()
# no teardown: Blender as a module can hang in it, and after a cancel a kernel may still be compiling
os._exit(code)
