"""``python -m photon_engine``: see cli.py."""

import os
import sys

from .cli import main

code = main()
sys.stdout.flush()
sys.stderr.flush()
if "bpy" in sys.modules:
    os._exit(code)  # Blender as a module can hang when the interpreter tears it down
sys.exit(code)
