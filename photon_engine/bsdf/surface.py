"""Scattering at a hit, as the transport kernels see it: rows of lobes in, directions and weights out.

Weights of refraction conserve flux. Radiance along an eye path scales by 1/eta^2 where it crosses; that factor is
not in the weight of `sample` (the caller multiplies) but is in f of `eval_rough` (which ends a path).
"""

from __future__ import annotations

from ..jit import inlined, kernel
from ..vec import dot, mul, scale
from .diffuse import INV_PI
from .fields import field3
from .frame import facet_normal, lobe_normal, negate, shading_ratio
from .glass import is_delta, sample_clear, sample_glass, side_eta
from .layering import class_total, is_lambert, is_plain, lobe_class, weigh, weigh_plain
from .layout import (
    CLASS_NULL,
    CLASS_ROUGH,
    CLASS_SHARP,
    COLOR_A,
    DIFFUSE,
    EMISSION,
    GLASS,
    GROUP,
    HAS_NORMAL,
    MULTISCATTER,
    NONE,
    REFLECT,
    SHEEN,
    THIN,
    TRANSLUCENT,
    TRANSPARENT,
    WEIGHT,
)
from .matte import sample_lambert, sample_matte
from .odd import sample_odd
from .reflect import BLACK, UP, sample_reflect
from .rough import EPSILON, is_bumped_mirror, rough_total, sample_bumped_mirror
from .sheet import sample_thin

CLASS_ANY = -1


@inlined
def prepare(rows, row, ns, ng, wo, threshold, scratch):
    """Weights and classes of the row's lobes as seen from wo, for the functions below.

    ns, ng : shading and geometric normals; dot(wo, ng) < 0 is the back side
    threshold : lobes of a roughness (as in the material) below it are sharp
    scratch : (K, 8) f64; [k, 0:3] effective weight, [k, 3] sampling weight, [k, 4] class; [k, 5:8] is used by photons
    out : summed sampling weights (luminances) of the classes null, sharp, rough.
    """
    if is_lambert(rows, row):
        return weigh_lambert(rows, row, scratch)
    return prepare_any(rows, row, ns, ng, wo, threshold, scratch)


@kernel
def weigh_lambert(rows, row, scratch):
    """`prepare` for a row that is one Lambert lobe."""
    p = rows.params
    r, g, b = float(p[row, 0, WEIGHT]), float(p[row, 0, WEIGHT + 1]), float(p[row, 0, WEIGHT + 2])
    scratch[0, 0] = r
    scratch[0, 1] = g
    scratch[0, 2] = b
    scratch[0, 3] = 0.2126 * r + 0.7152 * g + 0.0722 * b
    scratch[0, 4] = CLASS_ROUGH
    return 0.0, 0.0, scratch[0, 3]


@kernel
def prepare_any(rows, row, ns, ng, wo, threshold, scratch):
    """`prepare` for any row."""
    if is_plain(rows, row):
        weigh_plain(rows, row, scratch)
        n_lobes = 1
    else:
        n_lobes = weigh(rows, row, ns, ng, wo, scratch, 0)
    p_null = 0.0
    p_sharp = 0.0
    p_rough = 0.0
    for k in range(n_lobes):
        c = lobe_class(rows, row, k, threshold)
        scratch[k, 4] = c
        s = scratch[k, 3]
        if c == CLASS_ROUGH:
            p_rough += s
        elif c == CLASS_SHARP:
            p_sharp += s
        elif c == CLASS_NULL:
            p_null += s
    return p_null, p_sharp, p_rough


@kernel
def emission(rows, row, scratch):
    """Radiance [W/m^2/sr] that the surface emits toward wo; after `prepare`."""
    r = 0.0
    g = 0.0
    b = 0.0
    for k in range(rows.kind.shape[1]):
        kind = rows.kind[row, k]
        if kind == NONE:
            break
        if kind == EMISSION:
            r += scratch[k, 0]
            g += scratch[k, 1]
            b += scratch[k, 2]
    return (r, g, b)


