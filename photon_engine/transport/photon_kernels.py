"""One step of a batch of photons: from hit to deposit to next ray."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..bsdf.deep import pick_deep
from ..bsdf.layering import class_total, is_ideal, is_lambert
from ..bsdf.layout import CLASS_DEEP, CLASS_NULL, CLASS_ROUGH, CLASS_SHARP, LobeRows
from ..bsdf.surface import prepare_any, sample_any
from ..geometry.flatten import Geometry
from ..geometry.surface import leave, surface_point
from ..jit import inlined, kernel
from ..lights.emit import dark_distance, emit_photon
from ..lights.mesh import place_on
from ..lights.select import pick
from ..lights.table import SUN, WORLD
from ..lights.targets import aim_distant, emit_aimed
from ..photons.batch import ONE_ROUGH, SEEN_SHARP
from ..photons.packing import pack_direction, pack_facet
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, path_key, shifted, uniform
from ..vec import add, dot, load3, madd, max3, mul, scale, store3, sub
from .ideal_kernels import bend, launch_ideal, load_ideal, turn_normals
from .matte_kernels import LANES, Lanes, deposit_lanes, encode, launch_lanes, load_lanes, place, scatter
from .media import Media, after_surface
from .photon_rules import CAUSTIC, FIRST, GLOBAL, STRAIGHT, THROUGH, after_rough, roulette, stores

# rows of the energy tally
EMITTED, ABSORBED, ESCAPED, DROPPED = 0, 1, 2, 3

DEEP_DIMENSION = 8  # random numbers of a bounce: those of the choice to go below the surface

# laws of rows of lobes: one Lambert lobe; one smooth mirror or smooth glass; any others
MATTE, IDEAL, OTHER = 0, 1, 2


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


class Births(NamedTuple):
    """What is known of new photons besides themselves."""

    light: np.ndarray  # (n,) i32, index into the LightTable
    emitter: np.ndarray  # (n,) i32, triangle whose radiance is still to be multiplied into the flux; -1: none
    place: np.ndarray  # (n, 2) f32, where on it


class Laws(NamedTuple):
    """Constants of a render that kernels need."""

    threshold: float  # roughness below which a lobe is sharp
    radius: float  # of the scene: no footprint is wider [m]
    max_rough: int  # a photon ends at its next rough vertex after this many
    terminator: np.ndarray  # (instances,) f32, cutoff of geometry/terminator.py
    media: Media  # what absorbs inside closed surfaces


@kernel
def emit_everywhere(lights, rings, media, points, key, first, photons, births):
    """Photons `first` onward of len(points), from all lights by their power; points (N, 6) u32 as in rng.shifted.

    rings : lights.rings' disks for those of suns and the world; where there are none, over the whole scene evenly
    """
    total = len(points)
    ringed = len(rings.radius) > 0
    for i in range(len(photons.key)):
        n = first + i
        light, p_light, _ = pick(rings.aimed_cdf if ringed else lights.photon_cdf, shifted(points, key, n, 0))
        u0, u1 = shifted(points, key, n, 1), shifted(points, key, n, 2)
        u2, u3 = shifted(points, key, n, 3), shifted(points, key, n, 4)
        m = -1
        if ringed and (lights.kind[light] == SUN or lights.kind[light] == WORLD):
            ring, _, _ = pick(rings.pick[light], shifted(points, key, n, 5))
            o, d, phi = aim_distant(lights, rings, light, ring, u0, u1, u2, u3)
        else:
            o, d, phi, m = emit_photon(lights, light, u0, u1, u2, u3)
        photons.key[i] = path_key(key, n)
        _launch(lights, media, photons, births, i, light, (o, d, scale(phi, 1.0 / (p_light * total))), m)


@kernel
def emit_at_targets(lights, targets, media, points, key, first, photons, births):
    """Photons `first` onward of len(points), aimed at the specular objects."""
    total = len(points)
    for i in range(len(photons.key)):
        n = first + i
        light, p_light, _ = pick(targets.aimed_cdf, shifted(points, key, n, 0))
        o, d, phi, m = emit_aimed(
            lights,
            targets,
            light,
            shifted(points, key, n, 5),
            shifted(points, key, n, 1),
            shifted(points, key, n, 2),
            shifted(points, key, n, 3),
            shifted(points, key, n, 4),
        )
        photons.key[i] = path_key(key, n)
        _launch(lights, media, photons, births, i, light, (o, d, scale(phi, 1.0 / (p_light * total))), m)


@inlined
def _launch(lights, media, photons, births, i, light, ray, m):
    """Write new photon i, which left a light by this ray (o, d, flux), and its birth; m : as of `emit_photon`."""
    o, d, phi = ray
    store3(photons.o, i, o)
    store3(photons.d, i, d)
    store3(photons.phi, i, phi)
    photons.seen[i] = 0
    photons.dark[i] = dark_distance(lights, light, o, d)
    if len(photons.inside):
        photons.inside[i] = media.at_light[light]
    births.light[i] = light
    births.emitter[i] = -1
    if m >= 0 and lights.tri_shaded[m]:
        births.emitter[i] = lights.tri_id[m]
        births.place[i, 0], births.place[i, 1] = place_on(lights, m, o)


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
def add_up(phi, total):
    """Add flux (n, 3) to a total (3,) f64."""
    sums = (0.0, 0.0, 0.0)
    for i in range(len(phi)):
        sums = add(sums, load3(phi, i))
    for c in range(3):
        total[c] += sums[c]


class Leg(NamedTuple):
    """One bounce of a batch of photons, and work space for it."""

    mode: int  # CAUSTIC, DIFFUSE or GLOBAL
    bounce: int
    lanes: Lanes
    law: np.ndarray  # (rows,) u8, which of the three ways below is for a row of lobes
    matte: np.ndarray  # (n,) i32, which photons hit a Lambert surface
    ideal: np.ndarray  # (n,) i32, which hit a smooth mirror or smooth glass
    other: np.ndarray  # (n,) i32, which hit any other surface
    gain: np.ndarray  # (n, 3) f32, what flux is times unless it goes straight on (transport/lamp_nodes.py); (0, 3): 1
    deep: np.ndarray  # (n + 1,) i32, how many go on below the surface, then which; (0,): no material has that
    deep_lobe: np.ndarray  # (n,) i32, in which lobe, by photon
    deep_share: np.ndarray  # (n,) f64, the probability of that choice


def deep_lists(n: int, wanted: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Room for a Leg's photons below the surface; none where no material scatters there."""
    room = n if wanted else 0
    return np.zeros(room + 1 if wanted else 0, np.int32), np.empty(room, np.int32), np.empty(room)


