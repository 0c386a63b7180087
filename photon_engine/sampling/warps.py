"""Maps from the unit square to shapes and directions, each with its density.

Every warp is a pair: ``square_to_X(u0, u1, ...)`` and ``X_pdf(...)``, the density in the measure that its docstring
names. Local directions have z along the axis or normal.
"""

from __future__ import annotations

import math

from ..jit import kernel

INV_PI = 1.0 / math.pi
INV_4PI = 0.25 / math.pi


@kernel
def small_turn(x):
    """(cos, sin) of an angle within an eighth of a turn, |x| <= pi / 4: Taylor, error below 1e-13."""
    y = x * x
    s = 1 / 362880 + y * (-1 / 39916800 + y / 6227020800)
    s = x * (1.0 + y * (-1 / 6 + y * (1 / 120 + y * (-1 / 5040 + y * s))))
    c = -1 / 3628800 + y * (1 / 479001600 - y / 87178291200)
    c = 1.0 + y * (-0.5 + y * (1 / 24 + y * (-1 / 720 + y * (1 / 40320 + y * c))))
    return c, s


@kernel
def turn(u):
    """(cos, sin) of 2 pi u for u in [0, 1), a third of the cost of the library's: error below 1e-13.

    The quadrant's multiple of a quarter turn is taken off and put back by exchanging the two.
    """
    q = int(4.0 * u + 0.5)
    c, s = small_turn(2.0 * math.pi * (u - 0.25 * q))
    if q & 1:
        c, s = -s, c
    if q & 2:
        c, s = -c, -s
    return c, s


@kernel
def square_to_disk(u0, u1):
    """Point (x, y) of the unit disk, uniform in area, concentric map [Shirley and Chiu 1997, JGT 2(3)]."""
    a = 2.0 * u0 - 1.0
    b = 2.0 * u1 - 1.0
    wide = abs(a) > abs(b)
    r = a if wide else b
    if r == 0.0:
        return 0.0, 0.0
    c, s = small_turn(0.25 * math.pi * (b if wide else a) / r)
    return (r * c, r * s) if wide else (r * s, r * c)


@kernel
def disk_pdf(x, y):
    """Density of `square_to_disk` in area."""
    return INV_PI if x * x + y * y <= 1.0 else 0.0


@kernel
def square_to_cosine_hemisphere(u0, u1):
    """Unit direction with density cos / pi about +z [Malley; Pharr et al. 2023, A.5.3]."""
    x, y = square_to_disk(u0, u1)
    return (x, y, math.sqrt(max(0.0, 1.0 - x * x - y * y)))


@kernel
def cosine_hemisphere_pdf(cos_theta):
    """Density of `square_to_cosine_hemisphere` in solid angle."""
    return max(cos_theta, 0.0) * INV_PI


@kernel
def square_to_sphere(u0, u1):
    """Unit direction, uniform over the sphere."""
    z = 1.0 - 2.0 * u0
    r = 2.0 * math.sqrt(max(0.0, u0 * (1.0 - u0)))
    c, s = turn(u1)
    return (r * c, r * s, z)


@kernel
def sphere_pdf():
    """Density of `square_to_sphere` in solid angle."""
    return INV_4PI


@kernel
def one_minus_cos(sin_squared):
    """1 - cos(theta) of an angle below 90 degrees from sin^2(theta), without cancellation for small ones."""
    return sin_squared / (1.0 + math.sqrt(max(0.0, 1.0 - sin_squared)))


@kernel
def square_to_cone(u0, u1, one_minus_cos_max):
    """Unit direction, uniform in solid angle within a cone about +z; the cone is given by 1 - cos of its half angle."""
    h = u0 * one_minus_cos_max
    r = math.sqrt(max(0.0, h * (2.0 - h)))
    c, s = turn(u1)
    return (r * c, r * s, 1.0 - h)


@kernel
def cone_pdf(one_minus_cos_theta, one_minus_cos_max):
    """Density of `square_to_cone` in solid angle."""
    return 1.0 / (2.0 * math.pi * one_minus_cos_max) if one_minus_cos_theta <= one_minus_cos_max else 0.0


@kernel
def square_to_triangle(u0, u1):
    """Barycentric coordinates (b1, b2) of a point uniform over a triangle [Heitz 2019, low distortion map]."""
    if u0 < u1:
        b1 = 0.5 * u0
        return b1, u1 - b1
    b2 = 0.5 * u1
    return u0 - b2, b2


@kernel
def triangle_pdf(b1, b2):
    """Density of `square_to_triangle` in the (b1, b2) plane, whose triangle has area 1/2."""
    return 2.0 if b1 >= 0.0 and b2 >= 0.0 and b1 + b2 <= 1.0 else 0.0


@kernel
def _rect_normals(x0, x1, y0, y1, h):
    """Products of the z components of neighbouring edge normals' cosines as arcsines [Urena 2013, section 4.1]."""
    n0 = -y0 / math.sqrt(h * h + y0 * y0)
    n1 = x1 / math.sqrt(h * h + x1 * x1)
    n2 = y1 / math.sqrt(h * h + y1 * y1)
    n3 = -x0 / math.sqrt(h * h + x0 * x0)
    return n0, n1, n2, n3


@kernel
def _asin(x):
    """Arcsine of a value that rounding may have pushed outside [-1, 1]."""
    return math.asin(min(1.0, max(-1.0, x)))


@kernel
def rectangle_solid_angle(x0, x1, y0, y1, h):
    """Solid angle [sr] of the rectangle [x0, x1] x [y0, y1] in the plane at distance h > 0 [Urena 2013, Eq. 3].

    Written with arcsines, whose sum does not cancel against 2 pi for small rectangles.
    """
    n0, n1, n2, n3 = _rect_normals(x0, x1, y0, y1, h)
    return _asin(n0 * n1) + _asin(n1 * n2) + _asin(n2 * n3) + _asin(n3 * n0)


@kernel
def square_to_rectangle_w(u0, u1, x0, x1, y0, y1, h):
    """Point (x, y) of a rectangle at distance h, uniform in solid angle from the origin [Urena et al. 2013, section 4].

    Its density in solid angle is 1 / `rectangle_solid_angle`.
    """
    n0, n1, n2, n3 = _rect_normals(x0, x1, y0, y1, h)
    g2 = _asin(-n2 * n3)
    g3 = _asin(-n3 * n0)
    total = -(_asin(-n0 * n1) + _asin(-n1 * n2) + g2 + g3)
    au = u0 * total + g2 + g3
    sin_au = math.sin(au)
    fu = (math.cos(au) * n0 + n2) / sin_au if sin_au != 0.0 else math.copysign(math.inf, n0 + n2)
    cu = math.copysign(1.0 / math.sqrt(fu * fu + n0 * n0), fu)
    cu = min(1.0, max(-1.0, cu))
    x = min(x1, max(x0, cu * h / math.sqrt(max(1.0 - cu * cu, 1e-300))))
    d2 = x * x + h * h
    h0 = y0 / math.sqrt(d2 + y0 * y0)
    h1 = y1 / math.sqrt(d2 + y1 * y1)
    hv = h0 + u1 * (h1 - h0)
    y = min(y1, max(y0, hv * math.sqrt(d2 / max(1.0 - hv * hv, 1e-300))))
    return x, y


@kernel
def rectangle_w_pdf(x0, x1, y0, y1, h):
    """Density of `square_to_rectangle_w` in solid angle."""
    return 1.0 / rectangle_solid_angle(x0, x1, y0, y1, h)
