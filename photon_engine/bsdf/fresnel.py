"""How much a smooth interface reflects, by angle: dielectric, metal, and the artists' blends of Blender's nodes."""

from __future__ import annotations

import math

from ..jit import kernel

F82_COS = 1.0 / 7.0  # where the tint of a metal's edge is exact: about 82 degrees
F82_PEAK = (6.0 / 7.0) ** 6 / 7.0  # c (1 - c)^6 there


@kernel
def fresnel_dielectric(cos_i, eta):
    """Unpolarised reflectance of a dielectric, and the cosine of the refracted ray.

        F = (r_s^2 + r_p^2) / 2      [Born and Wolf, section 1.5.2]

    cos_i : cosine to the normal (its sign is ignored);  eta : index beyond over index here
    out : (F, cos_t >= 0); total internal reflection is (1, 0).
    """
    c = abs(cos_i)
    g2 = eta * eta - 1.0 + c * c
    if g2 <= 0.0:
        return 1.0, 0.0
    g = math.sqrt(g2)  # eta cos_t
    r_s = (c - g) / (c + g)
    e2c = eta * eta * c
    r_p = (g - e2c) / (g + e2c)
    return 0.5 * (r_s * r_s + r_p * r_p), g / eta


@kernel
def f0_from_ior(eta):
    """Reflectance at normal incidence: ((eta - 1) / (eta + 1))^2."""
    r = (eta - 1.0) / (eta + 1.0)
    return r * r


@kernel
def average_dielectric(eta):
    """Cosine-weighted mean of the dielectric reflectance, by the fit of [Kulla and Conty 2017]."""
    if eta < 1.0:
        return 0.997118 + eta * (0.1014 - eta * (0.965241 + eta * 0.130607))
    return (eta - 1.0) / (4.08567 + 1.00071 * eta)


@kernel
def f82_b(f0, tint):
    """Depth of the dip near 82 degrees that multiplies Schlick's value there by `tint` [Kutz et al. 2021]."""
    f = 6.0 / 7.0
    schlick = f0 + (1.0 - f0) * f * f * f * f * f
    return schlick * (1.0 - tint) / F82_PEAK


@kernel
def fresnel_f82(cos_i, f0, tint):
    """Reflectance of a metal, one channel: Schlick minus b c (1 - c)^6 [Kutz et al. 2021, F82-tint].

    f0 : at normal incidence;  tint : factor on Schlick's value near 82 degrees.
    """
    c = min(max(cos_i, 0.0), 1.0)
    s = 1.0 - c
    s2 = s * s
    s5 = s2 * s2 * s
    value = f0 + (1.0 - f0) * s5
    if tint != 1.0:
        value -= f82_b(f0, tint) * c * s5 * s
    return min(max(value, 0.0), 1.0)


@kernel
def average_f82(f0, tint):
    """Cosine-weighted mean of `fresnel_f82`: exact, 2 int c (1-c)^5 = 1/21 and 2 int c^2 (1-c)^6 = 1/126."""
    value = f0 + (1.0 - f0) / 21.0
    if tint != 1.0:
        value -= f82_b(f0, tint) / 126.0
    return value


@kernel
def fresnel_conductor(cos_i, n, k):
    """Unpolarised reflectance of a metal of index n + ik in vacuum, one channel [Born and Wolf, 14.4.1]."""
    c = min(max(cos_i, 0.0), 1.0)
    c2 = c * c
    t = n * n - k * k - (1.0 - c2)
    m = math.sqrt(t * t + 4.0 * n * n * k * k)  # u^2 + v^2
    u = math.sqrt(max(0.5 * (m + t), 0.0))
    r_s = (m - 2.0 * u * c + c2) / max(m + 2.0 * u * c + c2, 1e-300)
    s2 = 1.0 - c2
    # ratio of the polarisations: R_p = R_s (..): Lazanyi's form of the same equations
    a = c2 * m + s2 * s2
    b = 2.0 * u * c * s2
    return 0.5 * r_s * (1.0 + (a - b) / max(a + b, 1e-300))


@kernel
def average_conductor(n, k):
    """Cosine-weighted mean of `fresnel_conductor`, through the F82 curve with the same two values."""
    f0 = fresnel_conductor(1.0, n, k)
    f82 = fresnel_conductor(F82_COS, n, k)
    f = 6.0 / 7.0
    schlick = f0 + (1.0 - f0) * f * f * f * f * f
    value = f0 + (1.0 - f0) / 21.0 - (schlick - f82) / F82_PEAK / 126.0
    return min(max(value, 0.0), 1.0)


@kernel
def schlick_share(f_real, eta):
    """Where a dielectric reflectance lies between its value at normal incidence (0) and 1 (1).

    Generalised Schlick as in Blender's Principled: F = F0 + (F90 - F0) share.
    """
    f0 = f0_from_ior(eta)
    return min(max((f_real - f0) / (1.0 - f0), 0.0), 1.0)
