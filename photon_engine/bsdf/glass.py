"""GLASS and REFRACT lobes: GGX dielectric interfaces. Values are for a lobe of unit weight.

f of a refracted pair is the one whose weight conserves flux: radiance still has to be divided by eta^2 where a path
from the eye crosses (the convention of `surface.sample`).
"""

from __future__ import annotations

from ..jit import kernel
from ..vec import add, basis, dot, madd, mul, normalize, scale
from .fields import BLACK, ONE, field3, mix3
from .fresnel import fresnel_dielectric, schlick_share
from .layout import BECKMANN, COLOR_A, COLOR_B, FILM, FRESNEL, FRESNEL_GENERALIZED, GLASS, IOR, MULTISCATTER, ROUGHNESS
from .microfacet import DELTA_ALPHA, NEARLY_ONE, sin2_between
from .older import facet_d, facet_lambda
from .reflect import UP, sample_facet
from .thinfilm import film_glass


@kernel
def side_eta(rows, row, k, front):
    """Index beyond the surface over the index on this side."""
    ior = float(rows.params[row, k, IOR])
    return ior if front else 1.0 / ior


@kernel
def is_delta(rows, row, k):
    """Whether the lobe has no density: nearly smooth, or of an index that bends nothing."""
    rough = float(rows.params[row, k, ROUGHNESS])
    return rough * rough <= DELTA_ALPHA or abs(float(rows.params[row, k, IOR]) - 1.0) < NEARLY_ONE


@kernel
def glass_fresnel(rows, row, k, c, eta, adjoint):
    """(reflected rgb, transmitted rgb, cos_t, probability of reflection) at a facet met at the cosine c.

    adjoint : of a photon; through a film it passes what the eye sees pass on the other side.
    """
    f, cos_t = fresnel_dielectric(c, eta)
    if rows.kind[row, k] != GLASS:
        t = ONE if f < 1.0 else BLACK
        return BLACK, t, cos_t, 0.0
    a = field3(rows, row, k, COLOR_A)
    b = field3(rows, row, k, COLOR_B)
    generalized = int(rows.params[row, k, FRESNEL]) == FRESNEL_GENERALIZED
    if rows.params[row, k, FILM] > 0.0:
        r = film_glass(rows, row, k, c, eta)
        t = film_glass(rows, row, k, cos_t, 1.0 / eta) if adjoint and f < 1.0 else r
        t = ((1.0 - t[0]) * b[0], (1.0 - t[1]) * b[1], (1.0 - t[2]) * b[2])
        if not generalized:
            r = mul(r, a)
    elif generalized:
        r = mix3(a, ONE, schlick_share(f, eta))
        t = ((1.0 - r[0]) * b[0], (1.0 - r[1]) * b[1], (1.0 - r[2]) * b[2])
    else:
        r = scale(a, f)
        t = scale(b, 1.0 - f)
    total_r = r[0] + r[1] + r[2]
    total = total_r + t[0] + t[1] + t[2]
    if total <= 0.0:
        return BLACK, BLACK, cos_t, 0.0
    return r, t, cos_t, total_r / total


@kernel
def eval_glass(rows, row, k, n, wo, wi, eta, adjoint):
    """GGX dielectric: reflection, or refraction [Walter et al. 2007, Eq. 20, 21], and the density of `sample_glass`.

    out : (f rgb without cosine [1/sr], pdf_w); zeros for a delta lobe and for pairs that no facet connects.
    """
    cos_o = dot(n, wo)
    cos_i = dot(n, wi)
    if cos_o <= 0.0 or abs(cos_i) <= 1e-9 or is_delta(rows, row, k):
        return BLACK, 0.0
    rough = float(rows.params[row, k, ROUGHNESS])
    alpha2 = rough * rough * rough * rough
    through = cos_i < 0.0
    h = normalize(madd(wo, eta, wi)) if through else normalize(add(wo, wi))
    if dot(h, n) < 0.0:
        h = (-h[0], -h[1], -h[2])
    c = dot(h, wo)
    c_i = dot(h, wi)
    if c <= 0.0 or (through and c_i >= 0.0):
        return BLACK, 0.0
    r, t, _, p_reflect = glass_fresnel(rows, row, k, c, eta, adjoint)
    shape = float(rows.params[row, k, MULTISCATTER])
    g_o = 1.0 + facet_lambda(shape, cos_o, alpha2)
    common = facet_d(shape, sin2_between(n, h), alpha2) / cos_o
    p_facet = cos_o * dot(n, h) / c if shape == BECKMANN else 1.0 / g_o  # over what the density of h has in common
    if through:
        x = c + eta * c_i
        common *= eta * eta * abs(c * c_i) / (x * x)
        p_reflect = 1.0 - p_reflect
    else:
        t = r
        common *= 0.25
    s = common / ((g_o + facet_lambda(shape, cos_i, alpha2)) * abs(cos_i))
    return (t[0] * s, t[1] * s, t[2] * s), common * p_reflect * p_facet


