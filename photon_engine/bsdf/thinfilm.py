"""How much an interface under a thin film reflects, in colour: interference between its two sides.

Airy's sum over the bounces in the film, integrated over wavelengths in Fourier space [Belcour and Barla 2017]. The
details follow Blender's renderer: three orders, its table's steps, and a film that fades in below 1 nm.
"""

from __future__ import annotations

import math

from ..jit import kernel
from .fields import ONE, field3
from .fresnel import F82_COS, f0_from_ior, fresnel_f82
from .layout import COLOR_A, COLOR_B, FILM, FILM_IOR, FRESNEL, FRESNEL_CONDUCTOR, FRESNEL_GENERALIZED, IOR
from .observer import FILM_STEP
from .tables import FILM as SENSITIVITY

ORDERS = 3  # path differences of up to so many rounds
THINNEST = 1.0  # [nm] below it the film fades into the medium before it


@kernel
def polarized(c, eta):
    """Reflectances and signs of a dielectric: (R_s, R_p, sign_s, sign_p, cos_t); total reflection has cos_t = 0.

    c : cosine, >= 0;  eta : index beyond over index here.  [Born and Wolf, section 1.5.2]
    """
    g2 = eta * eta - 1.0 + c * c
    if g2 <= 0.0:
        return 1.0, 1.0, 1.0, 1.0, 0.0
    g = math.sqrt(g2)
    r_s = (c - g) / (c + g)
    e2c = eta * eta * c
    r_p = (e2c - g) / (e2c + g)
    return r_s * r_s, r_p * r_p, 1.0 if r_s >= 0.0 else -1.0, 1.0 if r_p >= 0.0 else -1.0, g / eta


@kernel
def wave(channel, difference):
    """(real, imaginary) sensitivity of a channel to an optical path difference [nm], linear in the table."""
    x = min(difference / FILM_STEP, SENSITIVITY.shape[1] - 1.0)
    i = min(int(x), SENSITIVITY.shape[1] - 2)
    t = x - i
    re = float(SENSITIVITY[channel, i]) * (1.0 - t) + float(SENSITIVITY[channel, i + 1]) * t
    im = float(SENSITIVITY[channel + 3, i]) * (1.0 - t) + float(SENSITIVITY[channel + 3, i + 1]) * t
    return re, im


@kernel
def airy(channel, r12, r23, difference, phase):
    """Reflectance of one polarisation, one channel [Belcour and Barla 2017, Eq. 10].

    r12, r23 : reflectances of the film's sides;  phase : (re, im) of exp(i phi), both reflections' phase shifts.
    """
    through = 1.0 - r12
    both = r12 * r23
    back = through * through * r23 / (1.0 - both)
    total = back + r12
    order = back - through
    re, im = phase
    for m in range(1, ORDERS + 1):
        order *= math.sqrt(both)
        s_re, s_im = wave(channel, m * difference)
        total += 2.0 * order * (re * s_re + im * s_im)
        re, im = re * phase[0] - im * phase[1], re * phase[1] + im * phase[0]
    return total


@kernel
def faded(thickness, ior):
    """Index of a film, that of vacuum where it is not there."""
    if thickness >= THINNEST:
        return ior
    return 1.0 + (ior - 1.0) * thickness * thickness * (3.0 - 2.0 * thickness)


@kernel
def film_dielectric(c, thickness, film_ior, eta):
    """Reflectance (rgb) of a film [nm] of index film_ior over a dielectric of index eta, all over the index here."""
    ior = faded(thickness, film_ior)
    c = min(abs(c), 1.0)
    top_s, top_p, sign_s, sign_p, inner = polarized(c, ior)
    low_s, low_p, back_s, back_p, cos_t = polarized(inner, eta / ior)
    if inner <= 0.0 or cos_t <= 0.0:
        return ONE
    difference = 2.0 * ior * thickness * inner
    s = (-sign_s * back_s, 0.0)
    p = (-sign_p * back_p, 0.0)
    r = 0.5 * (airy(0, top_s, low_s, difference, s) + airy(0, top_p, low_p, difference, p))
    g = 0.5 * (airy(1, top_s, low_s, difference, s) + airy(1, top_p, low_p, difference, p))
    b = 0.5 * (airy(2, top_s, low_s, difference, s) + airy(2, top_p, low_p, difference, p))
    return (min(max(r, 0.0), 1.0), min(max(g, 0.0), 1.0), min(max(b, 0.0), 1.0))


@kernel
def toward_f0(f, f0, real):
    """Reflectance f of one channel, scaled by f0 / real where it is near the real F0, not at all where it is 1."""
    s = min(max((f - 1.0) / (real - 1.0), 0.0), 1.0)
    return f * (1.0 + (f0 / real - 1.0) * s)


@kernel
def film_generalized(c, film, eta, f0):
    """`film_dielectric` for an artist's F0 (rgb); film : (thickness, index)."""
    f = film_dielectric(c, film[0], film[1], eta)
    real = f0_from_ior(eta)
    if real <= 1e-5 or (f[0] == 1.0 and f[1] == 1.0 and f[2] == 1.0):
        return f
    return (toward_f0(f[0], f0[0], real), toward_f0(f[1], f0[1], real), toward_f0(f[2], f0[2], real))


