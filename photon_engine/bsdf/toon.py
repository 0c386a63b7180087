"""TOON and TOON_GLOSSY lobes: an even cone about the normal, or about the mirrored view, with a soft rim.

f is that of Blender's node: the density of the cone times the rim's intensity, over the cosine of the light.
"""

from __future__ import annotations

import math

from ..jit import kernel
from ..sampling.warps import turn
from ..vec import dot, reflect, to_world
from .layout import IOR, ROUGHNESS, TOON

HALF_PI = 0.5 * math.pi
LEAST_COSINE = 1e-3  # what a light at grazing counts as


@kernel
def toon_cone(rows, row, k):
    """(angle of full intensity, width of the rim, angle of the cone that is sampled) [rad]."""
    size = min(max(float(rows.params[row, k, ROUGHNESS]), 1e-5), 1.0) * HALF_PI
    rim = min(max(float(rows.params[row, k, IOR]), 0.0), 1.0) * HALF_PI
    return size, rim, min(size + rim, HALF_PI)


@kernel
def toon_axis(rows, row, k, n, view):
    """The middle of the cone."""
    return n if rows.kind[row, k] == TOON else reflect(view, n)


@kernel
def toon_value(rows, row, k, n, view, light):
    """(f without cosine [1/sr], density of a direction drawn from the cone)."""
    cos_i = dot(n, light)
    if cos_i <= 0.0 or dot(n, view) <= 0.0:
        return 0.0, 0.0
    size, rim, cone = toon_cone(rows, row, k)
    angle = math.acos(min(max(dot(toon_axis(rows, row, k, n, view), light), 0.0), 1.0))
    if angle >= cone:
        return 0.0, 0.0
    half = math.sin(0.5 * cone)
    pdf = 1.0 / (4.0 * math.pi * half * half)
    level = 1.0 if angle < size else 1.0 - (angle - size) / rim
    return pdf * level / max(cos_i, LEAST_COSINE), pdf


@kernel
def toon_direction(rows, row, k, n, view, u1, u2):
    """Direction even in the cone."""
    half = math.sin(0.5 * toon_cone(rows, row, k)[2])
    height = 2.0 * half * half * u1
    r = math.sqrt(max(height * (2.0 - height), 0.0))
    c, s = turn(u2)
    return to_world((r * c, r * s, 1.0 - height), toon_axis(rows, row, k, n, view))
