"""``python -m tests.brute SCENE -o ref.exr --minutes M``: see long_run.py, apart from here for its child processes."""

import os
import sys

from photon_engine.issues import RenderError

from .long_run import run

if __name__ == "__main__":
    try:
        print(f"{run(sys.argv[1:])} batches", flush=True)
    except RenderError as error:
        print(error, file=sys.stderr, flush=True)
        os._exit(1)
    sys.stdout.flush()
    os._exit(0)  # bpy 4.5 hangs in an ordinary exit
