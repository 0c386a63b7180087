"""One step of a batch of photons: from hit to deposit to next ray."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.layout import CLASS_ROUGH, CLASS_SHARP, LobeRows
from ..bsdf.surface import prepare, sample
from ..geometry.flatten import Geometry
from ..geometry.surface import offset_origin, surface_point
from ..jit import inlined, kernel
from ..lights.emit import dark_distance, emit_photon
from ..lights.select import pick
from ..lights.targets import emit_aimed
from ..photons.batch import MAX_ROUGH, ONE_ROUGH, SEEN_SHARP
from ..photons.packing import pack_direction
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, path_key, shifted, uniform
from ..vec import add, dot, load3, max3, scale, store3, sub
from .media import Media, after_surface

CAUSTIC = 0  # store L S+ D, stop at the first D
DIFFUSE = 1  # store every D after the first D; go on
GLOBAL = 2  # store every D, for final gathering; go on

# rows of the energy tally
EMITTED, ABSORBED, ESCAPED, DROPPED = 0, 1, 2, 3


class Surfaces(NamedTuple):
    """What the rays of a batch hit, and how it scatters."""

    geometry: Geometry
    rows: LobeRows
    row: np.ndarray  # (n,) i32, row of each hit
    prim: np.ndarray  # (n,) i32, -1: nothing
    u: np.ndarray  # (n,) f32
    v: np.ndarray  # (n,) f32
    t: np.ndarray  # (n,) f32
    scratch: np.ndarray  # (K, 8) f64, work space of the lobes' functions


class Laws(NamedTuple):
    """Constants of a render that kernels need."""

    threshold: float  # roughness below which a lobe is sharp
    reach: float  # radius of the scene [m]
    max_rough: int  # a photon ends at its next rough vertex after this many
    terminator: np.ndarray  # (instances,) f32, cutoff of geometry/terminator.py
    media: Media  # what absorbs inside closed surfaces


@kernel
def emit_everywhere(lights, media, points, key, first, photons, tally):
    """Photons `first` onward of len(points), from all lights by their power; points (N, 6) u32 as in rng.shifted."""
    total = len(points)
    for i in range(len(photons.key)):
        k = path_key(key, first + i)
        n = first + i
        light, p_light, _ = pick(lights.photon_cdf, shifted(points, key, n, 0))
        o, d, phi = emit_photon(
            lights,
            light,
            shifted(points, key, n, 1),
            shifted(points, key, n, 2),
            shifted(points, key, n, 3),
            shifted(points, key, n, 4),
        )
        photons.dark[i] = dark_distance(lights, light, o, d)
        if len(photons.inside):
            photons.inside[i] = media.at_light[light]
        _launch(photons, i, k, o, d, scale(phi, 1.0 / (p_light * total)), tally)


@kernel
def emit_at_targets(lights, targets, media, points, key, first, photons, tally):
    """Photons `first` onward of len(points), aimed at the specular objects."""
    total = len(points)
    for i in range(len(photons.key)):
        k = path_key(key, first + i)
        n = first + i
        light, p_light, _ = pick(targets.aimed_cdf, shifted(points, key, n, 0))
        o, d, phi = emit_aimed(
            lights,
            targets,
            light,
            shifted(points, key, n, 5),
            shifted(points, key, n, 1),
            shifted(points, key, n, 2),
            shifted(points, key, n, 3),
            shifted(points, key, n, 4),
        )
        photons.dark[i] = dark_distance(lights, light, o, d)
        if len(photons.inside):
            photons.inside[i] = media.at_light[light]
        _launch(photons, i, k, o, d, scale(phi, 1.0 / (p_light * total)), tally)


@inlined
def _launch(photons, i, k, o, d, phi, tally):
    """Write a new photon and count its flux."""
    store3(photons.o, i, o)
    store3(photons.d, i, d)
    store3(photons.phi, i, phi)
    photons.key[i] = k
    photons.seen[i] = 0
    for c in range(3):
        tally[EMITTED, c] += phi[c]


@kernel
def choose_class(p_null, p_sharp, p_rough, u):
    """A class of lobes by sampling weight, its probability, and the number reused. Weights must not all be zero."""
    total = p_null + p_sharp + p_rough
    x = u * total
    if x < p_rough:
        return 2, p_rough / total, x / p_rough
    if x < p_rough + p_sharp:
        return 1, p_sharp / total, (x - p_rough) / p_sharp
    if p_null > 0.0:
        return 0, p_null / total, min((x - p_rough - p_sharp) / p_null, 0.9999999)
    return (1, p_sharp / total, 0.5) if p_sharp > 0.0 else (2, p_rough / total, 0.5)


@kernel
def stores(mode, seen):
    """Whether a photon that arrives at a rough lobe with this history belongs into the map of this mode."""
    if mode == CAUSTIC:
        return seen == SEEN_SHARP
    if mode == DIFFUSE:
        return seen >= ONE_ROUGH
    return True


@kernel
def photon_step(laws, surfaces, photons, mode, bounce, deposits, stored, tally):
    """Carry photons through their hits; out: how many go on (compacted to the front), how many are now stored.

    `deposits` has room for len(photons) more than `stored`.
    """
    geometry, rows = surfaces.geometry, surfaces.rows
    scratch = surfaces.scratch
    absorbed, escaped = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    alive = 0
    for i in range(len(photons.key)):
        phi = load3(photons.phi, i)
        if surfaces.prim[i] < 0:
            escaped = add(escaped, phi)
            continue
        absorbed = add(absorbed, phi)
        if surfaces.t[i] < photons.dark[i]:
            continue
        p, ng, ns = surface_point(geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = scale(load3(photons.d, i), -1.0)
        row = surfaces.row[i]
        p_null, p_sharp, p_rough = prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
        seen = photons.seen[i]
        if p_rough > 0.0 and stores(mode, seen):
            store3(deposits.position, stored, p)
            store3(deposits.flux, stored, phi)
            deposits.wi[stored] = pack_direction(wo)
            deposits.normal[stored] = pack_direction(ng if dot(wo, ng) >= 0.0 else scale(ng, -1.0))
            deposits.seen[stored] = seen
            stored += 1
        if mode == CAUSTIC or seen // ONE_ROUGH >= laws.max_rough:
            p_rough = 0.0
        key = photons.key[i]
        go_on, wi, phi_out, cls = _scatter(
            rows, row, (ns, ng, wo), (p_null, p_sharp, p_rough), laws.threshold, scratch, phi, key, bounce
        )
        if not go_on:
            continue
        absorbed = sub(absorbed, phi_out)
        if len(photons.inside):
            beyond = after_surface(laws.media, photons.inside[i], surfaces.prim[i], dot(ng, wo), dot(ng, wi))
            photons.inside[alive] = beyond
        store3(photons.o, alive, offset_origin(p, ng, wi, laws.reach))
        store3(photons.d, alive, wi)
        store3(photons.phi, alive, phi_out)
        photons.key[alive] = key
        photons.dark[alive] = max(photons.dark[i] - surfaces.t[i], 0.0)
        if cls == CLASS_SHARP:
            seen |= SEEN_SHARP
        elif cls == CLASS_ROUGH and seen // ONE_ROUGH < MAX_ROUGH:
            seen += ONE_ROUGH
        photons.seen[alive] = seen
        alive += 1
    for c in range(3):
        tally[ABSORBED, c] += absorbed[c]
        tally[ESCAPED, c] += escaped[c]
    return alive, stored


@inlined
def _scatter(rows, row, frame, weights, threshold, scratch, phi, key, bounce):
    """Next direction and flux of a photon, or its end by Russian roulette.

    The survivors' strongest channel keeps its flux, so photons stay about equally strong [Jensen 2001, 5.2].
    """
    nothing = (False, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0)
    if weights[0] + weights[1] + weights[2] <= 0.0:
        return nothing
    dim = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    cls, p_class, u0 = choose_class(weights[0], weights[1], weights[2], uniform(key, dim))
    ns, ng, wo = frame
    u = (u0, uniform(key, dim + 1), uniform(key, dim + 2))
    ok, wi, weight, _, _ = sample(rows, row, ns, ng, wo, cls, scratch, u, 1, threshold)
    if not ok:
        return nothing
    out = (phi[0] * weight[0] / p_class, phi[1] * weight[1] / p_class, phi[2] * weight[2] / p_class)
    before, after = max3(phi), max3(out)
    if after <= 0.0:
        return nothing
    survival = min(1.0, after / before)
    if uniform(key, dim + 3) >= survival:
        return nothing
    return True, wi, scale(out, 1.0 / survival), cls
