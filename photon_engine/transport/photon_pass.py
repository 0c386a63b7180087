"""The photon pass: emit, carry through the scene, keep what falls on rough surfaces."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import lru_cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..lights.table import SHADED
from ..photons.batch import Deposits, Photons, empty_deposits, empty_photons, head
from ..photons.room import Room
from ..sampling.rng import STREAM_CAUSTIC, STREAM_DIFFUSE, STREAM_EYE, make_key
from ..sampling.sobol import sobol
from .cull import keep_those_that_meet
from .emission import multiply_radiance
from .lamp_nodes import NO_GAIN, land
from .matte_kernels import empty_lanes
from .photon_kernels import (
    ABSORBED,
    DROPPED,
    EMITTED,
    ESCAPED,
    Births,
    Leg,
    add_up,
    deep_lists,
    emit_at_targets,
    emit_everywhere,
    photon_step,
)
from .photon_rules import CAUSTIC
from .render_scene import RenderScene
from .shadowless import light_through
from .subsurface import carry_below

EMIT_DIMENSIONS = 6  # which light, which target, two for the point, two for the direction
STREAMS = STREAM_EYE + 1  # how many; stream s + n STREAMS is further numbers for the same
# photons carried together. While rays are traced the tree drives the photons out of the cache, and the other way round:
# the more photons go from one to the other together, the better
CHUNK = 65536
FEW = 8  # chunks are smaller where there would be fewer than this for the threads to share,
SMALL = 16384  # but no smaller than this for that
LEAST = 1024  # fewer are one chunk
KEPT_DESKS = 16  # work spaces that are kept from span to span and pass to pass, of up to 12 MB each


@lru_cache(maxsize=4)
def emission_numbers(n: int) -> np.ndarray:
    """Points (n, EMIT_DIMENSIONS) u32 of Sobol's sequence, scrambled once; passes shift them at random."""
    return sobol(n, EMIT_DIMENSIONS, 0)


class PhotonRun:
    """What to trace: a mode of photon_kernels, how many, and with which random numbers."""

    def __init__(self, mode: int, total: int, key, max_bounces: int) -> None:
        self.mode = mode
        self.total = total
        self.key = key
        self.max_bounces = max_bounces
        self.points = emission_numbers(total)


class Desk:
    """Work space to carry one chunk of photons; what is left on it is valid until the next chunk is carried there."""

    def __init__(self) -> None:
        self.lanes = empty_lanes()
        self.spare = empty_photons(0), empty_photons(0)
        self.lists = np.empty((3, 0), np.int32)
        self.births = Births(np.empty(0, np.int32), np.empty(0, np.int32), np.empty((0, 2), np.float32))
        self.deposits = empty_deposits(0)

    def clear(self, n: int, absorbs: bool, varied: bool) -> None:
        """Make room for n photons and one more; varied: the nodes of lamps are evaluated."""
        held = len(self.spare[0].inside) > 0, len(self.spare[0].lamp) > 0
        if self.lists.shape[1] <= n or (absorbs, varied) != held:
            self.spare = empty_photons(n + 1, absorbs, varied), empty_photons(n + 1, absorbs, varied)
            self.lists = np.empty((3, n + 1), np.int32)
            self.births = Births(np.empty(n, np.int32), np.empty(n, np.int32), np.empty((n, 2), np.float32))
        if len(self.deposits.wi) <= n:
            self.deposits = empty_deposits(n + 1)

    def grow(self, stored: int, more: int) -> None:
        """Keep the first `stored` deposits, and make room for at least `more` further ones and one more."""
        if stored + more < len(self.deposits.wi):
            return
        bigger = empty_deposits(max(2 * len(self.deposits.wi), stored + more + 1))
        for new, old in zip(bigger, self.deposits, strict=True):
            new[:stored] = old[:stored]
        self.deposits = bigger


class Rooms:
    """Memory for the runs of a render, one after another."""

    def __init__(self) -> None:
        self.deposits = Room()
        self.left = Room()
        self.desks = [Desk() for _ in range(KEPT_DESKS)]

    def desks_for(self, count: int) -> list[Desk]:
        """A desk for each of so many chunks; those beyond KEPT_DESKS are not kept."""
        return self.desks[:count] + [Desk() for _ in range(count - KEPT_DESKS)]


def trace_photons(
    scene: RenderScene, pool: Executor, run: PhotonRun, cancelled: Callable[[], bool], rooms: Rooms | None = None
) -> tuple[Deposits, np.ndarray, int]:
    """All photons of a run; the result does not depend on the pool.

    rooms : for memory that is used again; the deposits are valid until the next run with them
    out : deposits; energy tally (4, 3) [W]: emitted, absorbed, escaped, dropped; how many rays were traced.
    """
    rooms = rooms or Rooms()
    deposits, tally, rays = rooms.deposits.join([empty_deposits(0)]), np.zeros((4, 3)), 0
    waiting: list = deal(run.total)
    for bounces in generations(run.max_bounces):
        if not waiting:
            break
        desks = rooms.desks_for(len(waiting))
        carried = list(pool.map(partial(_carry, scene, run, cancelled, bounces), waiting, desks))
        deposits = rooms.deposits.append([item.deposits for item in carried])
        tally = sum((item.tally for item in carried), tally)
        rays += sum(item.rays for item in carried)
        left = rooms.left.join([item.left for item in carried])
        waiting = [Photons(*(field[part.start : part.stop] for field in left)) for part in deal(len(left.key))]
    for photons in waiting:
        add_up(photons.phi, tally[DROPPED])
    return deposits, tally, rays


