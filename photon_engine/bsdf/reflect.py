"""REFLECT lobes: GGX mirrors under any Fresnel curve. Values are for a lobe of unit weight."""

from __future__ import annotations

from ..jit import kernel
from ..vec import add, basis, dot, madd, normalize
from .fields import BLACK, ONE, field3, mix3
from .fresnel import fresnel_conductor, fresnel_dielectric, fresnel_f82, schlick_share
from .layout import (
    ANISOTROPY,
    COLOR_A,
    COLOR_B,
    FILM,
    FRESNEL,
    FRESNEL_CONDUCTOR,
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    FRESNEL_NONE,
    FRESNEL_SHEET,
    IOR,
    MULTISCATTER,
    ROUGHNESS,
    TANGENT,
)
from .microfacet import DELTA_ALPHA, frame_along, ggx_d_stretched, ggx_lambda_stretched, sample_vndf_stretched
from .older import sample_older, value_older
from .thinfilm import film_fresnel

UP = (0.0, 0.0, 1.0)


@kernel
def reflect_fresnel(rows, row, k, c):
    """Reflectance (rgb) of a REFLECT lobe's facet met at the cosine c."""
    mode = int(rows.params[row, k, FRESNEL])
    if mode == FRESNEL_NONE or mode == FRESNEL_SHEET:
        return ONE
    if rows.params[row, k, FILM] > 0.0:
        return film_fresnel(rows, row, k, c)
    if mode == FRESNEL_DIELECTRIC:
        f, _ = fresnel_dielectric(c, float(rows.params[row, k, IOR]))
        return (f, f, f)
    a = field3(rows, row, k, COLOR_A)
    b = field3(rows, row, k, COLOR_B)
    if mode == FRESNEL_F82:
        return (fresnel_f82(c, a[0], b[0]), fresnel_f82(c, a[1], b[1]), fresnel_f82(c, a[2], b[2]))
    if mode == FRESNEL_CONDUCTOR:
        return (fresnel_conductor(c, a[0], b[0]), fresnel_conductor(c, a[1], b[1]), fresnel_conductor(c, a[2], b[2]))
    eta = float(rows.params[row, k, IOR])
    f, _ = fresnel_dielectric(c, eta)
    return mix3(a, b, schlick_share(f, eta))


@kernel
def widths(rows, row, k, alpha):
    """GGX widths (along the tangent, across it)."""
    stretch = float(rows.params[row, k, ANISOTROPY])
    if stretch == 0.0:
        return alpha, alpha
    return alpha * stretch, alpha / stretch


@kernel
def facet_frame(rows, row, k, n):
    """Unit (s, t, n) about the lobe's normal, s along its tangent if it is stretched."""
    if rows.params[row, k, ANISOTROPY] == 0.0:
        s, t = basis(n)
    else:
        s, t = frame_along(n, field3(rows, row, k, TANGENT))
    return s, t, n


@kernel
def to_local(w, frame):
    """Components of w along the frame's three axes."""
    return (dot(w, frame[0]), dot(w, frame[1]), dot(w, frame[2]))


@kernel
def sample_facet(shape, wo, frame, ax, ay, u):
    """A facet normal: a visible one of GGX, or of another shape; it may face away from wo then."""
    if shape <= 1.0:
        return sample_vndf_stretched(wo, frame, ax, ay, u)
    s, t, n = frame
    h = sample_older(shape, ax, ay, u[0], u[1])
    return madd(madd((h[0] * s[0], h[0] * s[1], h[0] * s[2]), h[1], t), h[2], n)


@kernel
def eval_reflect(rows, row, k, n, wo, wi):
    """GGX reflection, f = F D G2 / (4 (n.wo) (n.wi)), and the density of `sample_reflect` [Walter et al. 2007, Eq. 20].

    out : (f rgb without cosine [1/sr], pdf_w); zeros for a delta lobe or directions below n.
    """
    rough = float(rows.params[row, k, ROUGHNESS])
    alpha = rough * rough
    cos_o = dot(n, wo)
    cos_i = dot(n, wi)
    if cos_o <= 0.0 or cos_i <= 1e-9 or alpha <= DELTA_ALPHA:
        return BLACK, 0.0
    h = normalize(add(wo, wi))
    ax, ay = widths(rows, row, k, alpha)
    frame = facet_frame(rows, row, k, n)
    f = reflect_fresnel(rows, row, k, dot(h, wo))
    shape = float(rows.params[row, k, MULTISCATTER])
    if shape > 1.0:
        s, pdf = value_older(shape, to_local(h, frame), to_local(wo, frame), to_local(wi, frame), ax, ay)
        return (f[0] * s, f[1] * s, f[2] * s), pdf
    d = ggx_d_stretched(to_local(h, frame), ax, ay)
    lambda_o = ggx_lambda_stretched(to_local(wo, frame), ax, ay)
    pdf = d / (4.0 * cos_o * (1.0 + lambda_o))
    s = d / (4.0 * cos_o * cos_i * (1.0 + lambda_o + ggx_lambda_stretched(to_local(wi, frame), ax, ay)))
    return (f[0] * s, f[1] * s, f[2] * s), pdf


@kernel
def sample_reflect(rows, row, k, n, ng, wo, u1, u2):
    """Mirror wo in a visible facet.

    n : the lobe's normal;  ng : geometric normal on the side of wo
    out : (ok, wi, f cos / pdf rgb, pdf_w); pdf_w = 0 for a delta lobe. Not ok: wi would be below n or ng.
    """
    cos_o = dot(n, wo)
    if cos_o <= 0.0:
        return False, UP, BLACK, 0.0
    rough = float(rows.params[row, k, ROUGHNESS])
    alpha = rough * rough
    ax, ay = widths(rows, row, k, alpha)
    frame = facet_frame(rows, row, k, n)
    h = n
    shape = float(rows.params[row, k, MULTISCATTER])
    if alpha > DELTA_ALPHA:
        h = sample_facet(shape, wo, frame, ax, ay, (u1, u2))
    c = dot(h, wo)
    if c <= 0.0:
        return False, UP, BLACK, 0.0
    wi = (2.0 * c * h[0] - wo[0], 2.0 * c * h[1] - wo[1], 2.0 * c * h[2] - wo[2])
    cos_i = dot(n, wi)
    if cos_i <= 1e-9 or dot(ng, wi) <= 0.0:
        return False, UP, BLACK, 0.0
    f = reflect_fresnel(rows, row, k, c)
    if alpha <= DELTA_ALPHA:
        return True, wi, f, 0.0
    if shape > 1.0:
        s, pdf = value_older(shape, to_local(h, frame), to_local(wo, frame), to_local(wi, frame), ax, ay)
        s = s * cos_i / pdf if pdf > 0.0 else 0.0
        return True, wi, (f[0] * s, f[1] * s, f[2] * s), pdf
    g_o = 1.0 + ggx_lambda_stretched(to_local(wo, frame), ax, ay)
    s = g_o / (g_o + ggx_lambda_stretched(to_local(wi, frame), ax, ay))
    pdf = ggx_d_stretched(to_local(h, frame), ax, ay) / (4.0 * cos_o * g_o)
    return True, wi, (f[0] * s, f[1] * s, f[2] * s), pdf
