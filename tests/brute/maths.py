"""Vectors as tuples, random numbers and directions."""

import math

import numpy as np

from .jit import kernel


@kernel
def row(a, i):
    """Row i of an (n, 3) array as a tuple."""
    return (a[i, 0], a[i, 1], a[i, 2])


@kernel
def madd(a, s, b):
    """a + s b."""
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


@kernel
def mul(a, b):
    """Componentwise product."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def scale(a, s):
    """s a."""
    return (s * a[0], s * a[1], s * a[2])


@kernel
def dot(a, b):
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Outer product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def unit(a):
    """A / |a|."""
    return scale(a, 1.0 / math.sqrt(dot(a, a)))


@kernel
def uniform(state):
    """A number in [0, 1) by SplitMix64 [Steele et al. 2014]; state: (1,) u64, advanced."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@kernel
def in_frame(x, y, z, n):
    """x s + y t + z n for some tangents s, t of the unit normal n (not the engine's frame)."""
    helper = (0.0, 1.0, 0.0) if abs(n[0]) > 0.7 else (1.0, 0.0, 0.0)
    s = unit(cross(helper, n))
    t = cross(n, s)
    return (x * s[0] + y * t[0] + z * n[0], x * s[1] + y * t[1] + z * n[1], x * s[2] + y * t[2] + z * n[2])


@kernel
def cosine_direction(n, state):
    """A direction about n with density cos / pi, by a point on a sphere that touches at the origin."""
    z = 2.0 * uniform(state) - 1.0
    phi = 2.0 * math.pi * uniform(state)
    r = math.sqrt(max(0.0, 1.0 - z * z))
    v = (n[0] + r * math.cos(phi), n[1] + r * math.sin(phi), n[2] + z)
    if dot(v, v) < 1e-20:
        return n
    return unit(v)


@kernel
def cone_direction(axis, cos_max, state):
    """A uniform direction within the cone of the given cosine about the axis."""
    z = 1.0 - uniform(state) * (1.0 - cos_max)
    phi = 2.0 * math.pi * uniform(state)
    r = math.sqrt(max(0.0, 1.0 - z * z))
    return in_frame(r * math.cos(phi), r * math.sin(phi), z, axis)