@kernel
def photon_step(laws, leg, surfaces, photons, out, deposits, stored, tally):
    """Carry photons through their hits; out: how many go on, how many are now stored.

    Those that go on are the first of `out`, which has room for len(photons) + 1; `deposits` has for as many more than
    are stored. First those from Lambert surfaces, then those from ideal mirrors and glass, then the others, each in the
    order that they had.
    """
    absorbed = (0.0, 0.0, 0.0)
    sort_rows(surfaces.rows, leg.law)
    n_matte, n_ideal, n_other = sort_hits(surfaces, photons, leg, tally)
    keeps = leg.bounce > 0 or leg.mode == GLOBAL
    if leg.mode == CAUSTIC and not keeps:
        n_matte = 0
    alive = 0
    for first in range(0, n_matte, LANES):
        index = leg.matte[first : min(first + LANES, n_matte)]
        load_lanes(leg.lanes, index, surfaces, photons)
        place(leg.lanes)
        if keeps:
            encode(leg.lanes)
            stored = deposit_lanes(leg.lanes, len(index), leg.mode, deposits, stored)
        if leg.mode != CAUSTIC:
            scatter(leg.lanes, leg.bounce)
            alive, gone = launch_lanes(leg.lanes, len(index), laws.max_rough, out, alive)
            absorbed = sub(absorbed, gone)
    for first in range(0, n_ideal, LANES):
        index = leg.ideal[first : min(first + LANES, n_ideal)]
        load_lanes(leg.lanes, index, surfaces, photons)
        load_ideal(leg.lanes, index, surfaces)
        place(leg.lanes)
        turn_normals(leg.lanes, index, surfaces)
        bend(leg.lanes, leg.bounce)
        alive, gone = launch_ideal(leg.lanes, index, surfaces, laws.media, out, alive)
        absorbed = sub(absorbed, gone)
    for k in range(n_other):
        i = leg.other[k]
        alive, stored, gone = _any_hit(laws, leg, surfaces, photons, i, out, alive, deposits, stored, tally)
        absorbed = sub(absorbed, gone)
    for c in range(3):
        tally[ABSORBED, c] += absorbed[c]
    return alive, stored


