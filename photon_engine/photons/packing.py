"""Unit vectors in 32 bits, by the octahedral map [Cigolle et al. 2014, JCGT 3(2)]; error below 7e-5 radians."""

from __future__ import annotations

import numpy as np

from ..jit import kernel
from ..vec import normalize

_SCALE = 32767.0


@kernel
def pack_direction(v):
    """A unit vector as an integer of 32 bits."""
    s = 1.0 / (abs(v[0]) + abs(v[1]) + abs(v[2]))
    x, y = v[0] * s, v[1] * s
    if v[2] < 0.0:
        x, y = (1.0 - abs(y)) * (1.0 if x >= 0.0 else -1.0), (1.0 - abs(x)) * (1.0 if y >= 0.0 else -1.0)
    a = np.int64(np.rint(x * _SCALE)) + 32768
    b = np.int64(np.rint(y * _SCALE)) + 32768
    return np.uint32((a << 16) | b)


@kernel
def unpack_direction(code):
    """The unit vector of pack_direction's integer."""
    x = float(np.int64(code >> 16) - 32768) / _SCALE
    y = float(np.int64(code & 0xFFFF) - 32768) / _SCALE
    z = 1.0 - abs(x) - abs(y)
    if z < 0.0:
        x, y = (1.0 - abs(y)) * (1.0 if x >= 0.0 else -1.0), (1.0 - abs(x)) * (1.0 if y >= 0.0 else -1.0)
    return normalize((x, y, z))
