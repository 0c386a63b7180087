"""DIFFUSE and TRANSLUCENT lobes. Values are for a lobe of unit weight.

Eye paths sample about the lobe's normal. Photons sample about the geometric normal: the weight
f |n.wo| |ng.wi| / (|ng.wo| pdf) then has no cosine below the bar that can vanish.
"""

from __future__ import annotations

import math

from ..jit import inlined, kernel
from ..vec import dot, scale
from .diffuse import INV_PI, oren_nayar, sample_cosine
from .fields import field3
from .frame import negate, shading_ratio
from .layout import COLOR_A, DIFFUSE, ROUGHNESS
from .reflect import BLACK

SMOOTH = 1e-5  # an Oren-Nayar roughness below this is Lambert


@kernel
def matte_value(rows, row, k, cos_light, cos_view, light_view):
    """f (rgb, without cosine) of a lit pair of directions: Lambert, or Oren-Nayar of a rough lobe."""
    rough = float(rows.params[row, k, ROUGHNESS])
    if rough >= SMOOTH:
        return oren_nayar(cos_light, max(cos_view, 0.0), light_view, rough, field3(rows, row, k, COLOR_A))
    return (INV_PI, INV_PI, INV_PI)


@kernel
def eval_matte(rows, row, k, n, ng, wo, wi, adjoint):
    """(f rgb without cosine [1/sr], pdf_w of `sample_matte`); n, ng on the side of wo.

    adjoint : light comes from wo and is seen from wi, instead of the other way round.
    """
    side = 1.0 if rows.kind[row, k] == DIFFUSE else -1.0
    about = ng if adjoint else n
    cos_s = side * dot(about, wi)
    if cos_s <= 0.0:
        return BLACK, 0.0
    pdf = cos_s * INV_PI
    cos_o = dot(n, wo)
    cos_i = dot(n, wi)
    between = dot(wo, wi) + (side - 1.0) * cos_i * cos_o  # to wi, or through the surface to its image
    if adjoint:
        if cos_o <= 0.0:
            return BLACK, pdf
        return matte_value(rows, row, k, cos_o, side * cos_i, between), pdf
    return matte_value(rows, row, k, cos_s, cos_o, between), pdf


@kernel
def sample_matte(rows, row, k, n, ng, wo, u, adjoint):
    """Direction with density cos / pi about n (eye) or ng (photon), on the lobe's side; u[1], u[2] are used.

    out : (ok, wi, f cos / pdf rgb, pdf_w), for photons with the factor |n.wo| |ng.wi| / (|ng.wo| |n.wi|).
    """
    about = ng if adjoint else n
    side = 1.0
    if rows.kind[row, k] != DIFFUSE:
        about = negate(about)
        side = -1.0
    wi = sample_cosine(about, u[1], u[2])
    pdf = dot(about, wi) * INV_PI
    s = 1.0
    if adjoint:
        lit = dot(n, wo)
        s = shading_ratio(lit, dot(ng, wo))
        if lit <= 0.0 or pdf <= 0.0:
            return False, wi, BLACK, 0.0
    elif side * dot(ng, wi) <= 0.0 or pdf <= 0.0:
        return False, wi, BLACK, 0.0
    if rows.params[row, k, ROUGHNESS] < SMOOTH:
        return True, wi, (s, s, s), pdf
    f, _ = eval_matte(rows, row, k, n, ng, wo, wi, adjoint)
    return True, wi, scale(f, math.pi * s), pdf


@inlined
def sample_lambert(ns, ng, wo, weight, u, adjoint):
    """`surface.sample` for a row that is one Lambert lobe about ns: the same numbers, fewer steps.

    Without branches, so that loops over it become vector instructions.
    """
    height = dot(ng, wo)
    side = math.copysign(1.0, height)
    about = ng if adjoint else ns
    wi = sample_cosine((side * about[0], side * about[1], side * about[2]), u[1], u[2])
    cos = side * dot(about, wi)
    lit = side * (dot(ns, wo) if adjoint else dot(ng, wi))
    if adjoint:
        weight = scale(weight, shading_ratio(lit, height))
    return min(cos, lit) > 0.0, wi, weight, cos * INV_PI, 1.0
