"""How much a lobe scatters as seen from one direction: for layering, sampling and multiple scattering."""

from __future__ import annotations

from ..jit import kernel
from .fields import ONE, field3, mix3
from .fresnel import (
    average_conductor,
    average_dielectric,
    average_f82,
    f0_from_ior,
    fresnel_conductor,
    fresnel_dielectric,
    schlick_share,
)
from .layout import (
    COLOR_A,
    COLOR_B,
    FILM,
    FRESNEL,
    FRESNEL_CONDUCTOR,
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    FRESNEL_GENERALIZED,
    FRESNEL_NONE,
    FRESNEL_SHEET,
    GLASS,
    IOR,
    MULTISCATTER,
    REFLECT,
    ROUGHNESS,
    THIN,
)
from .microfacet import NEARLY_ONE
from .tables import dielectric_share, glass_albedo, schlick_share_5, white_albedo
from .thinfilm import film_fresnel, film_glass


@kernel
def reflect_albedo(rows, row, k, mu):
    """Estimated directional albedo (rgb) of a REFLECT lobe of unit weight, single scattering made up for."""
    mode = int(rows.params[row, k, FRESNEL])
    if mode == FRESNEL_NONE or mode == FRESNEL_SHEET:
        return ONE
    if rows.params[row, k, FILM] > 0.0:
        return film_fresnel(rows, row, k, mu)  # as if smooth: there is no table of films
    rough = float(rows.params[row, k, ROUGHNESS])
    a = field3(rows, row, k, COLOR_A)
    if mode == FRESNEL_GENERALIZED:
        s = dielectric_share(rough, mu, float(rows.params[row, k, IOR]))
        return mix3(a, field3(rows, row, k, COLOR_B), s)
    if mode == FRESNEL_F82:
        return mix3(a, ONE, schlick_share_5(rough, mu))
    if mode == FRESNEL_CONDUCTOR:
        b = field3(rows, row, k, COLOR_B)
        return (fresnel_conductor(mu, a[0], b[0]), fresnel_conductor(mu, a[1], b[1]), fresnel_conductor(mu, a[2], b[2]))
    eta = float(rows.params[row, k, IOR])
    if eta > 1.0:
        f = f0_from_ior(eta)
        f += (1.0 - f) * dielectric_share(rough, mu, eta)
    else:
        f, _ = fresnel_dielectric(mu, eta)
    return (f, f, f)


@kernel
def glass_estimate(rows, row, k, mu, eta):
    """Estimated directional albedo (rgb) of a GLASS lobe of unit weight; eta: as seen from this side."""
    a = field3(rows, row, k, COLOR_A)
    b = field3(rows, row, k, COLOR_B)
    generalized = int(rows.params[row, k, FRESNEL]) == FRESNEL_GENERALIZED
    if rows.params[row, k, FILM] > 0.0:
        r = film_glass(rows, row, k, mu, eta)
        if not generalized:
            return (b[0] + (a[0] - b[0]) * r[0], b[1] + (a[1] - b[1]) * r[1], b[2] + (a[2] - b[2]) * r[2])
        return (r[0] + (1.0 - r[0]) * b[0], r[1] + (1.0 - r[1]) * b[1], r[2] + (1.0 - r[2]) * b[2])
    f, _ = fresnel_dielectric(mu, eta)
    if generalized:
        r = mix3(a, ONE, schlick_share(f, eta))
        return (r[0] + (1.0 - r[0]) * b[0], r[1] + (1.0 - r[1]) * b[1], r[2] + (1.0 - r[2]) * b[2])
    return mix3(b, a, f)


@kernel
def average_fresnel(rows, row, k):
    """Cosine-weighted mean reflectance (rgb) of a REFLECT lobe's Fresnel curve; FRESNEL_NONE and SHEET: its colour."""
    mode = int(rows.params[row, k, FRESNEL])
    a = field3(rows, row, k, COLOR_A)
    if mode == FRESNEL_NONE or mode == FRESNEL_SHEET:
        return a
    b = field3(rows, row, k, COLOR_B)
    if mode == FRESNEL_F82:
        return (average_f82(a[0], b[0]), average_f82(a[1], b[1]), average_f82(a[2], b[2]))
    if mode == FRESNEL_CONDUCTOR:
        return (average_conductor(a[0], b[0]), average_conductor(a[1], b[1]), average_conductor(a[2], b[2]))
    eta = float(rows.params[row, k, IOR])
    f = average_dielectric(eta)
    if mode == FRESNEL_DIELECTRIC:
        return (f, f, f)
    return mix3(a, b, schlick_share(f, eta))


@kernel
def multiscatter(rows, row, k, mu, eta):
    """Factors that give back what is lost between facets [Turquin 2019; Kulla and Conty 2017].

    mu : cosine of the view to the lobe's normal;  eta : of a GLASS lobe from this side
    out : (scale, darkening rgb); the lobe's weight is multiplied by both, its layering albedo by darkening alone.
    """
    kind = rows.kind[row, k]
    if rows.params[row, k, MULTISCATTER] != 1.0 or not (kind == REFLECT or kind == GLASS or kind == THIN):
        return 1.0, ONE
    rough = float(rows.params[row, k, ROUGHNESS])
    if rough < 0.01 or (kind == GLASS and abs(float(rows.params[row, k, IOR]) - 1.0) < NEARLY_ONE):
        return 1.0, ONE  # a mirror (DELTA_ALPHA) loses nothing, nor does what bends nothing
    if kind == REFLECT:
        e, mean = white_albedo(rough, mu)
        f = average_fresnel(rows, row, k)
    elif kind == THIN:
        e, _ = white_albedo(rough, mu)
        return 1.0 / e, ONE
    else:
        e, mean = glass_albedo(rough, mu, eta)
        f = field3(rows, row, k, COLOR_B)
    missing = (1.0 - e) / e
    return 1.0 / e, (darken(f[0], mean, missing), darken(f[1], mean, missing), darken(f[2], mean, missing))


@kernel
def darken(f, mean, missing):
    """Share kept by light that meets several facets of mean reflectance f, one channel [Kulla and Conty 2017]."""
    if f == 1.0:
        return 1.0
    f_ms = f * mean / (1.0 - f * (1.0 - mean))
    return (1.0 + f_ms * missing) / (1.0 + missing)
