"""Thin walls: a sheet of clear material too thin to bend anything, its inner reflections summed [OpenPBR, thin-walled].

A sheet is a REFLECT lobe of FRESNEL_SHEET and, for what passes, either a TRANSPARENT lobe (smooth) or a THIN one,
whose facets mirror to the other side. Their weights depend on the view alone, not on the facet.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel
from ..vec import dot, madd
from .fields import ONE, field3, mix3
from .fresnel import f0_from_ior, fresnel_dielectric, schlick_share
from .layout import COLOR_A, COLOR_B, FILM, FILM_IOR, IOR
from .reflect import BLACK, eval_reflect, sample_reflect
from .thinfilm import film_generalized


def sheet_width(alpha: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """Width of what passes a sheet of facets of this width, two refractions [Kulla and Conty 2017, page 40]."""
    bent = 3.4 * np.maximum(eta - 1.0, 0.0) * (eta - 0.5) ** 2 / eta**3
    return np.clip(alpha * np.sqrt(bent), 0.0, 1.0)


@kernel
def passed(first, second, absorbed):
    """(reflected, transmitted) of one channel: both sides' reflectances, and what one way through the sheet leaves."""
    through = absorbed * (1.0 - first) * (1.0 - second) / max(1.0 - (second * absorbed) ** 2, 1e-12)
    return first + through * second * absorbed, through


@kernel
def sheet_shares(rows, row, k, mu):
    """(reflected rgb, transmitted rgb) of a sheet seen at the cosine mu: COLOR_A tints F0, COLOR_B what passes."""
    eta = float(rows.params[row, k, IOR])
    tint, color = field3(rows, row, k, COLOR_A), field3(rows, row, k, COLOR_B)
    real = f0_from_ior(eta)
    f0 = (real * tint[0], real * tint[1], real * tint[2])
    f, cos_t = fresnel_dielectric(mu, eta)
    thickness = float(rows.params[row, k, FILM])
    if thickness > 0.0:
        index = float(rows.params[row, k, FILM_IOR])
        first = film_generalized(mu, (thickness, index), eta, f0)
        second = film_generalized(cos_t, (thickness, index / eta), 1.0 / eta, f0)
    else:
        first = mix3(f0, ONE, schlick_share(f, eta))
        second = first
    if cos_t <= 0.0:
        return first, BLACK
    way = 1.0 / cos_t
    red = passed(first[0], second[0], math.pow(color[0], way))
    green = passed(first[1], second[1], math.pow(color[1], way))
    blue = passed(first[2], second[2], math.pow(color[2], way))
    return (red[0], green[0], blue[0]), (red[1], green[1], blue[1])


@kernel
def eval_thin(rows, row, k, n, wo, wi):
    """`eval_reflect` of wi mirrored in the sheet."""
    return eval_reflect(rows, row, k, n, wo, madd(wi, -2.0 * dot(n, wi), n))


@kernel
def sample_thin(rows, row, k, n, ng, wo, u):
    """`sample_reflect`, mirrored to the other side of the sheet."""
    ok, wi, value, pdf = sample_reflect(rows, row, k, n, n, wo, u[1], u[2])
    wi = madd(wi, -2.0 * dot(n, wi), n)
    return ok and dot(ng, wi) < 0.0, wi, value, pdf
