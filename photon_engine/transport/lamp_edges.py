"""Pixels in which a lamp, seen straight or in mirrors and glass, begins or ends: there one path a pass is too few.

A lamp is hundreds of times brighter than what it lights, so a pixel that it covers by a hundredth is black in most
passes and far too bright in some: half of all noise, in a thousandth of the pixels. Only paths to what is seen are
followed there, and light nothing: they cost little. The pixels are chosen once by a look with random numbers of its
own, so passes stay independent and their mean unbiased.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial

import numpy as np

from ..sampling.rng import STREAM_PILOT, make_key
from ..settings import Settings
from .camera_kernels import camera_rays
from .clock import Clock
from .eye_batch import empty_paths, empty_tile
from .eye_pass import PIXELS_AT_ONCE, EyeRun, follow, region_of
from .render_scene import RenderScene

EDGES = 100  # number of this look among those of the pilot
MOST_FURTHER = 15  # paths more in a pixel at an edge
MOST_SHARE = 0.5  # of all pixels' number that these paths may come to
EVEN = 0.5  # a pixel is at an edge where the least emission in the 3 x 3 around it is below this part of the greatest


def find_edges(
    scene: RenderScene, pool: Executor, settings: Settings, cancelled: Callable[[], bool]
) -> tuple[np.ndarray, int]:
    """Pixels of the region at an edge of what shines, (n,) bool, and how many further paths they are worth."""
    frame = scene.frame
    height, width = frame.y1 - frame.y0, frame.x1 - frame.x0
    nothing = np.zeros(height * width, bool)
    if not scene.plan.emission.runs:
        return nothing, 0
    key = make_key(settings.seed, EDGES, STREAM_PILOT)
    bounces, splits = settings.max_bounces, settings.splits
    run = EyeRun(key, bounces, splits, 1, 0, False, 0, False, False, 0.0, nothing, 0, Clock())  # nothing is lit
    looks = pool.map(partial(_look, scene, run, len(nothing), cancelled), range(0, len(nothing), PIXELS_AT_ONCE))
    edges = at_edge(np.concatenate(list(looks)).reshape(height, width)).ravel()
    count = int(edges.sum())
    further = min(MOST_FURTHER, int(MOST_SHARE * len(edges) / count)) if count else 0
    return (edges, further) if further else (nothing, 0)


def at_edge(emission: np.ndarray) -> np.ndarray:
    """Which pixels of a picture (h, w) have an edge among them and their eight neighbours."""
    return of_nine(np.minimum, emission) < EVEN * of_nine(np.maximum, emission)


def of_nine(choose: np.ufunc, picture: np.ndarray) -> np.ndarray:
    """The least (np.minimum) or largest (np.maximum) of each pixel of a picture (h, w) and its eight neighbours."""
    wide = np.pad(picture, 1, mode="edge")
    rows = choose(choose(wide[:-2], wide[1:-1]), wide[2:])
    return choose(choose(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])


def _look(scene: RenderScene, run: EyeRun, total: int, cancelled: Callable[[], bool], first: int) -> np.ndarray:
    """Emission (n,) that one path a pixel meets, in a run of pixels."""
    n = min(PIXELS_AT_ONCE, total - first)
    tile = empty_tile(n, False)
    paths = empty_paths(n, scene.absorbs, scene.trails)
    paths.inside[:] = scene.camera_inside
    camera_rays(scene.camera, run.key, region_of(scene.frame), first, run.splits, paths)
    paths.unguided[:] = False
    follow(scene, run, paths, tile, cancelled)
    return tile.emission.sum(axis=1)
