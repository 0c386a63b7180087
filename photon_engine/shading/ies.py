"""Photometric files of lamps (IES LM-63): parsed, and read by direction as Blender's renderer does.

All three photometric types become type C: vertical angles from the nadir, horizontal ones around, both in radians.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

f32 = np.float32
TO_WATT = 0.0706650768394  # 4 pi / 177.83: candela to the power of a lamp, luminous efficacy as of D65
CLOSE = 1e-4  # degrees
MISSING = 100.0  # strength of a file that cannot be read
TINY = f32(1e-7)
DEGREE = f32(np.pi) / f32(180.0)
TYPE_C, TYPE_B, TYPE_A = 1, 2, 3


@dataclass(frozen=True)
class Photometry:
    """Intensities by direction."""

    vertical: np.ndarray  # (v,) f32 [rad]
    horizontal: np.ndarray  # (h,) f32 [rad]
    intensity: np.ndarray  # (h, v) f32, to multiply a lamp's power with


def parse_ies(text: str) -> Photometry:
    """The photometry in a file's text; a ValueError says why there is none."""
    start = re.search(r"\nTILT=", text)
    if start is None:
        raise ValueError("no line TILT=")
    body = text[start.end() :]
    line, _, rest = body.partition("\n")
    numbers = _numbers(rest)
    if line.strip() == "INCLUDE":
        _, count = _take(numbers, 2)
        _take(numbers, 2 * int(count))
    head = _take(numbers, 13)
    kind = int(head[5])
    if kind not in (TYPE_A, TYPE_B, TYPE_C):
        raise ValueError(f"photometric type {kind}")
    n_vertical, n_horizontal = int(head[3]), int(head[4])
    if n_vertical < 2 or n_horizontal < 1:
        raise ValueError(f"{n_vertical} vertical and {n_horizontal} horizontal angles")
    factor = head[2] * head[10] * head[11] * TO_WATT
    vertical = np.array(_take(numbers, n_vertical))
    horizontal = np.array(_take(numbers, n_horizontal))
    values = factor * np.array(_take(numbers, n_vertical * n_horizontal)).reshape(n_horizontal, n_vertical)
    vertical, horizontal, values = {TYPE_A: _from_a, TYPE_B: _from_b, TYPE_C: _from_c}[kind](
        vertical, horizontal, values
    )
    return Photometry(vertical.astype(f32) * DEGREE, horizontal.astype(f32) * DEGREE, values.astype(f32))


def _numbers(text: str):
    """Numbers in a text, parted by white space or commas, up to the first that is none."""
    for word in text.replace(",", " ").split():
        try:
            yield float(word)
        except ValueError:
            return


def _take(numbers, count: int) -> list[float]:
    """The next numbers."""
    found = [value for _, value in zip(range(count), numbers, strict=False)]
    if len(found) < count:
        raise ValueError("the file ends too early")
    return found


def _close(a: float, b: float) -> bool:
    return abs(a - b) < CLOSE


def _mirrored(angles: np.ndarray, values: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles of 0 to 90 degrees mirrored to 0 to 180 about 90, or angles of -90 to 90 shifted there."""
    if not _close(angles[0], 0.0):
        return angles + 90.0, values
    both = np.concatenate([90.0 - angles[:0:-1], 90.0 + angles])
    back = np.flip(values, axis).take(range(len(angles) - 1), axis)
    return both, np.concatenate([back, values], axis)


def _from_a(vertical, horizontal, values):
    """Type A: horizontal angles of -90 to 90 degrees go to 270 to 90."""
    around, turned = 180.0 - horizontal[::-1], values[::-1]
    if _close(horizontal[0], 0.0):
        around = np.concatenate([around, 180.0 + horizontal[1:]])
        turned = np.concatenate([turned, values[1:]])
    return vertical + 90.0, around, turned


def _from_b(vertical, horizontal, values):
    """Type B, whose pole lies horizontally: the angles change places."""
    around, turned = _mirrored(vertical, values.T, 0)
    up, turned = _mirrored(horizontal, turned, 1)
    return up, around, turned


def _from_c(vertical, horizontal, values):
    """Type C: what is left out by symmetry is put in, up to the full circle."""
    if _close(horizontal[0], 90.0):
        horizontal = horizontal - 90.0
    if len(horizontal) == 1:
        horizontal, values = np.array([0.0, 360.0]), np.concatenate([values, values])
    for edge in (90.0, 180.0):
        if _close(horizontal[-1], edge):
            horizontal = np.concatenate([horizontal, 2.0 * edge - horizontal[-2::-1]])
            values = np.concatenate([values, values[-2::-1]])
    if _close(horizontal[0], 0.0) and not _close(horizontal[-1], 360.0):
        gap = 360.0 - horizontal[-1]
        if _close(horizontal[-1] - horizontal[-2], gap) or _close(horizontal[1] - horizontal[0], gap):
            horizontal = np.append(horizontal, 360.0)
            values = np.concatenate([values, values[:1]])
    return vertical, horizontal, values


def look_up(
    table: Photometry, horizontal: np.ndarray, vertical: np.ndarray, dark_beyond: bool = False
) -> np.ndarray:
    """Intensities (n,) f32 at angles (n,) [rad], cubic along both [Catmull and Rom 1974]; 0 out of range.

    dark_beyond : what the cubic would need beyond the first and last angle is 0, as Blender 4.5 has it
    """
    v, h = table.vertical, table.horizontal
    inside = (vertical >= v[0]) & (vertical < v[-1]) & (horizontal >= h[0]) & (horizontal < h[-1])
    i, s = _cell(v, vertical)
    j, t = _cell(h, horizontal)
    n, m = len(v), len(h)
    # past the nadir the value on the same side stands in for that on the other. Blender's renderer means to go on past
    # 180 and 360 degrees likewise, but compares with pi - 1e-7, which in float32 is pi: so it does not, nor do we
    low = np.where(i > 0, i - 1, 1 if v[0] < TINY else 0)
    high = np.minimum(i + 2, n - 1)
    before = np.maximum(j - 1, 0)
    after = np.where(j + 2 < m, j + 2, j)  # where nothing follows, the first of the two again

    beyond = np.zeros((4, len(i)), bool)
    if dark_beyond:
        beyond = np.stack([(i == 0) & (v[0] >= TINY), i + 2 >= n, j == 0, j + 2 >= m])

    def column(k):
        values = table.intensity
        first, last = np.where(beyond[0], 0.0, values[k, low]), np.where(beyond[1], 0.0, values[k, high])
        return _cubic((first, values[k, i], values[k, i + 1], last), s)

    first, last = np.where(beyond[2], 0.0, column(before)), np.where(beyond[3], 0.0, column(after))
    value = _cubic((first, column(j), column(j + 1), last), t)
    return np.where(inside, np.maximum(value, 0.0), 0.0).astype(f32)


def _cell(angles: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the interval of each x, and where in it."""
    i = np.clip(np.searchsorted(angles, x, side="left") - 1, 0, len(angles) - 2)
    width = angles[i + 1] - angles[i]
    return i, (x - angles[i]) / np.where(width > 0.0, width, f32(1.0))


def _cubic(points, x: np.ndarray) -> np.ndarray:
    """A cubic through the middle two of four points, with the slopes of the outer ones."""
    a, b, c, d = points
    return f32(0.5) * (((d + 3.0 * (b - c) - a) * x + (2.0 * a - 5.0 * b + 4.0 * c - d)) * x + (c - a)) * x + b
