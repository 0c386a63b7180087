"""Photons that meet smooth mirrors and smooth glass, LANES at a time, as `matte_kernels` does it for Lambert surfaces.

The same numbers as `bsdf.surface.prepare` and `sample` give, without weights, classes and tables.
"""

from __future__ import annotations

import math

from ..bsdf.frame import raised_normal, shading_ratio
from ..bsdf.layout import COLOR_A, GLASS
from ..bsdf.layout import IOR as IOR_FIELD
from ..bsdf.reflect import reflect_fresnel
from ..bsdf.rough import EPSILON
from ..geometry.surface import unit_or
from ..jit import kernel
from ..photons.batch import SEEN_SHARP
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, uniform
from ..vec import dot, mul, scale
from .matte_kernels import (
    COLOR,
    GOES_ON,
    IOR,
    LANES,
    MIRROR,
    NG,
    NS,
    OUT,
    PHI,
    SEEN,
    U0,
    U1,
    WI,
    WO,
    N,
    O,
    get,
    launch,
    leave_lane,
    put,
)
from .media import after_surface
from .photon_rules import roulette

RAISED = GOES_ON  # 1: the mirrored ray would enter, so the normal has to be raised; the column is free until then


@kernel
def load_ideal(lanes, index, surfaces):
    """After `load_lanes`: what an ideal lobe needs besides its weight."""
    x = lanes.value
    p = surfaces.rows.params
    for j in range(len(index)):
        row = surfaces.row[index[j]]
        clear = surfaces.rows.kind[row, 0] == GLASS
        x[MIRROR + j] = 0.0 if clear else 1.0
        x[IOR + j] = float(p[row, 0, IOR_FIELD]) if clear else 1.5
        if clear:
            tint = (float(p[row, 0, COLOR_A]), float(p[row, 0, COLOR_A + 1]), float(p[row, 0, COLOR_A + 2]))
            put(x, COLOR, j, mul(get(x, COLOR, j), tint))


@kernel
def turn_normals(lanes, index, surfaces):
    """Facets' normals on the side of wo, raised where the mirrored ray would enter; mirrors' colours at their angle."""
    x = lanes.value
    for j in range(LANES):
        ng, wo = get(x, NG, j), get(x, WO, j)
        height = dot(ng, wo)
        side = math.copysign(1.0, height)
        n = scale(unit_or(get(x, NS, j), ng), side)
        put(x, N, j, n)
        image = 2.0 * dot(n, wo) * dot(n, ng) - height
        x[RAISED + j] = 1.0 if side * image < min(0.9 * abs(height), 0.01) else 0.0
    for j in range(len(index)):
        wo = get(x, WO, j)
        if x[RAISED + j] > 0.0:
            ng = get(x, NG, j)
            put(x, N, j, raised_normal(get(x, N, j), scale(ng, math.copysign(1.0, dot(ng, wo))), wo))
        if x[MIRROR + j] > 0.0:
            f = reflect_fresnel(surfaces.rows, surfaces.row[index[j]], 0, dot(get(x, N, j), wo))
            put(x, COLOR, j, mul(get(x, COLOR, j), f))


@kernel
def bend(lanes, bounce):
    """Next rays, mirrored or refracted by chance as Fresnel's formula has it: directions, flux, origins."""
    x = lanes.value
    dim = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    for j in range(LANES):
        key = lanes.key[j]
        x[U0 + j] = uniform(key, dim)
        x[U1 + j] = uniform(key, dim + 3)
    for j in range(LANES):
        ng, wo, n = get(x, NG, j), get(x, WO, j), get(x, N, j)
        height = dot(ng, wo)
        ior = x[IOR + j]
        eta = ior if height >= 0.0 else 1.0 / ior
        c = dot(n, wo)
        # fresnel_dielectric without branches: g = 0, total reflection, gives exactly 1
        g = math.sqrt(max(eta * eta - 1.0 + c * c, 0.0))
        r_s = (c - g) / (c + g)
        r_p = (g - eta * eta * c) / (g + eta * eta * c)
        through = x[U0 + j] >= max(0.5 * (r_s * r_s + r_p * r_p), x[MIRROR + j])
        cos_t = g / eta
        along = c / eta - cos_t if through else 2.0 * c
        back = 1.0 / eta if through else 1.0
        wi = (along * n[0] - back * wo[0], along * n[1] - back * wo[1], along * n[2] - back * wo[2])
        rise = math.copysign(1.0, height) * dot(ng, wi) * (-1.0 if through else 1.0)
        ok = (c > 0.0) & ((cos_t if through else c) > 1e-9) & (rise > 0.0)
        slope = dot(n, wi)
        factor = shading_ratio(c, height) * shading_ratio(dot(ng, wi), slope)
        weight = scale(get(x, COLOR, j), factor if abs(slope) > EPSILON else 0.0)
        survives, out = roulette(get(x, PHI, j), mul(get(x, PHI, j), weight), x[U1 + j])
        x[GOES_ON + j] = 1.0 if ok & survives else 0.0
        put(x, OUT, j, out)
        put(x, WI, j, wi)
        put(x, O, j, leave_lane(x, j, ng, wi))


@kernel
def launch_ideal(lanes, index, surfaces, media, photons, alive):
    """Write the photons that go on behind the first `alive`; out: how many are now alive, their flux."""
    x = lanes.value
    r, g, b = 0.0, 0.0, 0.0
    for j in range(len(index)):
        out = get(x, OUT, j)
        launch(lanes, j, photons, alive)
        if len(photons.inside):
            ng = get(x, NG, j)
            cos_from, cos_to = dot(ng, get(x, WO, j)), dot(ng, get(x, WI, j))
            prim = surfaces.prim[index[j]]
            photons.inside[alive] = after_surface(media, lanes.inside[j], prim, cos_from, cos_to)
        photons.seen[alive] = int(x[SEEN + j]) | SEEN_SHARP
        goes_on = x[GOES_ON + j] > 0.0
        r += out[0] if goes_on else 0.0
        g += out[1] if goes_on else 0.0
        b += out[2] if goes_on else 0.0
        alive += 1 if goes_on else 0
    return alive, (r, g, b)
