"""Area lamps: rectangles and ellipses that shine along their normal, with an optional spread."""

from __future__ import annotations

import math

from ..jit import inlined
from ..sampling.warps import rectangle_solid_angle, square_to_disk, square_to_rectangle_w
from ..vec import add, dot, load3, madd, scale, sub
from .table import DELTA, ELLIPSE, FOCUSED

MIN_SOLID_ANGLE = 1e-7  # below it [sr] rounding spoils the solid angle, and the area measure is as good
NEAR = 4.0  # an ellipse closer than this many half axes is sampled through its rectangle's solid angle

# how a point on the lamp is chosen
BY_NOTHING, BY_SOLID_ANGLE, BY_RECTANGLE, BY_ELLIPSE = range(4)


@inlined
def area_gain(lights, l, cos_light):
    """Radiance relative to radiance[l] at cos_light from the normal: a soft box's grid, (tan h - tan a)/(tan h - h)."""
    if cos_light <= 0.0:
        return 0.0
    if not lights.flags[l] & FOCUSED:
        return 1.0
    tangent = math.sqrt(max(0.0, 1.0 - cos_light * cos_light)) / cos_light
    return max(0.0, (lights.cone[l, 0] - tangent) * lights.cone[l, 1])


@inlined
def area_inside(lights, l, x, y):
    """Whether (x, y) [m] in the lamp's plane, from its centre along its axes, is on the lamp."""
    a = x / lights.size[l, 0]
    b = y / lights.size[l, 1]
    if lights.flags[l] & ELLIPSE:
        return a * a + b * b <= 1.0
    return abs(a) <= 1.0 and abs(b) <= 1.0


@inlined
def area_local(lights, l, p):
    """The point p relative to the lamp: (x, y) along its axes and height [m] in front of it."""
    r = sub(p, load3(lights.position, l))
    return dot(r, load3(lights.axis_u, l)), dot(r, load3(lights.axis_v, l)), dot(r, load3(lights.normal, l))


@inlined
def area_point(lights, l, x, y):
    """Point in the lamp's plane at (x, y) from its centre."""
    p = load3(lights.position, l)
    return madd(madd(p, x, load3(lights.axis_u, l)), y, load3(lights.axis_v, l))


@inlined
def area_strategy(lights, l, p):
    """How to sample the lamp from p: (strategy, density, (x0, x1, y0, y1) relative to p, height).

    The rectangle is the lamp's, clipped to what its spread lets p see; density is per sr for BY_SOLID_ANGLE and per m^2
    else. Depends on p alone, so that the density of a direction can be found again for MIS.
    """
    x, y, height = area_local(lights, l, p)
    half_u = lights.size[l, 0]
    half_v = lights.size[l, 1]
    if height <= 1e-12 * (half_u + half_v):
        return BY_NOTHING, 0.0, (0.0, 0.0, 0.0, 0.0), 0.0
    x0 = -half_u - x
    x1 = half_u - x
    y0 = -half_v - y
    y1 = half_v - y
    if lights.flags[l] & FOCUSED:
        reach = height * lights.cone[l, 0]
        x0 = max(x0, -reach)
        x1 = min(x1, reach)
        y0 = max(y0, -reach)
        y1 = min(y1, reach)
        if x0 >= x1 or y0 >= y1:
            return BY_NOTHING, 0.0, (0.0, 0.0, 0.0, 0.0), 0.0
    rect = (x0, x1, y0, y1)
    flat = (x1 - x0) * (y1 - y0)
    if lights.flags[l] & ELLIPSE and flat >= lights.size[l, 2]:
        longest = NEAR * max(half_u, half_v)
        if x * x + y * y + height * height > longest * longest:
            return BY_ELLIPSE, 1.0 / lights.size[l, 2], rect, height
    omega = rectangle_solid_angle(x0, x1, y0, y1, height)
    if omega > MIN_SOLID_ANGLE:
        return BY_SOLID_ANGLE, 1.0 / omega, rect, height
    return BY_RECTANGLE, 1.0 / flat, rect, height


@inlined
def area_sample(lights, l, p, u0, u1):
    """A direction from p to the lamp: (wi, distance, gain, pdf_w); gain = 0 where nothing arrives."""
    strategy, density, rect, height = area_strategy(lights, l, p)
    if strategy == BY_NOTHING:
        return (0.0, 0.0, 1.0), 0.0, 0.0, 0.0
    x, y, _ = area_local(lights, l, p)
    if strategy == BY_SOLID_ANGLE:
        a, b = square_to_rectangle_w(u0, u1, rect[0], rect[1], rect[2], rect[3], height)
    elif strategy == BY_RECTANGLE:
        a = rect[0] + u0 * (rect[1] - rect[0])
        b = rect[2] + u1 * (rect[3] - rect[2])
    else:
        a, b = square_to_disk(u0, u1)
        a = a * lights.size[l, 0] - x
        b = b * lights.size[l, 1] - y
    distance = math.sqrt(a * a + b * b + height * height)
    inv = 1.0 / distance
    cos_light = height * inv
    across = add(scale(load3(lights.axis_u, l), a * inv), scale(load3(lights.axis_v, l), b * inv))
    wi = madd(across, -cos_light, load3(lights.normal, l))
    pdf_w = density if strategy == BY_SOLID_ANGLE else density * distance * distance / cos_light
    # only an ellipse inside its rectangle can be missed; rounding must not drop a rectangle's border
    seen = not lights.flags[l] & ELLIPSE or area_inside(lights, l, a + x, b + y)
    return wi, distance, area_gain(lights, l, cos_light) if seen else 0.0, pdf_w


@inlined
def area_hit(lights, l, o, d):
    """Where a ray from o along d meets the front of the lamp: (distance, cos_light); distance inf: it does not."""
    if lights.flags[l] & DELTA:
        return math.inf, 0.0
    cos_light = -dot(d, load3(lights.normal, l))
    if cos_light <= 0.0:
        return math.inf, 0.0
    x, y, height = area_local(lights, l, o)
    t = height / cos_light
    if t <= 0.0:
        return math.inf, 0.0
    x += t * dot(d, load3(lights.axis_u, l))
    y += t * dot(d, load3(lights.axis_v, l))
    return (t, cos_light) if area_inside(lights, l, x, y) else (math.inf, 0.0)


@inlined
def area_pdf_w(lights, l, p, distance, cos_light):
    """Density in solid angle with which `area_sample` from p finds the point hit at `distance` under `cos_light`."""
    strategy, density, _, _ = area_strategy(lights, l, p)
    if strategy == BY_NOTHING or cos_light <= 0.0:
        return 0.0
    return density if strategy == BY_SOLID_ANGLE else density * distance * distance / cos_light


@inlined
def beam_sample(lights, l, p):
    """Parallel rays (spread 0): (wi, distance, seen) of the one direction from which light arrives at p."""
    x, y, height = area_local(lights, l, p)
    return scale(load3(lights.normal, l), -1.0), height, height > 0.0 and area_inside(lights, l, x, y)
