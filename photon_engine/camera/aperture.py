"""Points on the lens: a disk or a regular polygon of radius 1."""

from __future__ import annotations

import math

from ..jit import kernel


@kernel
def sample_disk(u0, u1):
    """Uniform point on the unit disk; concentric map [Shirley and Chiu 1997]."""
    a = 2.0 * u0 - 1.0
    b = 2.0 * u1 - 1.0
    if a == 0.0 and b == 0.0:
        return (0.0, 0.0)
    if a * a > b * b:
        r = a
        phi = 0.25 * math.pi * (b / a)
    else:
        r = b
        phi = 0.5 * math.pi - 0.25 * math.pi * (a / b)
    return (r * math.cos(phi), r * math.sin(phi))


@kernel
def sample_polygon(blades, rotation, u0, u1):
    """Uniform point in the regular polygon with corners on the unit circle.

    Corners lie at rotation + (2 k + 1) pi / blades [rad], as in Cycles. u0 chooses the wedge and, stretched again, the
    point in it.
    """
    wedge = min(math.floor(u0 * blades), blades - 1.0)
    s = math.sqrt(u0 * blades - wedge)
    t = u1 * s
    half = math.pi / blades
    # the wedge is the triangle of the centre and two neighbouring corners: barycentric weights 1 - s, s - t, t
    x = s * math.cos(half)
    y = (s - 2.0 * t) * math.sin(half)
    angle = rotation + 2.0 * half * wedge
    c = math.cos(angle)
    n = math.sin(angle)
    return (c * x - n * y, n * x + c * y)


@kernel
def sample_aperture(blades, rotation, inv_ratio, u0, u1):
    """Uniform point on the aperture, radius 1; ``inv_ratio`` squeezes it horizontally (anamorphic lens)."""
    if blades < 3:
        x, y = sample_disk(u0, u1)
    else:
        x, y = sample_polygon(blades, rotation, u0, u1)
    return (x * inv_ratio, y)