@kernel
def refract_in(wo, h, c, cos_t, eta):
    """Direction of wo refracted at the facet h; c = h.wo > 0 and cos_t from `fresnel_dielectric`."""
    inv = 1.0 / eta
    a = inv * c - cos_t
    return (a * h[0] - inv * wo[0], a * h[1] - inv * wo[1], a * h[2] - inv * wo[2])


@kernel
def sample_glass(rows, row, k, n, ng, wo, eta, u, adjoint):
    """Reflect or refract wo at a visible facet, by the energy of either; a REFRACT lobe refracts or fails.

    n : the lobe's normal;  ng : geometric normal on the side of wo;  u : three numbers in [0, 1), u[0] decides; below 0
    it forces reflection and above 1 refraction, and then the weight is not over the probability of either
    out : (ok, wi, f cos / pdf rgb, pdf_w, refracted); pdf_w = 0 for a delta lobe.
    """
    cos_o = dot(n, wo)
    if cos_o <= 0.0:
        return False, UP, BLACK, 0.0, False
    delta = is_delta(rows, row, k)
    rough = float(rows.params[row, k, ROUGHNESS])
    alpha = rough * rough
    h = n
    shape = float(rows.params[row, k, MULTISCATTER])
    if not delta:
        s, t = basis(n)
        h = sample_facet(shape, wo, (s, t, n), alpha, alpha, (u[1], u[2]))
    c = dot(h, wo)
    if c <= 0.0:
        return False, UP, BLACK, 0.0, False
    value, t, cos_t, p = glass_fresnel(rows, row, k, c, eta, adjoint)
    through = u[0] >= p
    if through:
        value = t
        p = 1.0 - p
        wi = refract_in(wo, h, c, cos_t, eta)
    else:
        wi = (2.0 * c * h[0] - wo[0], 2.0 * c * h[1] - wo[1], 2.0 * c * h[2] - wo[2])
    cos_i = dot(n, wi)
    if abs(cos_i) <= 1e-9 or (cos_i < 0.0) != through or (dot(ng, wi) < 0.0) != through:
        return False, UP, BLACK, 0.0, False
    if value[0] + value[1] + value[2] <= 0.0:
        return False, UP, BLACK, 0.0, False
    if u[0] < 0.0 or u[0] > 1.0:
        p = 1.0
    s = 1.0 / p
    if delta:
        return True, wi, (value[0] * s, value[1] * s, value[2] * s), 0.0, through
    alpha2 = alpha * alpha
    g_o = 1.0 + facet_lambda(shape, cos_o, alpha2)
    p_facet = cos_o * dot(n, h) / c if shape == BECKMANN else 1.0 / g_o
    s /= p_facet * (g_o + facet_lambda(shape, cos_i, alpha2))
    pdf = p * facet_d(shape, sin2_between(n, h), alpha2) * p_facet / cos_o
    if through:
        x = c - eta * cos_t
        pdf *= eta * eta * c * cos_t / (x * x)
    else:
        pdf *= 0.25
    return True, wi, (value[0] * s, value[1] * s, value[2] * s), pdf, through


@kernel
def sample_clear(wo, n, ng, eta, u):
    """`sample_glass` for a delta lobe whose reflection and transmission have one tint: the weight is the tint.

    out : (ok, wi, refracted).
    """
    c = dot(n, wo)
    if c <= 0.0:
        return False, UP, False
    f, cos_t = fresnel_dielectric(c, eta)
    through = u >= f
    if through:
        wi = refract_in(wo, n, c, cos_t, eta)
    else:
        wi = (2.0 * c * n[0] - wo[0], 2.0 * c * n[1] - wo[1], 2.0 * c * n[2] - wo[2])
    cos_i = cos_t if through else c
    ok = cos_i > 1e-9 and (dot(ng, wi) < 0.0) == through
    return ok, wi, through
