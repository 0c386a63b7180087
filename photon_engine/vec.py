"""Three-vectors as tuples of Python floats (double), for scalar kernels. Arrays hold them as float32 rows."""

from __future__ import annotations

import math

from .jit import kernel


@kernel
def load3(a, i):
    """Row i of an (n, 3) array as a tuple of doubles."""
    return (float(a[i, 0]), float(a[i, 1]), float(a[i, 2]))


@kernel
def store3(a, i, v):
    """Write a tuple into row i of an (n, 3) array."""
    a[i, 0] = v[0]
    a[i, 1] = v[1]
    a[i, 2] = v[2]


@kernel
def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def sub(a, b):
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def mul(a, b):
    """Componentwise product (colours)."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def scale(a, s):
    """s a."""
    return (a[0] * s, a[1] * s, a[2] * s)


@kernel
def madd(a, s, b):
    """a + s b."""
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


@kernel
def dot(a, b):
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Outer product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def length(a):
    """Euclidean norm."""
    return math.sqrt(dot(a, a))


@kernel
def normalize(a):
    """A / |a|; the zero vector stays zero."""
    n = math.sqrt(dot(a, a))
    if n == 0.0:
        return (0.0, 0.0, 0.0)
    s = 1.0 / n
    return (a[0] * s, a[1] * s, a[2] * s)


@kernel
def reflect(w, n):
    """Mirror image of w (pointing away from the surface) about the unit normal n."""
    k = 2.0 * dot(w, n)
    return (k * n[0] - w[0], k * n[1] - w[1], k * n[2] - w[2])


@kernel
def max3(a):
    """Largest component."""
    return max(a[0], max(a[1], a[2]))


@kernel
def luminance(a):
    """Relative luminance of linear Rec. 709 [ITU-R BT.709]."""
    return 0.2126 * a[0] + 0.7152 * a[1] + 0.0722 * a[2]


@kernel
def basis(n):
    """Two unit tangents that make a right-handed frame (s, t, n) [Duff et al. 2017, JCGT 6(1)]."""
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


@kernel
def to_world(v, n):
    """Local direction v (z along the unit normal n) in world space."""
    s, t = basis(n)
    return (
        v[0] * s[0] + v[1] * t[0] + v[2] * n[0],
        v[0] * s[1] + v[1] * t[1] + v[2] * n[1],
        v[0] * s[2] + v[1] * t[2] + v[2] * n[2],
    )