def deal(total: int) -> list[range]:
    """Even shares of at most CHUNK of 0 ... total - 1, an even number of them unless there is but one."""
    if total <= LEAST:
        return [range(total)] if total > 0 else []
    count = 2 * min(-(-total // (2 * SMALL)), max(FEW // 2, -(-total // (2 * CHUNK))))
    edges = [total * k // count for k in range(count + 1)]
    return [range(first, last) for first, last in pairwise(edges)]


def generations(max_bounces: int) -> list[range]:
    """Bounces 0, 1, ... in spans that end at 2, 4, 8, ...

    After each span the photons that are left of all chunks are dealt out anew: chunks of their own would be carried on
    with a few photons each, where Python costs more than the rays.
    """
    edges = [0]
    while edges[-1] < max_bounces:
        edges.append(min(max(2, 2 * edges[-1]), max_bounces))
    return [range(first, last) for first, last in pairwise(edges)]


def run_for(settings, iteration: int, mode: int, group: int = 0, groups: int = 1) -> PhotonRun:
    """The run of one pass for the caustic map, or (modes DIFFUSE, GLOBAL) the diffuse one.

    group, groups : the run is one of several, each with the whole light in its share of the photons
    """
    total = settings.caustic_photons if mode == CAUSTIC else settings.diffuse_photons
    stream = STREAM_CAUSTIC if mode == CAUSTIC else STREAM_DIFFUSE
    key = make_key(settings.seed, iteration, stream + group * STREAMS)
    return PhotonRun(mode, -(-total // groups), key, settings.max_bounces)


class Carried(NamedTuple):
    """What became of a chunk of photons in a span of bounces."""

    deposits: Deposits
    left: Photons
    tally: np.ndarray
    rays: int


def _carry(
    scene: RenderScene,
    run: PhotonRun,
    cancelled: Callable[[], bool],
    bounces: range,
    source: Photons | range,
    desk: Desk,
) -> Carried:
    """Carry a chunk of photons, or those to be emitted with these numbers, over a span of bounces, on a desk."""
    tally = np.zeros((4, 3))
    number = len(source) if isinstance(source, range) else len(source.key)
    desk.clear(number, scene.absorbs, bool(scene.lamp_nodes))
    photons = _emitted(scene, run, source, desk, tally) if isinstance(source, range) else source
    n = len(photons.key)
    shines_through = isinstance(source, range) and run.mode != CAUSTIC and not scene.casts_all_shadows
    deep = deep_lists(n, scene.plan.subsurface.runs)
    stored, rays = 0, 0
    for bounce in bounces:
        if n == 0 or cancelled():
            break
        hits = scene.intersector.closest(photons.o, photons.d)
        if bounce == 0 and shines_through:
            hits, more = light_through(scene, photons, desk.births.light[:n], hits)
            tally[EMITTED] += more
        surfaces = scene.surfaces_at(hits, photons.d, ends_at_rough=run.mode == CAUSTIC, is_photon=True)
        rays += n
        if scene.absorbs:
            tally[ABSORBED] += scene.absorb(photons.inside, surfaces, photons.phi)
        desk.grow(stored, n)
        law = np.empty(len(surfaces.rows.kind), np.uint8)
        out = desk.spare[bounce % 2]
        out.lamp[:] = -1
        gain = land(scene, photons, surfaces, tally[EMITTED]) if scene.lamp_nodes else NO_GAIN
        leg = Leg(run.mode, bounce, desk.lanes, law, *desk.lists, gain, *deep)
        deep[0][:1] = 0  # none has gone below the surface yet
        n, stored = photon_step(scene.laws, leg, surfaces, photons, out, desk.deposits, stored, tally)
        if len(deep[0]) and deep[0][0]:
            n, more = carry_below(scene, leg, surfaces, photons, out, n, tally)
            rays += more
        photons = head(out, n)
    return Carried(head(desk.deposits, stored), photons, tally, rays)


def _emitted(scene: RenderScene, run: PhotonRun, numbers: range, desk: Desk, tally: np.ndarray) -> Photons:
    """Photons with these numbers, leaving their lights; the first step writes where these are not."""
    photons, births = head(desk.spare[1], len(numbers)), head(desk.births, len(numbers))
    media = scene.laws.media
    if run.mode == CAUSTIC:
        emit_at_targets(scene.lights, scene.targets, media, run.points, run.key, numbers.start, photons, births)
    else:
        emit_everywhere(scene.lights, scene.rings, media, run.points, run.key, numbers.start, photons, births)
    multiply_radiance(scene, births.emitter, births.place, photons.d, photons.phi)
    if scene.lamp_nodes:
        photons.lamp[:] = np.where(scene.lights.flags[births.light] & SHADED != 0, births.light, -1)
    add_up(photons.phi, tally[EMITTED])
    boxes = scene.caster_boxes if run.mode == CAUSTIC else scene.object_boxes
    if boxes is not None and (run.mode == CAUSTIC or scene.casts_all_shadows):  # else `light` must go with photons
        photons = keep_those_that_meet(boxes, scene.flat.radius, photons, tally[ESCAPED])
    return photons
