"""The photon pass: emit, carry through the scene, keep what falls on rough surfaces."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import lru_cache, partial

import numpy as np
from scipy.stats import qmc

from ..photons.batch import Deposits, empty_deposits, empty_photons, head, join
from ..sampling.rng import STREAM_CAUSTIC, STREAM_DIFFUSE, make_key
from .photon_kernels import ABSORBED, CAUSTIC, DROPPED, emit_at_targets, emit_everywhere, photon_step
from .render_scene import RenderScene

EMIT_DIMENSIONS = 6  # which light, which target, two for the point, two for the direction
CHUNK = 16384  # photons carried together: large enough to hide Python, small enough to stay in cache


@lru_cache(maxsize=4)
def sobol(n: int) -> np.ndarray:
    """The first n points (n, EMIT_DIMENSIONS) u32 of a Sobol sequence, scrambled once; passes shift it at random."""
    exponent = max(n - 1, 1).bit_length()
    points = qmc.Sobol(EMIT_DIMENSIONS, scramble=True, bits=32, rng=0).random_base2(exponent)[:n]
    return (points * 2.0**32).astype(np.uint32)


class PhotonRun:
    """What to trace: a mode of photon_kernels, how many, and with which random numbers."""

    def __init__(self, mode: int, total: int, key, max_bounces: int) -> None:
        self.mode = mode
        self.total = total
        self.key = key
        self.max_bounces = max_bounces
        self.points = sobol(total)


def trace_photons(
    scene: RenderScene, pool: Executor, run: PhotonRun, cancelled: Callable[[], bool]
) -> tuple[Deposits, np.ndarray, int]:
    """All photons of a run; the result does not depend on the pool.

    out : deposits in the order of the photons; energy tally (4, 3) [W]: emitted, absorbed, escaped, dropped; how many
    rays were traced.
    """
    starts = range(0, run.total, CHUNK)
    results = list(pool.map(partial(_trace_chunk, scene, run, cancelled), starts))
    tally = sum((result[1] for result in results), np.zeros((4, 3)))
    return join([result[0] for result in results]), tally, sum(result[2] for result in results)


def run_for(settings, iteration: int, mode: int) -> PhotonRun:
    """The run of one pass for the caustic map, or (modes DIFFUSE, GLOBAL) the diffuse one."""
    total = settings.caustic_photons if mode == CAUSTIC else settings.diffuse_photons
    stream = STREAM_CAUSTIC if mode == CAUSTIC else STREAM_DIFFUSE
    return PhotonRun(mode, total, make_key(settings.seed, iteration, stream), settings.max_bounces)


def _trace_chunk(scene: RenderScene, run: PhotonRun, cancelled: Callable[[], bool], first: int):
    """One chunk of photons from their lights to their ends."""
    n = min(CHUNK, run.total - first)
    tally = np.zeros((4, 3))
    photons = empty_photons(n, scene.absorbs)
    if run.mode == CAUSTIC:
        emit_at_targets(scene.lights, scene.targets, scene.laws.media, run.points, run.key, first, photons, tally)
    else:
        emit_everywhere(scene.lights, scene.laws.media, run.points, run.key, first, photons, tally)
    deposits, stored, rays = empty_deposits(2 * n), 0, 0
    for bounce in range(run.max_bounces):
        if cancelled():
            break
        surfaces = scene.surfaces(photons.o, photons.d, is_photon=True)
        rays += n
        if scene.absorbs:
            tally[ABSORBED] += scene.absorb(photons.inside, surfaces, photons.phi)
        if stored + n > len(deposits.wi):
            deposits = _grown(deposits, stored, n)
        n, stored = photon_step(scene.laws, surfaces, photons, run.mode, bounce, deposits, stored, tally)
        photons = head(photons, n)
        if n == 0:
            break
    tally[DROPPED] += photons.phi.sum(axis=0, dtype=np.float64)
    return head(deposits, stored), tally, rays


def _grown(deposits: Deposits, stored: int, more: int) -> Deposits:
    """The same deposits with room for at least `more` further ones."""
    bigger = empty_deposits(max(2 * len(deposits.wi), stored + more))
    for new, old in zip(bigger, deposits, strict=True):
        new[:stored] = old[:stored]
    return bigger
