"""Weights of a row's lobes as seen from one direction: layers attenuate what lies below, facets' losses return."""

from __future__ import annotations

import math

from ..jit import inlined, kernel
from ..vec import dot, luminance, max3, mul
from .albedo import glass_estimate, multiscatter, reflect_albedo
from .fields import ONE, field3
from .frame import facet_normal, lobe_normal
from .glass import is_delta, side_eta
from .layout import (
    CLASS_DEEP,
    CLASS_NULL,
    CLASS_ROUGH,
    CLASS_SHARP,
    COLOR_A,
    COLOR_B,
    DIFFUSE,
    EMISSION,
    FILM,
    FRESNEL,
    FRESNEL_GENERALIZED,
    FRESNEL_NONE,
    FRESNEL_SHEET,
    GLASS,
    GROUP,
    HAS_NORMAL,
    HOLDOUT,
    IOR,
    LAYER,
    MULTISCATTER,
    NONE,
    REFLECT,
    ROUGHNESS,
    SHEEN,
    SUBSURFACE,
    TINT,
    TRANSLUCENT,
    TRANSPARENT,
    WEIGHT,
)
from .matte import SMOOTH
from .sheen import sheen_albedo
from .sheet import sheet_shares

IDEAL = 0.01  # a roughness below this is none: see DELTA_ALPHA, and `multiscatter`
CLASS_NOTHING = -2  # of lobes that scatter nothing (emission, holdout)


@kernel
def lobe_class(rows, row, k, threshold):
    """Class of a lobe; facets are sharp below the roughness threshold, and always when they have no density."""
    kind = rows.kind[row, k]
    if kind == SUBSURFACE:
        return CLASS_DEEP
    if kind == DIFFUSE or kind == TRANSLUCENT or kind >= SHEEN:
        return CLASS_ROUGH
    if kind == TRANSPARENT:
        return CLASS_NULL
    if kind == EMISSION or kind == HOLDOUT or kind == NONE:
        return CLASS_NOTHING
    if rows.params[row, k, ROUGHNESS] < threshold or is_delta(rows, row, k):
        return CLASS_SHARP
    return CLASS_ROUGH


@inlined
def class_total(rows, row, scratch, cls):
    """Summed sampling weight of the lobes of a class in a prepared row; beyond the row scratch holds another's."""
    total = 0.0
    for k in range(rows.kind.shape[1]):
        if rows.kind[row, k] == NONE:
            break
        if scratch[k, 4] == cls:
            total += scratch[k, 3]
    return total


@kernel
def is_plain(rows, row):
    """Whether the row is one lobe of the same weight from all sides: Lambert, evenly tinted glass, plain mirror."""
    if rows.kind.shape[1] > 1 and rows.kind[row, 1] != NONE:
        return False
    kind = rows.kind[row, 0]
    if kind == DIFFUSE:
        return True
    p = rows.params
    if (kind != GLASS and kind != REFLECT) or (p[row, 0, MULTISCATTER] != 0.0 and p[row, 0, ROUGHNESS] >= IDEAL):
        return False
    if kind == REFLECT:
        return p[row, 0, FRESNEL] == FRESNEL_NONE
    if p[row, 0, FILM] > 0.0:
        return False
    return (
        p[row, 0, COLOR_A] == p[row, 0, COLOR_B]
        and p[row, 0, COLOR_A + 1] == p[row, 0, COLOR_B + 1]
        and p[row, 0, COLOR_A + 2] == p[row, 0, COLOR_B + 2]
    )


@kernel
def is_lambert(rows, row):
    """Whether the row is a single Lambert lobe about the surface's shading normal."""
    if rows.kind[row, 0] != DIFFUSE or (rows.kind.shape[1] > 1 and rows.kind[row, 1] != NONE):
        return False
    return rows.params[row, 0, ROUGHNESS] < SMOOTH and rows.params[row, 0, HAS_NORMAL] == 0.0


@kernel
def is_ideal(rows, row):
    """Whether the row is one smooth mirror, or one smooth, evenly tinted glass lobe, about the surface's normal."""
    p = rows.params
    kind = rows.kind[row, 0]
    if (kind != GLASS and kind != REFLECT) or p[row, 0, ROUGHNESS] >= IDEAL or p[row, 0, HAS_NORMAL] != 0.0:
        return False
    if kind == GLASS:
        return p[row, 0, FRESNEL] != FRESNEL_GENERALIZED and is_plain(rows, row)
    return rows.kind.shape[1] == 1 or rows.kind[row, 1] == NONE


