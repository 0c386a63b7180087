"""Kernels for shading normals, where numpy would need twenty passes over the batch."""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from ...vec import cross, dot, load3, normalize, scale, store3


@kernel
def outward_rows(normals, ns, backfacing, out):
    """Unit normals (n | 1, 3), given on the side that was hit, turned outward; the surface's own where they vanish."""
    step = 0 if len(normals) == 1 else 1
    for i in range(len(ns)):
        n = normalize(load3(normals, i * step))
        if dot(n, n) == 0.0:
            n = load3(ns, i)
        elif backfacing[i]:
            n = scale(n, -1.0)
        store3(out, i, n)


@kernel
def tangent_rows(color, strength, tangent, normal_local, inverse, instance, out):
    """World normals, outward, from tangent-space components 2 color - 1; zero where the sum vanishes.

    The frame is the mesh's own, interpolated and not normalised: T, sign N x T, N [Mikkelsen 2008]. Strength s scales
    the first two components and moves the third from 1. color, strength : n | 1 rows;  inverse : (I, 3, 3) f32
    """
    color_step = 0 if len(color) == 1 else 1
    strength_step = 0 if len(strength) == 1 else 1
    for i in range(len(out)):
        s = float(strength[i * strength_step])
        c = load3(color, i * color_step)
        x, y = (2.0 * c[0] - 1.0) * s, (2.0 * c[1] - 1.0) * s
        z = 1.0 + min(max(s, 0.0), 1.0) * (2.0 * c[2] - 2.0)
        t, n = load3(tangent, i), load3(normal_local, i)
        b = scale(cross(n, t), float(tangent[i, 3]))
        v = (x * t[0] + y * b[0] + z * n[0], x * t[1] + y * b[1] + z * n[1], x * t[2] + y * b[2] + z * n[2])
        m = inverse[instance[i]]
        w = (
            m[0, 0] * v[0] + m[1, 0] * v[1] + m[2, 0] * v[2],
            m[0, 1] * v[0] + m[1, 1] * v[1] + m[2, 1] * v[2],
            m[0, 2] * v[0] + m[1, 2] * v[1] + m[2, 2] * v[2],
        )
        store3(out, i, normalize(w))


def contiguous(values: np.ndarray) -> np.ndarray:
    """The array as the kernels were compiled for it: float32, C order."""
    return np.ascontiguousarray(values, np.float32)
