"""The GGX distribution of microfacets with Smith's height-correlated masking, round or stretched."""

from __future__ import annotations

import math

from ..jit import kernel
from ..sampling.warps import turn
from ..vec import basis, cross, dot

DELTA_ALPHA = 1e-4  # below this a lobe is handled as a perfect mirror or a perfect refraction
NEARLY_ONE = 1e-4  # an index of refraction this close to 1 bends nothing


@kernel
def ggx_d(sin2_h, alpha2):
    """Density of facet normals, D(h) = a^2 / (pi (sin^2 + a^2 cos^2)^2) [Walter et al. 2007, Eq. 33].

    sin2_h : squared sine between h and the normal (better than the cosine for a small a).
    """
    x = sin2_h + alpha2 * (1.0 - sin2_h)
    return alpha2 / (math.pi * x * x)


@kernel
def ggx_lambda(cos_w, alpha2):
    """Smith's Lambda of GGX [Heitz 2014, Eq. 72]: G1 = 1 / (1 + Lambda)."""
    c2 = cos_w * cos_w
    return 0.5 * (math.sqrt(1.0 + alpha2 * max(1.0 / c2 - 1.0, 0.0)) - 1.0)


@kernel
def sin2_between(a, b):
    """Squared sine between two unit vectors, without cancellation."""
    c = cross(a, b)
    return dot(c, c)


@kernel
def ggx_d_stretched(h, ax, ay):
    """Density of facet normals h = (x, y, z), local, of widths ax, ay [Heitz 2014, Eq. 85]."""
    x, y = h[0] / ax, h[1] / ay
    k = x * x + y * y + h[2] * h[2]
    return 1.0 / (math.pi * ax * ay * k * k)


@kernel
def ggx_lambda_stretched(w, ax, ay):
    """Smith's Lambda of a local direction for widths ax, ay [Heitz 2014, Eq. 86]."""
    x, y = ax * w[0], ay * w[1]
    return 0.5 * (math.sqrt(1.0 + (x * x + y * y) / (w[2] * w[2])) - 1.0)


@kernel
def frame_along(n, tangent):
    """Unit tangents (s, t) about the unit normal n, s along the given direction; any when that has no direction."""
    t = cross(n, tangent)
    size = math.sqrt(dot(t, t))
    if size < 1e-12:
        return basis(n)
    t = (t[0] / size, t[1] / size, t[2] / size)
    return cross(t, n), t


@kernel
def sample_vndf(wo, n, alpha, u1, u2):
    """`sample_vndf_stretched` with the same width all round."""
    s, t = basis(n)
    return sample_vndf_stretched(wo, (s, t, n), alpha, alpha, (u1, u2))


@kernel
def sample_vndf_stretched(wo, frame, ax, ay, u):
    """Facet normal h seen from wo, in world space, with density G1(wo) max(0, wo.h) D(h) / (n.wo).

    Spherical caps [Dupuy and Benyoub 2023, Listing 3].  wo : unit, n.wo > 0;  frame : unit (s, t, n);  ax, ay : widths
    along s and t;  u : two numbers in [0, 1).
    """
    s, t, n = frame
    x = ax * dot(wo, s)
    y = ay * dot(wo, t)
    z = dot(wo, n)
    k = 1.0 / math.sqrt(x * x + y * y + z * z)
    x *= k
    y *= k
    z *= k
    cos_phi, sin_phi = turn(u[0])
    cap = (1.0 - u[1]) * (1.0 + z) - z
    sin_cap = math.sqrt(max(1.0 - cap * cap, 0.0))
    hx = ax * (sin_cap * cos_phi + x)
    hy = ay * (sin_cap * sin_phi + y)
    hz = max(cap + z, 0.0)
    k = 1.0 / math.sqrt(hx * hx + hy * hy + hz * hz)
    hx *= k
    hy *= k
    hz *= k
    return (
        hx * s[0] + hy * t[0] + hz * n[0],
        hx * s[1] + hy * t[1] + hz * n[1],
        hx * s[2] + hy * t[2] + hz * n[2],
    )
