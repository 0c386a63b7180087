"""All rough lobes of a row together: what next-event estimation, photon gathers and MIS need."""

from __future__ import annotations

from ..jit import kernel
from ..vec import dot
from .diffuse import bump_softening
from .frame import facet_normal, lobe_normal, negate, shading_ratio
from .glass import eval_glass, side_eta
from .layout import CLASS_ROUGH, DIFFUSE, HAS_NORMAL, NONE, REFLECT, SHEEN, TRANSLUCENT
from .matte import eval_matte
from .odd import eval_odd
from .reflect import eval_reflect

EPSILON = 1e-9  # cosines below this count as grazing: nothing is scattered


@kernel
def eval_lobe(rows, row, k, ns, ng, wo, wi, adjoint):
    """One rough lobe of unit weight: (f rgb without cosine, pdf_w, its normal, eta crossed); ns, ng as given."""
    front = dot(wo, ng) >= 0.0
    kind = rows.kind[row, k]
    if kind == DIFFUSE or kind == TRANSLUCENT:
        n = lobe_normal(rows, row, k, ns, front)
        f, pdf = eval_matte(rows, row, k, n, ng if front else negate(ng), wo, wi, adjoint)
        return f, pdf, n, 1.0
    if kind >= SHEEN:
        n = lobe_normal(rows, row, k, ns, front)
        f, pdf = eval_odd(rows, row, k, n, wo, wi, adjoint)
        return f, pdf, n, 1.0
    n = facet_normal(rows, row, k, ns, ng, wo, front)
    if kind == REFLECT:
        f, pdf = eval_reflect(rows, row, k, n, wo, wi)
        return f, pdf, n, 1.0
    eta = side_eta(rows, row, k, front)
    f, pdf = eval_glass(rows, row, k, n, wo, wi, eta)
    return f, pdf, n, eta if dot(n, wi) < 0.0 else 1.0


@kernel
def bump_factor(rows, row, k, ns, n, light):
    """Factor for a bumped lobe: no light from behind the smooth surface, a soft terminator for diffuse."""
    if rows.params[row, k, HAS_NORMAL] != 1.0:
        return 1.0
    if rows.kind[row, k] == DIFFUSE:
        return bump_softening(ns, n, light)
    return 0.0 if dot(ns, light) * dot(ns, n) * dot(n, light) < 0.0 else 1.0


@kernel
def rough_total(rows, row, ns, ng, wo, wi, scratch, adjoint):
    """Sum over rough lobes of weight f |cos| (rgb), and of sampling weight times pdf_w.

    Eye (adjoint = 0): weights scratch[k, 0:3], cosine |n.wi| of each lobe's normal, f of radiance (over eta^2).
    Photon (adjoint = 1): weights scratch[k, 5:8], |n.wo| |ng.wi| / |ng.wo| [Veach 1997, Eq. 5.19], f of flux.
    """
    r = 0.0
    g = 0.0
    b = 0.0
    density = 0.0
    column = 5 if adjoint else 0
    for k in range(rows.kind.shape[1]):
        if rows.kind[row, k] == NONE:
            break
        if scratch[k, 4] != CLASS_ROUGH:
            continue
        f, pdf, n, eta = eval_lobe(rows, row, k, ns, ng, wo, wi, adjoint)
        if adjoint:
            lit = dot(n, wo)
            falls = shading_ratio(lit, dot(ng, wo)) if lit > 0.0 else 0.0
            cos = falls * abs(dot(ng, wi)) * bump_factor(rows, row, k, ns, n, wo)
        else:
            cos = abs(dot(n, wi)) / (eta * eta) * bump_factor(rows, row, k, ns, n, wi)
        r += scratch[k, column] * f[0] * cos
        g += scratch[k, column + 1] * f[1] * cos
        b += scratch[k, column + 2] * f[2] * cos
        density += scratch[k, 3] * pdf
    return (r, g, b), density
