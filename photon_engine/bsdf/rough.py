"""All rough lobes of a row together: what next-event estimation, photon gathers and MIS need."""

from __future__ import annotations

from ..jit import kernel
from ..vec import dot
from .diffuse import INV_PI, bump_softening, sample_cosine
from .frame import facet_normal, lobe_normal, negate, shading_ratio
from .glass import eval_glass, side_eta
from .layout import CLASS_ROUGH, DIFFUSE, HAS_NORMAL, NONE, REFLECT, SHEEN, THIN, TRANSLUCENT
from .matte import eval_matte
from .odd import eval_odd
from .reflect import BLACK, eval_reflect, sample_reflect
from .sheet import eval_thin

EPSILON = 1e-9  # cosines below this count as grazing: nothing is scattered
FLAT_SHARE = 0.3  # of the photons that leave a rough bumped mirror as if it had no bumps
EVEN_SHARE = 0.05  # of them that leave it evenly


@kernel
def is_bumped_mirror(rows, row, k):
    """Whether a lobe reflects about a normal of its own."""
    return rows.kind[row, k] == REFLECT and rows.params[row, k, HAS_NORMAL] != 0.0


@kernel
def seen_from(rows, row, k, normals, wo, wi):
    """(f rgb, normal) of a bumped mirror as an eye path finds it that comes from wo; normals : (ns, ng) as given.

    The normal is raised for whoever looks (`raised_normal`). A photon comes the other way, so that the normal must be
    raised for where it goes: by where it came from, grazing light lost a fifth (75 degrees on bumps of 35) to a half.
    """
    ns, ng = normals
    side = dot(ng, wo)
    if side * dot(ng, wi) <= 0.0:
        return BLACK, ns
    n = facet_normal(rows, row, k, ns, ng, wo, side >= 0.0)
    f, _ = eval_reflect(rows, row, k, n, wo, wi)
    return f, n


@kernel
def sample_bumped_mirror(rows, row, k, normals, wo, u):
    """A photon's way on from a rough bumped mirror: (ok, wi); normals : (ns, ng) as given.

    What looks along the surface sees light in raised normals where facets about the photon's own normal send none. So
    some leave by facets about ng and a few evenly: weights at 75 degrees on bumps of 35 stay below 45 (780 without).
    """
    ns, ng = normals
    front = dot(wo, ng) >= 0.0
    near = ng if front else negate(ng)
    if u[0] < EVEN_SHARE:
        wi = sample_cosine(near, u[1], u[2])
        return dot(near, wi) > 0.0, wi
    n = near if u[0] < EVEN_SHARE + FLAT_SHARE else facet_normal(rows, row, k, ns, ng, wo, front)
    ok, wi, _, _ = sample_reflect(rows, row, k, n, near, wo, u[1], u[2])
    return ok, wi


@kernel
def mirror_density(rows, row, k, ng, pair, pdf):
    """Density of `sample_bumped_mirror`; pair : (wo, wi), ng on the side of wo, pdf : that of the facets alone."""
    wo, wi = pair
    _, flat = eval_reflect(rows, row, k, ng, wo, wi)
    even = max(dot(ng, wi), 0.0) * INV_PI
    return (1.0 - EVEN_SHARE - FLAT_SHARE) * pdf + EVEN_SHARE * even + FLAT_SHARE * flat


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
        if adjoint and is_bumped_mirror(rows, row, k):
            f, n = seen_from(rows, row, k, (ns, ng), wi, wo)
            pdf = mirror_density(rows, row, k, ng if front else negate(ng), (wo, wi), pdf)
        return f, pdf, n, 1.0
    if kind == THIN:
        f, pdf = eval_thin(rows, row, k, n, wo, wi)
        return f, pdf, n, 1.0
    eta = side_eta(rows, row, k, front)
    f, pdf = eval_glass(rows, row, k, n, wo, wi, eta, adjoint)
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
