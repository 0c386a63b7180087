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
from ..geometry.surface import between, face_normal, half_extent, mixed_normal, offset_origin, unit_or
from ..jit import inlined, kernel
from ..photons.batch import ONE_ROUGH
from ..photons.packing import pack_direction, pack_facet
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
INSTANCE = CODE_NG  # until it goes into the code
N = 45 * LANES  # normal of an ideal surface's facet, on the side of wo
IOR, MIRROR = 48 * LANES, 49 * LANES  # of an ideal surface: its index; 1: it reflects all
N_COLUMNS = 50

# columns of indices: triangle, row of lobes, corners, row of normals
PRIM, ROW, CORNER, NORMAL_ROW = 0, LANES, 2 * LANES, 5 * LANES
N_INDICES = 6


class Lanes(NamedTuple):
    """Work space for LANES hits."""

    value: np.ndarray  # (N_COLUMNS * LANES,) f64
    key: np.ndarray  # (LANES,) u64, of the photons
    inside: np.ndarray  # (LANES,) i64, media of the photons, which reflection does not change
    index: np.ndarray  # (N_INDICES * LANES,) i64, where in the scene's arrays the lanes' numbers are


def empty_lanes() -> Lanes:
    """Lanes whose unused ones hold harmless numbers."""
    indices = np.zeros(N_INDICES * LANES, np.int64)
    return Lanes(np.zeros(N_COLUMNS * LANES), np.zeros(LANES, np.uint64), np.zeros(LANES, np.int64), indices)


@inlined
def get(x, column, j):
    """Vector of lane j."""
    return (x[column + j], x[column + LANES + j], x[column + 2 * LANES + j])


@inlined
def put(x, column, j, v):
    """Set the vector of lane j."""
    x[column + j] = v[0]
    x[column + LANES + j] = v[1]
    x[column + 2 * LANES + j] = v[2]


@inlined
def leave_lane(x, j, ng, w):
    """Origin of a ray that leaves the point of lane j along w."""
    return offset_origin(get(x, P, j), ng, w, half_extent(get(x, A, j), get(x, B, j), get(x, C, j)))


@kernel
def load_lanes(lanes, index, surfaces, photons):
    """Put the photons of these numbers, at most LANES, and what they hit into the first lanes."""
    load_places(lanes, index, surfaces)
    load_shapes(lanes, len(index), surfaces.geometry)
    load_flights(lanes, index, surfaces.rows.params, photons)


@inlined
def load_places(lanes, index, surfaces):
    """Where the hits are: triangles and rows, and where these keep their numbers.

    Loops this short keep the loads of many lanes under way at once: a triangle of a big mesh is in no cache, and one
    loop over all that a lane needs took three times as long there.
    """
    x, at, g = lanes.value, lanes.index, surfaces.geometry
    for j in range(len(index)):
        i = index[j]
        at[PRIM + j] = surfaces.prim[i]
        at[ROW + j] = surfaces.row[i]
        x[U + j] = surfaces.u[i]
        x[V + j] = surfaces.v[i]
    for j in range(len(index)):
        prim = at[PRIM + j]
        for k in range(3):
            at[CORNER + k * LANES + j] = g.triangles[prim, k]
        at[NORMAL_ROW + j] = g.normal_row[prim]
        x[INSTANCE + j] = g.instance[prim]


@inlined
def load_shapes(lanes, count, geometry):
    """After `load_places`: corners and interpolated normals of the first `count` lanes."""
    x, at = lanes.value, lanes.index
    for j in range(count):
        put(x, A, j, load3(geometry.positions, at[CORNER + j]))
        put(x, B, j, load3(geometry.positions, at[CORNER + LANES + j]))
        put(x, C, j, load3(geometry.positions, at[CORNER + 2 * LANES + j]))
    for j in range(count):
        put(x, NS, j, mixed_normal(geometry.normals, at[NORMAL_ROW + j], x[U + j], x[V + j]))


