"""A word for the user when Blender's reader crashes on a damaged file, and with it the whole program.

Blender reads structures as they lie in the file: of 600 damaged .blends 8 ended in a segmentation fault. Nothing can
be said by a process that is gone, so one that was forked before anything was loaded waits until the file is read, and
speaks if that never happens. The exit code is the signal's: shells make 139 of it, and
whoever kills or times the program meets the process that renders.
"""

from __future__ import annotations

import os
import signal
import sys

_pipe: int | None = None  # where `done` is written


def watch(arguments: list[str]) -> None:
    """Begin to wait, when a .blend is among the arguments. To be called before threads are started."""
    global _pipe
    path = next((word for word in arguments if word.lower().endswith(".blend")), None)
    if path is None or not os.path.isfile(path) or not hasattr(os, "fork"):
        return
    sys.stdout.flush()
    sys.stderr.flush()
    ours, theirs = os.pipe()
    if os.fork() == 0:
        os.close(theirs)
        _wait(ours, path)
    os.close(ours)
    _pipe = theirs


def done() -> None:
    """The file is read, or refused: no crash of the reader any more."""
    global _pipe
    if _pipe is not None:
        os.write(_pipe, b".")
        os.close(_pipe)
        _pipe = None


def _wait(pipe: int, path: str) -> None:
    """Of the process that waits: ends it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if not os.read(pipe, 1):
        text = f"error: {path}: the program ended while Blender read the file: it is damaged, or Blender was killed"
        os.write(2, f"{text} (try it in Blender, or the backup .blend1)\n".encode())
    os._exit(0)
