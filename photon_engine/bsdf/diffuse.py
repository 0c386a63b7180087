"""Lambert and Oren-Nayar scattering."""

from __future__ import annotations

import math

from ..jit import kernel
from ..sampling.warps import turn
from ..vec import dot, to_world

INV_PI = 1.0 / math.pi
ON_SLOPE = 0.5 * math.pi - 2.0 / 3.0


@kernel
def sample_cosine(n, u1, u2):
    """Direction about the unit normal n with density cos / pi."""
    r = math.sqrt(u1)
    c, s = turn(u2)
    return to_world((r * c, r * s, math.sqrt(1.0 - u1)), n)


@kernel
def oren_nayar_g(c):
    """Directional albedo term of Fujii's model [Portsmouth, Kutz and Hill 2025, G(mu)]."""
    if c < 1e-6:
        return ON_SLOPE - c  # the tangent below is unstable at grazing: its Taylor expansion
    c = min(c, 1.0)
    s = math.sqrt(1.0 - c * c)
    return s * (math.acos(c) - 2.0 / 3.0 - s * c) + 2.0 / 3.0 * (s / c) * (1.0 - s * s * s)


@kernel
def oren_nayar(cos_i, cos_o, wi_wo, roughness, color):
    """Factor on the lobe's weight, per channel, of rough diffuse reflection; f without cosine [1/sr].

    Fujii's improved Oren-Nayar with the energy-preserving term of OpenPBR, as Blender's Diffuse BSDF computes it
    (whose multiple scattering has the colour to the third power in all: the weight carries one).

    cos_i, cos_o : cosines to the normal, cos_o clamped at 0;  wi_wo : wi . wo;  color : saturated albedo.
    """
    sigma = min(max(roughness, 0.0), 1.0)
    a = 1.0 / (math.pi + sigma * ON_SLOPE)
    b = sigma * a
    t = wi_wo - cos_i * cos_o
    if t > 0.0:
        t /= max(cos_i, cos_o) + 1e-30
    single = a + b * t
    e_i = a * math.pi + b * oren_nayar_g(cos_i)
    e_o = a * math.pi + b * oren_nayar_g(cos_o)
    e_avg = a * math.pi + (2.0 * math.pi - 5.6) / 3.0 * b
    k = INV_PI * (1.0 - e_i) * (1.0 - e_o) * e_avg / (1.0 - e_avg)
    lost = 1.0 - e_avg
    return (
        single + k * color[0] * color[0] / (1.0 - color[0] * lost),
        single + k * color[1] * color[1] / (1.0 - color[1] * lost),
        single + k * color[2] * color[2] / (1.0 - color[2] * lost),
    )


@kernel
def bump_softening(ns, n, w):
    """Factor that darkens light w near the terminator of a bumped normal n over the smooth normal ns.

    [Conty, Lecocq and Stein 2019]: GGX masking of a roughness that follows the angle between the normals.
    0 when w is on different sides of the two.
    """
    cos_i = dot(ns, w)
    cos_d = dot(ns, n)
    if cos_i * cos_d * dot(n, w) < 0.0:
        return 0.0
    cos_i = abs(cos_i)
    cos_d = abs(cos_d)
    if cos_d >= 1.0 or cos_i >= 1.0:
        return 1.0
    if cos_i < 1e-6:
        return 0.0
    alpha2 = min(0.125 * (1.0 / (cos_d * cos_d) - 1.0), 1.0)
    return 2.0 / (1.0 + math.sqrt(1.0 + alpha2 * (1.0 / (cos_i * cos_i) - 1.0)))
