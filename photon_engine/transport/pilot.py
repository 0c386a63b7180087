"""A small pass (seed, 0) that sees how large pixels are in the scene and how dense photons lie.

It bounds the first gather radius: never larger than what the photons of a pass need, so that a picture of few pixels
is not blurred over half the scene. What it learns depends on the seed alone, so passes stay memoryless.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

from ..geometry.surface import surface_points
from ..photons.batch import Deposits, head
from ..photons.radius import neighbour_radius
from ..sampling.rng import STREAM_PILOT, make_key
from ..settings import Settings
from .eye_batch import empty_paths, empty_points, empty_tile
from .eye_kernels import camera_rays, eye_step
from .eye_pass import region_of
from .photon_pass import PhotonRun, trace_photons
from .photon_rules import CAUSTIC, DIFFUSE
from .render_scene import RenderScene

PILOT_PHOTONS = 16384
PILOT_PIXELS = 4096
PROBES = 1000
# photons within the bound, as many as a good estimate needs: few where light is focused, many where it is smooth
CAUSTIC_NEIGHBOURS = 24
DIFFUSE_NEIGHBOURS = 60


class Pilot(NamedTuple):
    """Bounds on the first radius, and the scale of pixels."""

    footprint: float  # radius of a pixel that three quarters of visible points stay below [m]; 0: nothing rough is seen
    caustic_bound: float  # [m]; 0: no such photons are traced
    diffuse_bound: float  # [m]; 0: no such photons are traced


def run_pilot(
    scene: RenderScene, pool: Executor, settings: Settings, modes: list[int], cancelled: Callable[[], bool]
) -> Pilot:
    """Trace a few photons of each mode and a few eye paths; when cancelled, what it returns means nothing."""
    visible, footprint = _visible_points(scene, settings, cancelled)
    bounds = {CAUSTIC: 0.0, DIFFUSE: 0.0}
    for mode in modes:
        key = make_key(settings.seed, mode, STREAM_PILOT)
        deposits, _, _ = trace_photons(
            scene, pool, PhotonRun(mode, PILOT_PHOTONS, key, settings.max_bounces), cancelled
        )
        total = settings.caustic_photons if mode == CAUSTIC else settings.diffuse_photons
        neighbours = CAUSTIC_NEIGHBOURS if mode == CAUSTIC else DIFFUSE_NEIGHBOURS
        # a light so far off that hardly a photon of the pilot arrives: pixels alone say how wide to gather
        few = len(deposits.position) < 2
        bounds[mode] = scene.flat.radius if few else _bound(deposits, visible, neighbours, total)
    return Pilot(footprint, bounds[CAUSTIC], bounds[DIFFUSE])


def _bound(deposits: Deposits, visible: np.ndarray, neighbours: int, total: int) -> float:
    """Radius [m] that holds `neighbours` photons of a full pass where photons lie.

    The density is measured around photons, since most of a picture has no caustic; with N times more photons the same
    number lies within 1 / sqrt(N) of the radius.
    """
    n = len(deposits.position)
    k = min(8, n)
    probes = deposits.position[:: max(1, n // PROBES)]
    radius = np.median(neighbour_radius(deposits.position, probes, k + 1 if n > k else k))
    return float(radius * np.sqrt(neighbours / k * PILOT_PHOTONS / total))


def _visible_points(
    scene: RenderScene, settings: Settings, cancelled: Callable[[], bool]
) -> tuple[np.ndarray, float]:
    """Some visible points (m, 3) and the footprint that three quarters of them stay below."""
    frame = scene.frame
    pixels = (frame.x1 - frame.x0) * (frame.y1 - frame.y0)
    count = min(pixels, PILOT_PIXELS)
    paths = empty_paths(count, scene.absorbs, scene.trails)
    paths.inside[:] = scene.camera_inside
    tile = empty_tile(count, False)
    positions, footprints = [np.zeros((0, 3), np.float32)], [np.zeros(0, np.float32)]
    # an odd stride walks through all columns
    stride = max(1, pixels // count - 1) | 1
    key = make_key(settings.seed, 0, STREAM_PILOT)
    camera_rays(scene.camera, key, region_of(frame, stride), 0, 0, paths)
    paths.unguided[:] = False
    for bounce in range(settings.max_bounces):
        surfaces = scene.surfaces(paths.o, paths.d, paths.t_max, trail=paths.trail)
        points = empty_points(len(paths.key), scene.absorbs, scene.trails)
        onward = empty_paths(len(paths.key), scene.absorbs, scene.trails)
        n, ended = eye_step(scene.laws, scene.rules, scene.seen_lights, surfaces, paths, bounce, onward, points, tile)
        if ended:
            hit = points.hit[:ended]
            p, ng, ns = (np.empty((ended, 3), np.float32) for _ in range(3))
            surface_points(surfaces.geometry, surfaces.prim[hit], surfaces.u[hit], surfaces.v[hit], p, ng, ns)
            positions.append(p)
            footprints.append(points.footprint[:ended].copy())
        paths = head(onward, n)
        if n == 0 or cancelled():
            break
    footprint = np.concatenate(footprints)
    return np.concatenate(positions), float(np.quantile(footprint, 0.75)) if len(footprint) else 0.0