@kernel
def choose(rows, row, scratch, cls, u):
    """A lobe of the class by sampling weight: (k or -1, u stretched again, summed weight, lobes of the class)."""
    total = 0.0
    count = 0
    last = -1
    for k in range(rows.kind.shape[1]):
        if rows.kind[row, k] == NONE:
            break
        c = scratch[k, 4]
        if (c == cls or (cls == CLASS_ANY and c >= 0.0)) and scratch[k, 3] > 0.0:
            total += scratch[k, 3]
            count += 1
            last = k
    if count <= 1:
        return last, u, total, count
    x = u * total
    for k in range(last):
        c = scratch[k, 4]
        if (c == cls or (cls == CLASS_ANY and c >= 0.0)) and scratch[k, 3] > 0.0:
            if x < scratch[k, 3]:
                return k, x / scratch[k, 3], total, count
            x -= scratch[k, 3]
    return last, min(max(x / scratch[last, 3], 0.0), 1.0 - 1e-12), total, count


@kernel
def photon_factor(n, ng, wo, wi):
    """Shading-normal factor |n.wo| |ng.wi| / (|ng.wo| |n.wi|) of a photon [Veach 1997, Eq. 5.19]."""
    if abs(dot(n, wi)) <= EPSILON:
        return 0.0
    return shading_ratio(dot(n, wo), dot(ng, wo)) * shading_ratio(dot(ng, wi), dot(n, wi))


@kernel
def sample_lobe(rows, row, k, ns, ng, wo, u, adjoint):
    """Direction from lobe k of unit weight: (ok, wi, f cos / pdf rgb, pdf_w, eta), photon factor included."""
    front = dot(wo, ng) >= 0.0
    kind = rows.kind[row, k]
    near = ng if front else negate(ng)
    if kind == TRANSPARENT:
        return True, negate(wo), (1.0, 1.0, 1.0), 0.0, 1.0
    if kind == DIFFUSE or kind == TRANSLUCENT:
        ok, wi, value, pdf = sample_matte(rows, row, k, lobe_normal(rows, row, k, ns, front), near, wo, u, adjoint)
        return ok, wi, value, pdf, 1.0
    if kind >= SHEEN:
        n = lobe_normal(rows, row, k, ns, front)
        ok, wi, value, pdf = sample_odd(rows, row, k, n, near, wo, u, adjoint)
        if adjoint and ok:
            value = scale(value, photon_factor(n, ng, wo, wi))
        return ok, wi, value, pdf, 1.0
    n = facet_normal(rows, row, k, ns, ng, wo, front)
    eta = 1.0
    if kind == REFLECT:
        ok, wi, value, pdf = sample_reflect(rows, row, k, n, near, wo, u[1], u[2])
    elif kind == THIN:
        ok, wi, value, pdf = sample_thin(rows, row, k, n, near, wo, u)
    else:
        crossed = side_eta(rows, row, k, front)
        ok, wi, value, pdf, through = sample_glass(rows, row, k, n, near, wo, crossed, u, adjoint)
        if through:
            eta = crossed
    if adjoint and ok:
        value = scale(value, photon_factor(n, ng, wo, wi))
    return ok, wi, value, pdf, eta


@kernel
def sample_clear_row(rows, row, ns, ng, wo, scratch, u, adjoint):
    """`sample` for a row that is one smooth, evenly tinted GLASS lobe: the same numbers, fewer steps."""
    front = dot(wo, ng) >= 0.0
    crossed = side_eta(rows, row, 0, front)
    n = facet_normal(rows, row, 0, ns, ng, wo, front)
    ok, wi, through = sample_clear(wo, n, ng if front else negate(ng), crossed, u)
    if not ok:
        return False, UP, BLACK, 0.0, 1.0
    w = mul(field3(rows, row, 0, COLOR_A), (scratch[0, 0], scratch[0, 1], scratch[0, 2]))
    if adjoint:
        w = scale(w, photon_factor(n, ng, wo, wi))
    return True, wi, w, 0.0, crossed if through else 1.0


@kernel
def needs_adjoint_weights(rows, row, k):
    """Whether a lobe's effective weight depends on the view."""
    if rows.kind[row, k] == SHEEN:
        return True
    return rows.params[row, k, GROUP] > 0.0 or rows.params[row, k, MULTISCATTER] == 1.0


