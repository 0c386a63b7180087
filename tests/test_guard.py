"""What the user hears when the program dies while Blender reads a file."""

import signal
import subprocess
import sys

import pytest

from .blender_process import environment

PROGRAM = """
import os, signal, sys
from photon_engine.driver import guard
guard.watch(["render", sys.argv[1]])
{after}
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows cannot fork")
@pytest.mark.parametrize(
    "after, code, told",
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", -signal.SIGSEGV, True),
        ("guard.done(); os.kill(os.getpid(), signal.SIGSEGV)", -signal.SIGSEGV, False),
        ("guard.done(); guard.done()", 0, False),
    ],
)
def test_a_crash_before_the_file_is_read_is_told(tmp_path, after, code, told):
    path = tmp_path / "scene.blend"
    path.write_text("")
    command = [sys.executable, "-c", PROGRAM.format(after=after), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment(), timeout=60)
    assert done.returncode == code and ("scene.blend: the program ended while Blender read" in done.stderr) == told


@pytest.mark.parametrize("words", [["render", "none.blend"], ["render", "scene.npz"], ["--help"]])
def test_what_has_no_blend_is_not_watched(words):
    done = subprocess.run([sys.executable, "-m", "photon_engine", *words], capture_output=True, text=True,
                          env=environment(), timeout=60)  # fmt: skip
    assert done.returncode in (0, 3) and "while Blender read" not in done.stderr