@kernel
def unit_phase(re, im):
    """(re, im) of length 1; of nothing, 1."""
    size = math.sqrt(re * re + im * im)
    if size == 0.0:
        return (1.0, 0.0)
    return (re / size, im / size)


@kernel
def film_metal(channel, c, film, metal):
    """One channel of a film over a metal.

    film : (thickness [nm], index);  metal : (n, k, F82): with F82 >= 0 the reflectance under the film is the F82 curve
    with the metal's F0 in the film, and only the phases are those of n + ik [Born and Wolf, section 14.4.1].
    """
    n, k, f82 = metal
    ior = faded(film[0], film[1])
    top_s, top_p, sign_s, sign_p, inner = polarized(min(abs(c), 1.0), ior)
    if inner <= 0.0:
        return 1.0
    kk = k * k
    t1 = n * n - kk - ior * ior * (1.0 - inner * inner)
    t2 = math.sqrt(t1 * t1 + 4.0 * n * n * kk)
    u2, v2 = max(0.5 * (t2 + t1), 0.0), max(0.5 * (t2 - t1), 0.0)
    u, v = math.sqrt(u2), math.sqrt(v2)
    x = ior * inner
    t3, t4 = (n * n - kk) * inner, 2.0 * n * k * inner
    if f82 >= 0.0:
        q, r = n / ior, kk / (ior * ior)
        low_s = curve_through((((q - 1.0) * (q - 1.0) + r) / ((q + 1.0) * (q + 1.0) + r)), f82, inner)
        low_p = low_s
    else:
        low_s = ((x - u) * (x - u) + v2) / max((x + u) * (x + u) + v2, 1e-300)
        low_p = ((t3 - ior * u) * (t3 - ior * u) + (t4 - ior * v) * (t4 - ior * v)) / max(
            (t3 + ior * u) * (t3 + ior * u) + (t4 + ior * v) * (t4 + ior * v), 1e-300
        )
    s = unit_phase(x * x - u2 - v2, -2.0 * x * v)
    m = (n * n + kk) * inner
    p = unit_phase(m * m - ior * ior * (u2 + v2), 2.0 * x * (2.0 * n * k * u - (n * n - kk) * v))
    difference = 2.0 * x * film[0]
    value = airy(channel, top_s, low_s, difference, (-sign_s * s[0], -sign_s * s[1]))
    value += airy(channel, top_p, low_p, difference, (-sign_p * p[0], -sign_p * p[1]))
    return min(max(0.5 * value, 0.0), 1.0)


@kernel
def curve_through(f0, f82, c):
    """The F82 curve with these values at normal incidence and near 82 degrees."""
    f = 6.0 / 7.0
    return fresnel_f82(c, f0, f82 / (f0 + (1.0 - f0) * f * f * f * f * f))


@kernel
def metal_by_colour(f0, tint):
    """(n, k, F82) of an artist's metal, one channel [Gulbrandsen 2014], F82 standing for his edge colour."""
    r = min(f0, 0.999)
    g = fresnel_f82(F82_COS, f0, tint)
    root = math.sqrt(r)
    n = (1.0 + root) / (1.0 - root) * (1.0 - g) + (1.0 - r) / (1.0 + r) * g
    k2 = (r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r)
    return n, math.sqrt(max(k2, 0.0)), g


@kernel
def film_fresnel(rows, row, k, c):
    """Reflectance (rgb) of a REFLECT lobe's facet under its film."""
    p = rows.params
    film = (float(p[row, k, FILM]), float(p[row, k, FILM_IOR]))
    a, b = field3(rows, row, k, COLOR_A), field3(rows, row, k, COLOR_B)
    mode = int(p[row, k, FRESNEL])
    if mode == FRESNEL_GENERALIZED:
        return film_generalized(c, film, float(p[row, k, IOR]), a)
    if mode == FRESNEL_CONDUCTOR:
        red, green, blue = (a[0], b[0], -1.0), (a[1], b[1], -1.0), (a[2], b[2], -1.0)
    else:
        red, green, blue = metal_by_colour(a[0], b[0]), metal_by_colour(a[1], b[1]), metal_by_colour(a[2], b[2])
    return (film_metal(0, c, film, red), film_metal(1, c, film, green), film_metal(2, c, film, blue))


@kernel
def film_glass(rows, row, k, c, eta):
    """Reflectance (rgb) of a GLASS lobe's facet under its film; eta: index beyond over index here.

    From inside, Blender's renderer takes film and outside over the glass's index, but leaves the thickness as it is:
    so do we. What passes depends on the side then: `glass_fresnel` has photons pass what the eye sees.
    """
    p = rows.params
    ior = float(p[row, k, IOR])
    index = float(p[row, k, FILM_IOR])
    film = (float(p[row, k, FILM]), index if eta == ior else index * eta)
    if int(p[row, k, FRESNEL]) == FRESNEL_GENERALIZED:
        return film_generalized(c, film, eta, field3(rows, row, k, COLOR_A))
    return film_dielectric(c, film[0], film[1], eta)
