"""From a hit to a surface point, and back off the surface without hitting it again."""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel
from ..vec import cross, dot, load3, normalize, sub

# Embree's robust mode and the barycentric point below err by a few ulp of the largest coordinate; 2^-24 is half an
# ulp of single precision, and 32 of them left no self-intersection in 10^8 rays (see tests/test_surface.py)
RELATIVE_OFFSET = 32.0 * 2.0**-24


@kernel
def surface_point(geometry, prim, u, v):
    """Point, geometric normal and shading normal of a hit; ng faces outward, ns as the mesh says.

    A triangle without area has no normal and Embree never returns it.
    """
    a, b, c = corners(geometry, prim)
    ng = face_normal(a, b, c)
    return between(a, b, c, u, v), ng, unit_or(smooth_normal(geometry, prim, u, v), ng)


@kernel
def corners(geometry, prim):
    """The three corners of a triangle."""
    t = geometry.triangles
    p = geometry.positions
    return load3(p, t[prim, 0]), load3(p, t[prim, 1]), load3(p, t[prim, 2])


@kernel
def between(a, b, c, u, v):
    """The point of the triangle a, b, c with barycentric weights u of b and v of c."""
    w = 1.0 - u - v
    return (w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1], w * a[2] + u * b[2] + v * c[2])


@kernel
def face_normal(a, b, c):
    """Unit normal of the triangle a, b, c, by its corners' order."""
    return normalize(cross(sub(b, a), sub(c, a)))


@kernel
def smooth_normal(geometry, prim, u, v):
    """Interpolated normal of the corners, not of unit length; zero for a flat triangle."""
    return mixed_normal(geometry.normals, geometry.normal_row[prim], u, v)


@kernel
def mixed_normal(normals, row, u, v):
    """`smooth_normal` from the row of the triangle's normals, below 0 for a flat one."""
    if row < 0:
        return (0.0, 0.0, 0.0)
    m = normals
    w = 1.0 - u - v
    return (
        w * m[row, 0, 0] + u * m[row, 1, 0] + v * m[row, 2, 0],
        w * m[row, 0, 1] + u * m[row, 1, 1] + v * m[row, 2, 1],
        w * m[row, 0, 2] + u * m[row, 1, 2] + v * m[row, 2, 2],
    )


@kernel
def unit_or(n, other):
    """N / |n|, or the other vector where n is zero."""
    size = math.sqrt(dot(n, n))
    if size > 0.0:
        return (n[0] / size, n[1] / size, n[2] / size)
    return other


@kernel
def half_extent(a, b, c):
    """Half the longest side of the box around the triangle a, b, c."""
    x = max(a[0], max(b[0], c[0])) - min(a[0], min(b[0], c[0]))
    y = max(a[1], max(b[1], c[1])) - min(a[1], min(b[1], c[1]))
    z = max(a[2], max(b[2], c[2])) - min(a[2], min(b[2], c[2]))
    return 0.5 * max(x, max(y, z))


@kernel
def leave(geometry, prim, p, ng, w):
    """Origin of a ray that leaves the point p of triangle `prim` along w."""
    a, b, c = corners(geometry, prim)
    return offset_origin(p, ng, w, half_extent(a, b, c))


@kernel
def offset_origin(p, ng, w, reach):
    """Origin of a ray that leaves p along w, moved off the surface by the rounding errors that could bring it back.

    reach : `half_extent` of the triangle of p. The origin is stored in single precision, by which it errs as |p| does;
    Embree takes the corners relative to the origin, by which the triangle's plane errs as its size does. Not the size
    of others: beside a floor of 100 m a pane of glass may be a hair thin.
    """
    size = max(abs(p[0]), max(abs(p[1]), abs(p[2])))
    step = math.copysign(RELATIVE_OFFSET * max(size, 0.125 * reach), dot(w, ng))
    return (p[0] + step * ng[0], p[1] + step * ng[1], p[2] + step * ng[2])


@kernel
def surface_points(geometry, prim, u, v, out_p, out_ng, out_ns):
    """surface_point of a batch; prim (n,) i32, outputs (n, 3) f32."""
    for i in range(len(prim)):
        p, ng, ns = surface_point(geometry, prim[i], float(u[i]), float(v[i]))
        for k in range(3):
            out_p[i, k] = np.float32(p[k])
            out_ng[i, k] = np.float32(ng[k])
            out_ns[i, k] = np.float32(ns[k])