@kernel
def sort_rows(rows, law):
    """Tell for each row of lobes which law it follows: law (rows,) u8."""
    for row in range(len(law)):
        law[row] = MATTE if is_lambert(rows, row) else IDEAL if is_ideal(rows, row) else OTHER


@kernel
def sort_hits(surfaces, photons, leg, tally):
    """List the photons on Lambert surfaces, those on ideal ones and those on others in `leg`; out: how many each.

    The flux of those that hit nothing, or too near to a soft lamp, is counted, that of all hits as absorbed. Without
    branches: which surface comes next is anybody's guess.
    """
    n_matte, n_ideal, n_other = 0, 0, 0
    absorbed, escaped = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(len(photons.key)):
        hit = surfaces.prim[i] >= 0
        phi = load3(photons.phi, i)
        absorbed = madd(absorbed, 1.0 if hit else 0.0, phi)
        escaped = madd(escaped, 0.0 if hit else 1.0, phi)
        dark, law = photons.dark[i], leg.law[surfaces.row[i]]
        lit = hit & (surfaces.t[i] >= dark)
        leg.matte[n_matte] = i
        leg.ideal[n_ideal] = i
        leg.other[n_other] = i
        n_matte += 1 if lit & (law == MATTE) & (dark != STRAIGHT) else 0
        n_ideal += 1 if lit & (law == IDEAL) & (dark != THROUGH) else 0
        n_other += 1 if hit & (law == OTHER) else 0
    for c in range(3):
        tally[ABSORBED, c] += absorbed[c]
        tally[ESCAPED, c] += escaped[c]
    return n_matte, n_ideal, n_other


@inlined
def _any_hit(laws, leg, surfaces, photons, i, out, alive, deposits, stored, tally):
    """Carry photon i through its hit on any surface; out: now alive, now stored, flux that goes on."""
    rows, row, scratch = surfaces.rows, surfaces.row[i], surfaces.scratch
    p, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
    phi = load3(photons.phi, i)
    lit = mul(phi, load3(leg.gain, i)) if len(leg.gain) else phi
    wo = scale(load3(photons.d, i), -1.0)
    weights = prepare_any(rows, row, ns, ng, wo, laws.threshold, scratch)
    seen, key, limit = photons.seen[i], photons.key[i], photons.dark[i]
    near = surfaces.t[i] < limit  # a soft lamp does not light it, but shines on through it
    p_deep = class_total(rows, row, scratch, CLASS_DEEP) if len(leg.deep) else 0.0
    p_null, p_sharp, p_rough, p_deep = _allowed(weights, p_deep, near, limit)
    if p_rough + p_deep > 0.0 and stores(leg.mode, seen) and (len(leg.gain) == 0 or max3(lit) > 0.0):
        store3(deposits.position, stored, p)
        store3(deposits.flux, stored, lit)
        deposits.wi[stored] = pack_direction(wo)
        front = dot(wo, ng) >= 0.0
        instance = surfaces.geometry.instance[surfaces.prim[i]]
        deposits.normal[stored] = pack_facet(ng if front else scale(ng, -1.0), front, instance)
        deposits.seen[stored] = seen
        stored += 1
    if leg.mode == CAUSTIC or seen // ONE_ROUGH >= laws.max_rough:
        p_rough, p_deep = 0.0, 0.0
    share = 0.0
    if p_deep > 0.0:
        share = p_deep / (p_null + p_sharp + p_rough + p_deep)
        if _goes_below(leg, rows, row, scratch, i, share, key):
            return alive, stored, scale(_earned(tally, phi, lit), -1.0)
    goes_on, wi, out_phi, cls = _scatter(
        rows, row, (ns, ng, wo), (p_null, p_sharp, p_rough), laws.threshold, scratch, (phi, lit), key, leg.bounce, share
    )
    more = _earned(tally, phi, lit) if len(leg.gain) and cls != CLASS_NULL else (0.0, 0.0, 0.0)
    if not goes_on:
        return alive, stored, scale(more, -1.0)
    if len(photons.inside):
        out.inside[alive] = after_surface(laws.media, photons.inside[i], surfaces.prim[i], dot(ng, wo), dot(ng, wi))
    store3(out.o, alive, leave(surfaces.geometry, surfaces.prim[i], p, ng, wi))
    store3(out.d, alive, wi)
    store3(out.phi, alive, out_phi)
    if len(photons.lamp):
        out.lamp[alive] = photons.lamp[i] if cls == CLASS_NULL else -1
    out.key[alive] = key
    out.dark[alive] = STRAIGHT if cls == CLASS_NULL and limit <= FIRST else limit - surfaces.t[i] if near else 0.0
    if cls == CLASS_SHARP:
        seen |= SEEN_SHARP
    elif cls == CLASS_ROUGH:
        seen = after_rough(seen)
    out.seen[alive] = seen
    return alive + 1, stored, sub(out_phi, more)


