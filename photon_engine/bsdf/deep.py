"""SUBSURFACE lobes, as the kernels see them: the medium below, how paths enter it and how photons leave it.

An eye path that looks along -wo enters by refraction at a facet whatever its Fresnel reflectance, walks, and is lit
where it comes out as by white Lambert. A photon goes the other way: in by a cosine lobe, and out with the weight

    p(w | wo) |n.wo| / |n.w|,   p(w | wo): density of the eye's way in w                                        (1)

so that both see the same light [Chiang and Burley 2016; adjoint: Veach 1997, 3.7].
"""

from __future__ import annotations

import math

from ..jit import kernel
from ..vec import dot, madd, normalize, scale
from .diffuse import sample_cosine
from .fields import field3
from .frame import facet_normal, lobe_normal, negate, shading_ratio
from .layering import class_total
from .layout import (
    ANISOTROPY,
    CLASS_DEEP,
    COLOR_A,
    COLOR_B,
    FRESNEL,
    IOR,
    NONE,
    ROUGHNESS,
    SUBSURFACE,
    WALK,
    WALK_SKIN,
)
from .microfacet import DELTA_ALPHA, ggx_lambda, sample_vndf

LEAST_ALBEDO = 0.2  # of single scattering: a lower one is walked as this one, with less weight
MOST_ALBEDO = 0.999999  # the diffusion length of a white medium is infinite
UP = (0.0, 0.0, 1.0)


@kernel
def has_deep(rows, row):
    """Whether a row has a SUBSURFACE lobe."""
    return same_deep(rows, row, 0) >= 0


@kernel
def pick_deep(rows, row, scratch, u):
    """A SUBSURFACE lobe of a prepared row by sampling weight, and its probability; -1: there is none."""
    total = class_total(rows, row, scratch, CLASS_DEEP)
    x, last, p = u * total, -1, 0.0
    for k in range(rows.kind.shape[1]):
        if rows.kind[row, k] == NONE:
            break
        if scratch[k, 4] == CLASS_DEEP and scratch[k, 3] > 0.0:
            last, p = k, scratch[k, 3] / total
            if x < scratch[k, 3]:
                break
            x -= scratch[k, 3]
    return last, p


@kernel
def same_deep(rows, row, k):
    """Lobe k of a row if it is a SUBSURFACE lobe, else the first that is; -1: there is none."""
    if k < rows.kind.shape[1] and rows.kind[row, k] == SUBSURFACE:
        return k
    for j in range(rows.kind.shape[1]):
        if rows.kind[row, j] == SUBSURFACE:
            return j
    return -1


@kernel
def single_albedo(c, g, law):
    """Single scattering albedo of a medium whose surface reflects c: d'Eon's inversion, or the older fit.

    [d'Eon, A Hitchhiker's Guide to Multiple Scattering, Eq. 53.7, by van de Hulst's similarity; Chiang and Burley 2016
    with Wrenninge et al. 2017 for g > 0]
    """
    if law == WALK or g < 0.0:
        s = 4.20863 * c + 4.09712 - math.sqrt(9.59217 + 41.6808 * c + 17.7126 * c * c)
        albedo = (1.0 - s * s) / (1.0 - g * s * s)
    else:
        albedo = _fitted_albedo(c, g)
    return min(max(albedo, 0.0), MOST_ALBEDO)


@kernel
def _fitted_albedo(c, g):
    """The older fit."""
    a = 1.8260523782 + g * (-1.28451056436 + g * (-1.79904629312 + g * (9.19393289202 + g * (-22.8215585862 + g * (
        32.0234874259 + g * (-23.6264803333 + g * 7.21067002658))))))  # fmt: skip
    b = 4.98511194385 + 0.127355959438 * math.exp(g * (31.1491581433 + g * (-201.847017512 + g * (841.576016723 + g * (
        -2018.09288505 + g * (2731.71560286 + g * (-1935.41424244 + g * 559.009054474)))))))  # fmt: skip
    e = 1.09686102424 + g * (-0.394704063468 + g * (1.05258115941 + g * (-8.83963712726 + g * (28.8643230661 + g * (
        -46.8802913581 + g * (38.5402837518 + g * -12.7181042538))))))  # fmt: skip
    d = 0.496310210422 + g * (0.360146581622 + g * (-2.15139309747 + g * (17.8896899217 + g * (-55.2984010333 + g * (
        82.065982243 + g * (-58.5106008578 + g * 15.8478295021))))))  # fmt: skip
    f = 4.23190299701 + 0.00310603949088 * math.exp(g * (76.7316253952 + g * (-594.356773233 + g * (2448.8834203 + g * (
        -5576.68528998 + g * (7116.60171912 + g * (-4763.54467887 + g * 1303.5318055)))))))  # fmt: skip
    h = 2.40602999408 + g * (-2.51814844609 + g * (9.18494908356 + g * (-79.2191708682 + g * (259.082868209 + g * (
        -403.613804597 + g * (302.85712436 + g * -87.4370473567))))))  # fmt: skip
    blend = math.sqrt(math.sqrt(c))
    return (1.0 - blend) * a * math.atan(b * c) ** e + blend * d * math.atan(f * c) ** h


