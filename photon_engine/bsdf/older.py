"""Other facets than GGX's: Beckmann's, and the lobe of Ashikhmin and Shirley. Directions are local: z is the normal."""

from __future__ import annotations

import math

from ..jit import kernel
from ..sampling.warps import turn
from ..vec import dot
from .layout import BECKMANN
from .microfacet import ggx_d, ggx_lambda

LEAST_ALPHA = 1e-4


@kernel
def beckmann_d(h, ax, ay):
    """Density of facet normals of widths ax, ay [Heitz 2014, Eq. 76]."""
    z2 = h[2] * h[2]
    if z2 <= 0.0:
        return 0.0
    x, y = h[0] / ax, h[1] / ay
    return math.exp(-(x * x + y * y) / z2) / (math.pi * ax * ay * z2 * z2)


@kernel
def beckmann_lambda(w, ax, ay):
    """Smith's Lambda by the rational approximation that Cycles uses too [Walter et al. 2007, p. 202]."""
    x, y = ax * w[0], ay * w[1]
    slope2 = x * x + y * y
    if slope2 <= 0.0:
        return 0.0
    a = abs(w[2]) / math.sqrt(slope2)
    if a >= 1.6:
        return 0.0
    return (1.0 + (0.396 * a - 1.259) * a) / ((3.535 + 2.181 * a) * a)


@kernel
def facet_d(shape, sin2_h, alpha2):
    """Density of facet normals, round, of Beckmann's shape or GGX's; sin2_h as in `microfacet.ggx_d`."""
    if shape != BECKMANN:
        return ggx_d(sin2_h, alpha2)
    c2 = 1.0 - sin2_h
    return math.exp(-sin2_h / (c2 * alpha2)) / (math.pi * alpha2 * c2 * c2) if c2 > 0.0 else 0.0


@kernel
def facet_lambda(shape, cos_w, alpha2):
    """Smith's Lambda, round, of Beckmann's shape or GGX's."""
    if shape != BECKMANN:
        return ggx_lambda(cos_w, alpha2)
    a = math.sqrt(alpha2)
    return beckmann_lambda((math.sqrt(max(1.0 - cos_w * cos_w, 0.0)), 0.0, cos_w), a, a)


@kernel
def exponent(alpha):
    """Of the lobe of Ashikhmin and Shirley that is as wide, as Cycles has it."""
    a = min(max(alpha, LEAST_ALPHA), 1.0)
    return 2.0 / (a * a) - 2.0


@kernel
def sample_older(shape, ax, ay, u1, u2):
    """A local facet normal, of density `D (n.h)` (Beckmann) or in proportion to the lobe."""
    cos_phi, sin_phi = turn(u1)
    if shape == BECKMANN:
        r = math.sqrt(max(-math.log(1.0 - u2), 0.0))
        x, y, z = ax * r * cos_phi, ay * r * sin_phi, 1.0
    else:
        nx, ny = exponent(ax), exponent(ay)
        x, y = math.sqrt(ny + 1.0) * cos_phi, math.sqrt(nx + 1.0) * sin_phi
        k = 1.0 / math.sqrt(x * x + y * y)
        x, y = x * k, y * k
        z = (1.0 - u2) ** (1.0 / (nx * x * x + ny * y * y + 1.0))
        r = math.sqrt(max(1.0 - z * z, 0.0))
        return (r * x, r * y, z)
    k = 1.0 / math.sqrt(x * x + y * y + z * z)
    return (x * k, y * k, z * k)


@kernel
def value_older(shape, h, wo, wi, ax, ay):
    """(f without Fresnel and cosine [1/sr], pdf_w of wo mirrored in `sample_older`'s facets); wo, wi above the surface.

    Ashikhmin and Shirley 2000, Eq. 4 and 8, without their Fresnel factor.
    """
    c = max(abs(dot(h, wo)), 1e-9)
    if shape == BECKMANN:
        d = beckmann_d(h, ax, ay)
        g = 1.0 / (1.0 + beckmann_lambda(wo, ax, ay) + beckmann_lambda(wi, ax, ay))
        return d * g / (4.0 * wo[2] * wi[2]), d * h[2] / (4.0 * c)
    nx, ny = exponent(ax), exponent(ay)
    sin2 = h[0] * h[0] + h[1] * h[1]
    e = (nx * h[0] * h[0] + ny * h[1] * h[1]) / sin2 if sin2 > 0.0 else 0.0
    pdf = math.sqrt((nx + 1.0) * (ny + 1.0)) / (8.0 * math.pi) * max(h[2], 1e-9) ** e / c
    return pdf / max(wo[2], wi[2], 1e-6), pdf
