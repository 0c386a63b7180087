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
    a = load3(geometry.positions, geometry.triangles[prim, 0])
    b = load3(geometry.positions, geometry.triangles[prim, 1])
    c = load3(geometry.positions, geometry.triangles[prim, 2])
    w = 1.0 - u - v
    p = (w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1], w * a[2] + u * b[2] + v * c[2])
    ng = normalize(cross(sub(b, a), sub(c, a)))
    row = geometry.normal_row[prim]
    ns = ng
    if row >= 0:
        m = geometry.normals[row]
        x = w * m[0, 0] + u * m[1, 0] + v * m[2, 0]
        y = w * m[0, 1] + u * m[1, 1] + v * m[2, 1]
        z = w * m[0, 2] + u * m[1, 2] + v * m[2, 2]
        size = math.sqrt(x * x + y * y + z * z)
        if size > 0.0:
            ns = (x / size, y / size, z / size)
    return p, ng, ns


@kernel
def offset_origin(p, ng, w, reach):
    """Origin of a ray that leaves p along w, moved off the surface by the rounding error of p.

    reach : radius of the scene, whose rounding the triangles' vertices carry.
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
