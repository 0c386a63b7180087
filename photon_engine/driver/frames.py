"""Frames of an animation on the command line: which, and how their files are called."""

from __future__ import annotations

import re
from pathlib import Path

PART = re.compile(r"(-?\d+)(?:(?:\.\.|-)(-?\d+)(?::(\d+))?)?")
DIGITS = 4  # as Blender pads


def parse_frames(text: str) -> list[int]:
    """Frames of `1-10`, `1..10`, `1-10:2` (each second), `7`, or several of these with commas.

    A range runs as it is written: `10-1` backwards. A ValueError says what is wrong.
    """
    frames: list[int] = []
    for part in text.replace(" ", "").split(","):
        found = PART.fullmatch(part)
        if found is None:
            raise ValueError(f"'{part}' is neither a frame nor a range FIRST-LAST or FIRST-LAST:STEP")
        first, last, step = int(found[1]), int(found[2] or found[1]), int(found[3] or 1)
        if step < 1:
            raise ValueError(f"'{part}': the step must be above 0")
        frames += range(first, last + 1, step) if last >= first else range(first, last - 1, -step)
    return list(dict.fromkeys(frames))


def frame_path(path: Path, frame: int) -> Path:
    """The file of a frame: its number in place of the last `#`s of the name, or behind the name, as Blender does it."""
    marks = list(re.finditer("#+", path.name))
    digits = len(marks[-1][0]) if marks else DIGITS
    number = f"{frame:0{digits + (frame < 0)}d}"
    if marks:
        return path.with_name(path.name[: marks[-1].start()] + number + path.name[marks[-1].end() :])
    return path.with_name(f"{path.stem}_{number}{path.suffix}")