@kernel
def weigh_plain(rows, row, scratch):
    """`weigh` with column 0 for a row that `is_plain`: no table, no normal."""
    w = field3(rows, row, 0, WEIGHT)
    scratch[0, 0] = w[0]
    scratch[0, 1] = w[1]
    scratch[0, 2] = w[2]
    if rows.kind[row, 0] == GLASS:
        w = mul(w, field3(rows, row, 0, COLOR_A))
    scratch[0, 3] = luminance(w)


@kernel
def facet_response(rows, row, k, ns, ng, wo):
    """(scale, darkening rgb, albedo estimate rgb, cosine) of a lobe of facets, or of a sheet, seen from wo.

    The lobe's weight is to be multiplied by scale and darkening; the estimate is for unit weight, without them.
    """
    front = dot(wo, ng) >= 0.0
    mu = dot(facet_normal(rows, row, k, ns, ng, wo, front), wo)
    kind = rows.kind[row, k]
    if int(rows.params[row, k, FRESNEL]) == FRESNEL_SHEET:
        scale, dark = multiscatter(rows, row, k, mu, 1.0)
        back, through = sheet_shares(rows, row, k, mu)
        return scale, mul(dark, back if kind == REFLECT else through), ONE, mu
    if kind == REFLECT:
        scale, dark = multiscatter(rows, row, k, mu, 1.0)
        return scale, dark, reflect_albedo(rows, row, k, mu), mu
    if kind == GLASS:
        eta = side_eta(rows, row, k, front)
        scale, dark = multiscatter(rows, row, k, mu, eta)
        return scale, dark, glass_estimate(rows, row, k, mu, eta), mu
    return 1.0, ONE, ONE, mu


@kernel
def is_faceted(rows, row, k):
    """Whether a lobe's weight follows from the cosine to the normal: facets of any kind, and a smooth thin wall."""
    kind = rows.kind[row, k]
    return kind >= REFLECT and (
        kind < TRANSPARENT or (kind == TRANSPARENT and int(rows.params[row, k, FRESNEL]) == FRESNEL_SHEET)
    )


@kernel
def passes_below(rows, row, k, albedo, mu):
    """Factor (rgb) of all later lobes of the group under a layer with this albedo estimate.

    1 - cover max(albedo), times a coat's tint^(1 / cos in the coat) where it covers (absorption along the path).
    """
    cover = float(rows.params[row, k, LAYER])
    rest = min(max(1.0 - cover * max3(albedo), 0.0), 1.0)
    tint = field3(rows, row, k, TINT)
    if tint[0] == 1.0 and tint[1] == 1.0 and tint[2] == 1.0:
        return (rest, rest, rest)
    ior = float(rows.params[row, k, IOR])
    depth = 1.0 / math.sqrt(1.0 - (1.0 - mu * mu) / (ior * ior))
    return (
        rest * (1.0 + cover * (tint[0] ** depth - 1.0)),
        rest * (1.0 + cover * (tint[1] ** depth - 1.0)),
        rest * (1.0 + cover * (tint[2] ** depth - 1.0)),
    )


@kernel
def weigh(rows, row, ns, ng, wo, scratch, column):
    """Effective weights seen from wo into scratch[k, column : column + 3].

    Returns the number of lobes in the row. With column 0, scratch[k, 3] gets the luminance of weight times albedo.
    """
    below = ONE
    group = 0.0
    n_lobes = rows.kind.shape[1]
    for k in range(rows.kind.shape[1]):
        kind = rows.kind[row, k]
        if kind == NONE:
            n_lobes = k
            break
        w = field3(rows, row, k, WEIGHT)
        g = rows.params[row, k, GROUP]
        if g != group:
            group = g
            below = ONE
        if g > 0.0:
            w = mul(w, below)
        albedo = w
        if is_faceted(rows, row, k):
            scale, dark, estimate, mu = facet_response(rows, row, k, ns, ng, wo)
            w = mul(w, dark)
            albedo = mul(w, estimate)
            w = (w[0] * scale, w[1] * scale, w[2] * scale)
            if rows.params[row, k, LAYER] > 0.0:
                below = mul(below, passes_below(rows, row, k, mul(dark, estimate), mu))
        elif kind == SHEEN:
            mu = dot(lobe_normal(rows, row, k, ns, dot(wo, ng) >= 0.0), wo)
            r = sheen_albedo(float(rows.params[row, k, ROUGHNESS]), mu)
            w = (w[0] * r, w[1] * r, w[2] * r)
            albedo = w
            if rows.params[row, k, LAYER] > 0.0:
                below = mul(below, passes_below(rows, row, k, (r, r, r), mu))
        scratch[k, column] = w[0]
        scratch[k, column + 1] = w[1]
        scratch[k, column + 2] = w[2]
        if column == 0:
            scratch[k, 3] = luminance(albedo)
    return n_lobes
