"""Scripts in a process of their own, with bpy and a renderer without physics: Blender keeps state, and can crash."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PRELUDE = """
import json, os, sys, traceback
def _end(*error):
    traceback.print_exception(*error); sys.stderr.flush(); os._exit(99)
sys.excepthook = _end  # bpy may hang when Python tears it down
from photon_engine.driver import session
from photon_engine.driver.tests.fake import FakeRenderer
session.default_renderer = FakeRenderer
folder, values, result = sys.argv[1], json.loads(sys.argv[2]), {}
"""
EPILOGUE = """
with open(os.path.join(folder, "result.json"), "w") as file:
    json.dump(result, file)
sys.stdout.flush(); sys.stderr.flush(); os._exit(0)
"""


def environment(**changes: str) -> dict[str, str]:
    """The environment of a process that imports this tree."""
    return {**os.environ, "PYTHONPATH": str(ROOT), **changes}


def run_script(folder: Path, script: str, **values) -> dict:
    """Run a script that fills `result` (values and folder are given to it); returns result, with stderr and rc."""
    command = [sys.executable, "-c", PRELUDE + script + EPILOGUE, str(folder), json.dumps(values)]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), cwd=folder, timeout=300, check=False
    )
    path = folder / "result.json"
    assert done.returncode == 0 and path.exists(), f"rc {done.returncode}\n{done.stdout}\n{done.stderr}"
    result = json.loads(path.read_text())
    path.unlink()
    return result