@inlined
def load_flights(lanes, index, params, photons):
    """After `load_places`: the photons themselves, and the weights of the lobes that they meet."""
    x = lanes.value
    for j in range(len(index)):
        i, row = index[j], lanes.index[ROW + j]
        put(x, WO, j, scale(load3(photons.d, i), -1.0))
        put(x, PHI, j, load3(photons.phi, i))
        r, g, b = float(params[row, 0, WEIGHT]), float(params[row, 0, WEIGHT + 1]), float(params[row, 0, WEIGHT + 2])
        put(x, COLOR, j, (r, g, b))
        x[SEEN + j] = photons.seen[i]
        lanes.key[j] = photons.key[i]
        if len(photons.inside):
            lanes.inside[j] = photons.inside[i]


@kernel
def place(lanes):
    """Points and geometric normals."""
    x = lanes.value
    for j in range(LANES):
        a, b, c = get(x, A, j), get(x, B, j), get(x, C, j)
        put(x, P, j, between(a, b, c, x[U + j], x[V + j]))
        put(x, NG, j, face_normal(a, b, c))


@kernel
def encode(lanes):
    """Directions and normals as a deposit holds them."""
    x = lanes.value
    for j in range(LANES):
        ng, wo = get(x, NG, j), get(x, WO, j)
        x[CODE_WO + j] = pack_direction(wo)
        front = dot(wo, ng) >= 0.0
        x[CODE_NG + j] = pack_facet(ng if front else scale(ng, -1.0), front, x[INSTANCE + j])


@kernel
def scatter(lanes, bounce):
    """Next rays: directions, flux after Russian roulette, origins."""
    x = lanes.value
    dim = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    for j in range(LANES):
        key = lanes.key[j]
        x[U0 + j] = uniform(key, dim + 1)
        x[U1 + j] = uniform(key, dim + 2)
        x[U2 + j] = uniform(key, dim + 3)
    for j in range(LANES):
        ng, wo = get(x, NG, j), get(x, WO, j)
        ns = unit_or(get(x, NS, j), ng)
        ok, wi, weight, _, _ = sample_lambert(ns, ng, wo, get(x, COLOR, j), (0.0, x[U0 + j], x[U1 + j]), 1)
        survives, out = roulette(get(x, PHI, j), mul(get(x, PHI, j), weight), x[U2 + j])
        x[GOES_ON + j] = 1.0 if ok & survives else 0.0
        put(x, OUT, j, out)
        put(x, WI, j, wi)
        put(x, O, j, leave_lane(x, j, ng, wi))


@kernel
def deposit_lanes(lanes, count, mode, deposits, stored):
    """Store those of the first `count` lanes that belong into the map; out: how many are now stored.

    All are written and only those counted: half of the branches would be mispredicted.
    """
    x = lanes.value
    for j in range(count):
        seen = np.int64(x[SEEN + j])
        store3(deposits.position, stored, get(x, P, j))
        store3(deposits.flux, stored, get(x, PHI, j))
        deposits.wi[stored] = np.uint32(np.int64(x[CODE_WO + j]))
        deposits.normal[stored] = np.uint32(np.int64(x[CODE_NG + j]))
        deposits.seen[stored] = seen
        stored += 1 if stores(mode, seen) else 0
    return stored


@inlined
def launch(lanes, j, photons, alive):
    """Write the photon that goes on from lane j, but for its history and media."""
    x = lanes.value
    store3(photons.o, alive, get(x, O, j))
    store3(photons.d, alive, get(x, WI, j))
    store3(photons.phi, alive, get(x, OUT, j))
    photons.key[alive] = lanes.key[j]
    photons.dark[alive] = 0.0


@kernel
def launch_lanes(lanes, count, max_rough, photons, alive):
    """Write the photons that go on behind the first `alive`; out: how many are now alive, their flux."""
    x = lanes.value
    r, g, b = 0.0, 0.0, 0.0
    for j in range(count):
        seen = np.int64(x[SEEN + j])
        out = get(x, OUT, j)
        launch(lanes, j, photons, alive)
        if len(photons.inside):
            photons.inside[alive] = lanes.inside[j]
        photons.seen[alive] = after_rough(seen)
        goes_on = (x[GOES_ON + j] > 0.0) & (seen // ONE_ROUGH < max_rough)
        r += out[0] if goes_on else 0.0
        g += out[1] if goes_on else 0.0
        b += out[2] if goes_on else 0.0
        alive += 1 if goes_on else 0
    return alive, (r, g, b)
