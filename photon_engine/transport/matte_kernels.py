"""Photons that meet plain Lambert surfaces, LANES at a time.

They are most of a usual scene's photons. Hits are loaded into columns of one array, field by field; the loops over a
column hold nothing but arithmetic, so the compiler turns them into vector instructions: 35 ns a hit with its deposit
instead of 180. Offsets into the array are constants: only so can the compiler prove that columns do not overlap.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.layout import WEIGHT
from ..bsdf.matte import sample_lambert
from ..geometry.surface import between, corners, face_normal, offset_origin, smooth_normal, unit_or
from ..jit import inlined, kernel
from ..photons.batch import ONE_ROUGH
from ..photons.packing import pack_direction
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, uniform
from ..vec import dot, load3, mul, scale, store3
from .photon_rules import after_rough, roulette, stores

LANES = 32

# columns: what is loaded ...
A, B, C = 0, 3 * LANES, 6 * LANES  # corners
U, V = 9 * LANES, 10 * LANES
NS = 11 * LANES  # interpolated normal, or zero
WO = 14 * LANES
PHI = 17 * LANES
COLOR = 20 * LANES  # of the lobe
SEEN = 23 * LANES
# ... and what is computed
P = 24 * LANES
NG = 27 * LANES
WI = 30 * LANES
OUT = 33 * LANES  # flux of the photon that goes on
O = 36 * LANES
GOES_ON = 39 * LANES  # 1: it does
U0, U1, U2 = 40 * LANES, 41 * LANES, 42 * LANES  # random numbers
CODE_WO, CODE_NG = 43 * LANES, 44 * LANES
N_COLUMNS = 45


class Lanes(NamedTuple):
    """Work space for LANES hits."""

    value: np.ndarray  # (N_COLUMNS * LANES,) f64
    key: np.ndarray  # (LANES,) u64, of the photons
    inside: np.ndarray  # (LANES,) i64, media of the photons, which reflection does not change


def empty_lanes() -> Lanes:
    """Lanes whose unused ones hold harmless numbers."""
    return Lanes(np.zeros(N_COLUMNS * LANES), np.zeros(LANES, np.uint64), np.zeros(LANES, np.int64))


@inlined
def _get(x, column, j):
    """Vector of lane j."""
    return (x[column + j], x[column + LANES + j], x[column + 2 * LANES + j])


@inlined
def _put(x, column, j, v):
    """Set the vector of lane j."""
    x[column + j] = v[0]
    x[column + LANES + j] = v[1]
    x[column + 2 * LANES + j] = v[2]


@kernel
def load_lanes(lanes, index, surfaces, photons):
    """Put the photons of these numbers, at most LANES, and what they hit into the first lanes."""
    x = lanes.value
    p = surfaces.rows.params
    for j in range(len(index)):
        i = index[j]
        prim, row = surfaces.prim[i], surfaces.row[i]
        u, v = float(surfaces.u[i]), float(surfaces.v[i])
        a, b, c = corners(surfaces.geometry, prim)
        _put(x, A, j, a)
        _put(x, B, j, b)
        _put(x, C, j, c)
        x[U + j] = u
        x[V + j] = v
        _put(x, NS, j, smooth_normal(surfaces.geometry, prim, u, v))
        _put(x, WO, j, scale(load3(photons.d, i), -1.0))
        _put(x, PHI, j, load3(photons.phi, i))
        _put(x, COLOR, j, (float(p[row, 0, WEIGHT]), float(p[row, 0, WEIGHT + 1]), float(p[row, 0, WEIGHT + 2])))
        x[SEEN + j] = photons.seen[i]
        lanes.key[j] = photons.key[i]
        if len(photons.inside):
            lanes.inside[j] = photons.inside[i]


@kernel
def place(lanes):
    """Points, normals and what a deposit holds of them."""
    x = lanes.value
    for j in range(LANES):
        a, b, c = _get(x, A, j), _get(x, B, j), _get(x, C, j)
        _put(x, P, j, between(a, b, c, x[U + j], x[V + j]))
        _put(x, NG, j, face_normal(a, b, c))
    for j in range(LANES):
        ng, wo = _get(x, NG, j), _get(x, WO, j)
        x[CODE_WO + j] = pack_direction(wo)
        x[CODE_NG + j] = pack_direction(ng if dot(wo, ng) >= 0.0 else scale(ng, -1.0))


@kernel
def scatter(lanes, reach, bounce):
    """Next rays: directions, flux after Russian roulette, origins."""
    x = lanes.value
    dim = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    for j in range(LANES):
        key = lanes.key[j]
        x[U0 + j] = uniform(key, dim + 1)
        x[U1 + j] = uniform(key, dim + 2)
        x[U2 + j] = uniform(key, dim + 3)
    for j in range(LANES):
        ng, wo = _get(x, NG, j), _get(x, WO, j)
        ns = unit_or(_get(x, NS, j), ng)
        ok, wi, weight, _, _ = sample_lambert(ns, ng, wo, _get(x, COLOR, j), (0.0, x[U0 + j], x[U1 + j]), 1)
        survives, out = roulette(_get(x, PHI, j), mul(_get(x, PHI, j), weight), x[U2 + j])
        x[GOES_ON + j] = 1.0 if ok & survives else 0.0
        _put(x, OUT, j, out)
        _put(x, WI, j, wi)
        _put(x, O, j, offset_origin(_get(x, P, j), ng, wi, reach))


@kernel
def deposit_lanes(lanes, count, mode, deposits, stored):
    """Store those of the first `count` lanes that belong into the map; out: how many are now stored.

    All are written and only those counted: half of the branches would be mispredicted.
    """
    x = lanes.value
    for j in range(count):
        seen = np.int64(x[SEEN + j])
        store3(deposits.position, stored, _get(x, P, j))
        store3(deposits.flux, stored, _get(x, PHI, j))
        deposits.wi[stored] = np.uint32(np.int64(x[CODE_WO + j]))
        deposits.normal[stored] = np.uint32(np.int64(x[CODE_NG + j]))
        deposits.seen[stored] = seen
        stored += 1 if stores(mode, seen) else 0
    return stored


@kernel
def launch_lanes(lanes, count, max_rough, photons, alive):
    """Write the photons that go on behind the first `alive`; out: how many are now alive, their flux."""
    x = lanes.value
    r, g, b = 0.0, 0.0, 0.0
    for j in range(count):
        seen = np.int64(x[SEEN + j])
        out = _get(x, OUT, j)
        store3(photons.o, alive, _get(x, O, j))
        store3(photons.d, alive, _get(x, WI, j))
        store3(photons.phi, alive, out)
        photons.key[alive] = lanes.key[j]
        if len(photons.inside):
            photons.inside[alive] = lanes.inside[j]
        photons.dark[alive] = 0.0
        photons.seen[alive] = after_rough(seen)
        goes_on = (x[GOES_ON + j] > 0.0) & (seen // ONE_ROUGH < max_rough)
        r += out[0] if goes_on else 0.0
        g += out[1] if goes_on else 0.0
        b += out[2] if goes_on else 0.0
        alive += 1 if goes_on else 0
    return alive, (r, g, b)