@kernel
def medium(rows, row, k):
    """What lobe k walks through: (albedo rgb of single scattering, extinction rgb [1/m], g); weight rgb of what enters.

    The weight is over the lobe's albedo, which the walk itself brings about.
    """
    law, g = int(rows.params[row, k, FRESNEL]), float(rows.params[row, k, ANISOTROPY])
    color, path = field3(rows, row, k, COLOR_A), field3(rows, row, k, COLOR_B)
    r, p = _let_in(single_albedo(color[0], g, law), color[0])
    s, q = _let_in(single_albedo(color[1], g, law), color[1])
    t, o = _let_in(single_albedo(color[2], g, law), color[2])
    ahead = 1.0 if law == WALK or g < 0.0 else 1.0 / (1.0 - g)
    sigma = (ahead / max(path[0], 1e-16), ahead / max(path[1], 1e-16), ahead / max(path[2], 1e-16))
    return ((r, s, t), sigma, g), (p, q, o)


@kernel
def _let_in(albedo, color):
    """A channel's albedo, at least LEAST_ALBEDO, and weight."""
    if color <= 0.0:
        return LEAST_ALBEDO, 0.0
    if albedo < LEAST_ALBEDO:
        return LEAST_ALBEDO, albedo / (LEAST_ALBEDO * color)
    return albedo, 1.0 / color


@kernel
def enter(rows, row, k, ns, ng, wo, u):
    """An eye path's way into lobe k: (ok, direction below, the lobe's normal on the side of wo); u : two numbers."""
    front = dot(wo, ng) >= 0.0
    near = ng if front else negate(ng)
    n = facet_normal(rows, row, k, ns, ng, wo, front)
    u0, width = u[0], float(rows.params[row, k, ROUGHNESS])
    if int(rows.params[row, k, FRESNEL]) == WALK_SKIN:
        if u0 < 0.5:
            w = negate(sample_cosine(n, 2.0 * u0, u[1]))
            return dot(near, w) < 0.0, w, n
        u0, width = 2.0 * u0 - 1.0, 1.0
    if dot(n, wo) <= 0.0:
        return False, UP, n
    h = sample_vndf(wo, n, max(width, DELTA_ALPHA), u0, u[1])
    eta = 1.0 / float(rows.params[row, k, IOR])
    c = dot(h, wo)
    bend = eta * c - math.sqrt(1.0 - eta * eta * (1.0 - c * c))
    w = normalize(madd(scale(wo, -eta), bend, h))
    return dot(near, w) < 0.0, w, n


@kernel
def leave_by(rows, row, k, ns, ng, t, u):
    """A photon's way out of lobe k, coming from below along t: (ok, wi, weight); u : two numbers.

    The facet h is drawn as seen from below, so that Eq. 1 leaves eta^2 G1(wi) / G1(t), and nothing beyond the critical
    angle; its normals' cosines are those of the eye's way in, the flux that of facets [Veach 1997, 5.3].
    """
    front = dot(t, ng) >= 0.0
    near = ng if front else negate(ng)
    n = lobe_normal(rows, row, k, ns, front)
    u0, width = u[0], float(rows.params[row, k, ROUGHNESS])
    if dot(n, t) <= 0.0:
        return False, UP, 0.0
    fold = shading_ratio(dot(n, t), dot(near, t))
    if int(rows.params[row, k, FRESNEL]) == WALK_SKIN:
        if u0 < 0.5:
            wi = sample_cosine(near, 2.0 * u0, u[1])
            return dot(near, wi) > 0.0, wi, fold
        u0, width = 2.0 * u0 - 1.0, 1.0
    alpha = max(width, DELTA_ALPHA)
    h = sample_vndf(t, n, alpha, u0, u[1])
    eta = float(rows.params[row, k, IOR])
    c = dot(h, t)
    rest = 1.0 - eta * eta * (1.0 - c * c)
    if rest <= 0.0:
        return False, UP, 0.0
    wi = normalize(madd(scale(t, eta), math.sqrt(rest) - eta * c, h))
    cos = dot(n, wi)
    if cos <= 0.0 or dot(near, wi) <= 0.0:
        return False, UP, 0.0
    masked = (1.0 + ggx_lambda(dot(n, t), alpha * alpha)) / (1.0 + ggx_lambda(cos, alpha * alpha))
    return True, wi, eta * eta * masked * fold * shading_ratio(dot(near, wi), cos)