@inlined
def sample(rows, row, ns, ng, wo, cls, scratch, u, adjoint, threshold):
    """Where a path goes on, from one lobe of the class; after `prepare` with the same wo.

    cls : CLASS_NULL, CLASS_SHARP, CLASS_ROUGH or CLASS_ANY;  u : three numbers in [0, 1)
    adjoint : 0 for paths from the eye, 1 for photons (wo points to where the photon came from)
    threshold : as in `prepare`
    out : (ok, wi, weight rgb, pdf_w, eta); weight = f |cos| / pdf, over the lobes of the class; of the rough ones
    all count in f and pdf (MIS against `eval_rough`). pdf_w = 0 for a delta lobe. eta: index beyond over index here
    where the path crosses, else 1; an eye path multiplies by 1 / eta^2 itself.
    """
    if is_lambert(rows, row) and cls == CLASS_ROUGH:
        return sample_lambert(ns, ng, wo, (scratch[0, 0], scratch[0, 1], scratch[0, 2]), u, adjoint)
    return sample_any(rows, row, ns, ng, wo, cls, scratch, u, adjoint)


@kernel
def sample_any(rows, row, ns, ng, wo, cls, scratch, u, adjoint):
    """`sample` for any row; apart from it so that the short cut for plain Lambert is small enough to be inlined."""
    if is_plain(rows, row) and rows.kind[row, 0] == GLASS and is_delta(rows, row, 0):
        if cls != CLASS_ANY and cls != CLASS_SHARP:
            return False, UP, BLACK, 0.0, 1.0
        return sample_clear_row(rows, row, ns, ng, wo, scratch, u[0], adjoint)
    k, u0, total, count = choose(rows, row, scratch, cls, u[0])
    if k < 0:
        return False, UP, BLACK, 0.0, 1.0
    value, pdf, eta = BLACK, 0.0, 1.0
    if adjoint and scratch[k, 4] == CLASS_ROUGH and is_bumped_mirror(rows, row, k):
        ok, wi = sample_bumped_mirror(rows, row, k, (ns, ng), wo, (u0, u[1], u[2]))
    else:
        ok, wi, value, pdf, eta = sample_lobe(rows, row, k, ns, ng, wo, (u0, u[1], u[2]), adjoint)
    if not ok:
        return False, UP, BLACK, 0.0, 1.0
    column = 0
    if adjoint:
        column = 5
        if count > 1 or needs_adjoint_weights(rows, row, k):
            weigh(rows, row, ns, ng, wi, scratch, 5)
        else:
            scratch[k, 5] = scratch[k, 0]
            scratch[k, 6] = scratch[k, 1]
            scratch[k, 7] = scratch[k, 2]
    share = scratch[k, 3] / total
    if scratch[k, 4] == CLASS_ROUGH and (count > 1 or rows.params[row, k, HAS_NORMAL] != 0.0):
        value, density = rough_total(rows, row, ns, ng, wo, wi, scratch, adjoint)
        pdf = density / total
        if pdf <= 0.0:
            return False, UP, BLACK, 0.0, 1.0
        s = 1.0 / pdf if adjoint else eta * eta / pdf
        return True, wi, scale(value, s), pdf, eta
    s = 1.0 / share
    w = (scratch[k, column] * s, scratch[k, column + 1] * s, scratch[k, column + 2] * s)
    return True, wi, mul(value, w), pdf * share, eta


@inlined
def eval_rough(rows, row, ns, ng, wo, wi, scratch):
    """All rough lobes for one pair of directions; after `prepare` with the same wo.

    out : (f rgb [1/sr], pdf_w of `sample` with CLASS_ROUGH). f is without cosine: multiply by |ns.wi|, also where
    lobes have normals of their own. It is for radiance toward wo: pairs through a refracting lobe are over eta^2.
    """
    if is_lambert(rows, row):
        lit = dot(ns, wi) if dot(wo, ng) >= 0.0 else -dot(ns, wi)
        if lit < EPSILON:
            return BLACK, 0.0
        return (scratch[0, 0] * INV_PI, scratch[0, 1] * INV_PI, scratch[0, 2] * INV_PI), lit * INV_PI
    return eval_any(rows, row, ns, ng, wo, wi, scratch)


@kernel
def eval_any(rows, row, ns, ng, wo, wi, scratch):
    """`eval_rough` for any row."""
    value, density = rough_total(rows, row, ns, ng, wo, wi, scratch, 0)
    cos = abs(dot(ns, wi))
    if density <= 0.0 or cos < EPSILON:
        return BLACK, 0.0
    return scale(value, 1.0 / cos), density / class_total(rows, row, scratch, CLASS_ROUGH)