@inlined
def _allowed(weights, p_deep, near, limit):
    """Weights (null, sharp, rough, deep) of the lobes that may scatter a photon with this limit of a soft lamp."""
    p_null, p_sharp, p_rough = weights
    if near:
        p_sharp, p_rough, p_deep = 0.0, 0.0, 0.0
    if limit == STRAIGHT:
        p_rough, p_deep = 0.0, 0.0
    elif limit == THROUGH:
        p_null, p_sharp = 0.0, 0.0
    return p_null, p_sharp, p_rough, p_deep


@inlined
def _earned(tally, phi, lit):
    """What a lamp's nodes change of a photon's flux, which counts as emitted."""
    more = sub(lit, phi)
    for c in range(3):
        tally[EMITTED, c] += more[c]
    return more


@kernel
def _goes_below(leg, rows, row, scratch, i, share, key):
    """Whether photon i takes a SUBSURFACE lobe of its hit, with the probability `share`; it is listed then."""
    dim = (leg.bounce + 1) * DIMENSIONS_PER_BOUNCE + DEEP_DIMENSION
    if uniform(key, dim) >= share:
        return False
    k, p = pick_deep(rows, row, scratch, uniform(key, dim + 1))
    leg.deep[0] += 1
    leg.deep[leg.deep[0]] = i
    leg.deep_lobe[i] = k
    leg.deep_share[i] = share * p
    return True


@inlined
def _scatter(rows, row, frame, weights, threshold, scratch, phi, key, bounce, below):
    """Next direction and flux of a photon, or its end by Russian roulette.

    phi : its flux for straight passes, and for all others;  below : the share of photons that go below the surface
    out : (whether it goes on, wi, flux, class of the lobe)
    """
    nothing = (False, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), CLASS_ROUGH)
    if weights[0] + weights[1] + weights[2] <= 0.0:
        return nothing
    dim = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    cls, p_class, u0 = choose_class(weights[0], weights[1], weights[2], uniform(key, dim))
    before = phi[0] if cls == CLASS_NULL else phi[1]
    if max3(before) <= 0.0:
        return nothing
    ns, ng, wo = frame
    u = (u0, uniform(key, dim + 1), uniform(key, dim + 2))
    ok, wi, weight, _, _ = sample_any(rows, row, ns, ng, wo, cls, scratch, u, 1)
    if not ok:
        return False, wi, before, cls
    survives, out = roulette(before, scale(mul(before, weight), 1.0 / (p_class * (1.0 - below))), uniform(key, dim + 3))
    return survives, wi, out, cls
