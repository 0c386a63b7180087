"""Unit vectors in 32 bits, by the octahedral map [Cigolle et al. 2014, JCGT 3(2)]; error below 7e-5 radians."""

from __future__ import annotations

import math

import numpy as np

from ..jit import inlined, kernel
from ..vec import normalize

_SCALE = 32767.0


@kernel
def pack_direction(v):
    """A unit vector as an integer of 32 bits."""
    s = 1.0 / (abs(v[0]) + abs(v[1]) + abs(v[2]))
    x, y = v[0] * s, v[1] * s
    # without branches: half of them would be mispredicted
    fold = 1.0 if v[2] < 0.0 else 0.0
    fold_x = math.copysign(1.0 - abs(y), x)
    fold_y = math.copysign(1.0 - abs(x), y)
    a = np.int64((x + fold * (fold_x - x)) * _SCALE + 32768.5)
    b = np.int64((y + fold * (fold_y - y)) * _SCALE + 32768.5)
    return np.uint32((a << 16) | b)


@inlined
def unpack_direction(code):
    """The unit vector of pack_direction's integer."""
    return normalize(unpack_octahedral(code))


@inlined
def unpack_octahedral(code):
    """The vector of pack_direction's integer before it is normalised: on the octahedron |x| + |y| + |z| = 1."""
    x = float(np.int64(code >> 16) - 32768) / _SCALE
    y = float(np.int64(code & 0xFFFF) - 32768) / _SCALE
    z = 1.0 - abs(x) - abs(y)
    fold = max(-z, 0.0)
    return (x - math.copysign(fold, x), y - math.copysign(fold, y), z)
