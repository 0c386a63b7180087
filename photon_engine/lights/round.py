"""Point and spot lamps: a point, a sphere, or a disk that faces whoever looks (soft falloff); a spot's falloff."""

from __future__ import annotations

import math

from ..jit import inlined
from ..sampling.warps import INV_4PI, one_minus_cos, square_to_cone, square_to_sphere
from ..vec import dot, load3, scale, sub, to_world
from .table import DELTA, SOFT, SPOT


@inlined
def transform(matrix, l, v):
    """matrix[l] @ v for an (L, 3, 3) array."""
    return (
        matrix[l, 0, 0] * v[0] + matrix[l, 0, 1] * v[1] + matrix[l, 0, 2] * v[2],
        matrix[l, 1, 0] * v[0] + matrix[l, 1, 1] * v[1] + matrix[l, 1, 2] * v[2],
        matrix[l, 2, 0] * v[0] + matrix[l, 2, 1] * v[1] + matrix[l, 2, 2] * v[2],
    )


@inlined
def smoothstep(x):
    """3 x^2 - 2 x^3 on [0, 1], constant outside."""
    x = min(1.0, max(0.0, x))
    return x * x * (3.0 - 2.0 * x)


@inlined
def spot_falloff(lights, l, d):
    """A spot's factor on light that travels along d, angles taken in the lamp's local space; 1 for other kinds."""
    if lights.kind[l] != SPOT:
        return 1.0
    v = transform(lights.to_local, l, d)
    excess = -v[2] / math.sqrt(dot(v, v)) - lights.cone[l, 0]
    width = (1.0 - lights.cone[l, 0]) * lights.cone[l, 1]
    if width <= 0.0:
        return 1.0 if excess > 0.0 else 0.0
    return smoothstep(excess / width)


@inlined
def round_cone(lights, l, distance):
    """1 - cos of the half angle that the lamp fills seen from `distance` [m]; 2 (everything) inside a sphere."""
    r2 = lights.size[l, 0] * lights.size[l, 0]
    d2 = distance * distance
    if lights.flags[l] & SOFT:
        return one_minus_cos(r2 / (d2 + r2))
    return one_minus_cos(r2 / d2) if d2 > r2 else 2.0


@inlined
def round_distance(lights, l, distance, cos_theta):
    """Distance [m] along a ray at cos_theta from the direction to the centre, which is `distance` away."""
    if lights.flags[l] & SOFT:
        return distance / cos_theta
    radius = lights.size[l, 0]
    along = distance * cos_theta
    # cos_theta^2 d^2 - d^2 + r^2 without the cancellation of two large squares
    half_chord = math.sqrt(max(0.0, (radius - distance) * (radius + distance) + along * along))
    return along - half_chord if distance > radius else along + half_chord


@inlined
def round_gain(lights, l, d, distance):
    """Radiance relative to radiance[l] of light along d that arrives at `distance` from the centre."""
    if distance < lights.size[l, 0] and not lights.flags[l] & SOFT:
        return 1.0  # within the sphere Cycles leaves the falloff out
    return spot_falloff(lights, l, d)


@inlined
def round_sample(lights, l, p, u0, u1):
    """A direction from p to the lamp, uniform over the solid angle it fills: (wi, distance, gain, pdf_w).

    A point (DELTA): pdf_w = 1 and gain holds 1 / d^2. gain = 0 where nothing arrives.
    """
    r = sub(load3(lights.position, l), p)
    d2 = dot(r, r)
    if d2 == 0.0:
        return (0.0, 0.0, 1.0), 0.0, 0.0, 0.0
    d = math.sqrt(d2)
    axis = scale(r, 1.0 / d)
    if lights.flags[l] & DELTA:
        return axis, d, spot_falloff(lights, l, scale(axis, -1.0)) / d2, 1.0
    h = round_cone(lights, l, d)
    if h < 2.0:
        local = square_to_cone(u0, u1, h)
        wi = to_world(local, axis)
        cos_theta = local[2]
        pdf_w = 1.0 / (2.0 * math.pi * h)
    else:
        wi = square_to_sphere(u0, u1)
        cos_theta = dot(wi, axis)
        pdf_w = INV_4PI
    return wi, round_distance(lights, l, d, cos_theta), round_gain(lights, l, scale(wi, -1.0), d), pdf_w


@inlined
def round_hit(lights, l, o, d):
    """Where a ray from o along d meets the lamp: (distance, gain, pdf_w of `round_sample`); distance inf: nowhere."""
    if lights.flags[l] & DELTA:
        return math.inf, 0.0, 0.0
    r = sub(load3(lights.position, l), o)
    along = dot(r, d)
    distance = math.sqrt(dot(r, r))
    radius = lights.size[l, 0]
    inside = distance <= radius and not lights.flags[l] & SOFT
    if distance == 0.0 or (along <= 0.0 and not inside):
        return math.inf, 0.0, 0.0
    # impact parameter squared, from the part of r across d
    across = (r[0] - along * d[0], r[1] - along * d[1], r[2] - along * d[2])
    b2 = dot(across, across)
    limit = radius * along / distance if lights.flags[l] & SOFT else radius
    # a disk facing o fills tan(theta) = b / along < radius / distance
    if b2 > limit * limit:
        return math.inf, 0.0, 0.0
    h = round_cone(lights, l, distance)
    t = round_distance(lights, l, distance, along / distance)
    return t, round_gain(lights, l, scale(d, -1.0), distance), 1.0 / (2.0 * math.pi * h)
