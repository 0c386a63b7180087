"""Pixels in which a lamp, seen straight or in mirrors and glass, begins or ends: there one path a pass is too few.

A lamp is hundreds of times brighter than what it lights, so a pixel that it covers by a hundredth is black in most
passes and far too bright in some: half of all noise, in a thousandth of the pixels. Only paths to what is seen are
followed there, and light nothing: they cost little. Where they go is chosen once by looks with random numbers of their
own, so passes stay independent and their mean unbiased: to every pixel at an edge, and to glints (glints.py).
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from itertools import count

import numpy as np

from ..camera.filters import filter_position
from ..lights.enlarge import enlarged
from ..sampling.rng import STREAM_PILOT, make_key
from ..settings import Settings
from .camera_kernels import further_rays
from .clock import Clock
from .eye_batch import empty_paths, empty_tile
from .eye_pass import PIXELS_AT_ONCE, EyeRun, LampImages, follow, no_images, region_of
from .glints import BRIGHT, allot, find_boxes, no_glints
from .render_scene import RenderScene

EDGES = 100  # number of the first look among those of the pilot
LOOKS = 8  # paths a pixel that look for glints, at larger lamps,
LEAST_LOOKED, MOST_LOOKED = 1 << 13, 1 << 17  # but within these and at least one: large pictures have large glints
LARGER = 12.0  # times their size
MOST_FURTHER = 15  # paths more in a pixel at an edge
MOST_SHARE = 0.5  # of all pixels' number that these paths may come to
EVEN = 0.5  # a pixel is at an edge where the least emission in the 3 x 3 around it is below this part of the greatest


class Probe:
    """Tells the emission that paths meet; calls have random numbers of their own, one after another."""

    def __init__(self, scene: RenderScene, pool: Executor, settings: Settings, cancelled: Callable[[], bool]) -> None:
        self.scene, self.pool, self.cancelled = scene, pool, cancelled
        self.keys = (make_key(settings.seed, EDGES + i, STREAM_PILOT) for i in count())
        n = (scene.frame.x1 - scene.frame.x0) * (scene.frame.y1 - scene.frame.y0)
        # nothing is lit
        self.run = EyeRun(np.uint64(0), settings.max_bounces, settings.splits, 1, 0, False, 0, False, False, 0.0,
                          no_images(n), Clock())  # fmt: skip

    def __call__(self, film: np.ndarray, size: float) -> np.ndarray:
        """Emission on the screen (m,) of paths through film (m, 2) [px], with lamps `size` times as large."""
        scene = copy.copy(self.scene)
        if size != 1.0:
            scene.seen_lights = enlarged(scene.seen_lights, size) or scene.seen_lights
        run = self.run._replace(key=next(self.keys))
        parts = [film[first : first + PIXELS_AT_ONCE] for first in range(0, len(film), PIXELS_AT_ONCE)]
        found = list(self.pool.map(partial(emission_met, scene, run, self.cancelled), parts, count(1, PIXELS_AT_ONCE)))
        return np.concatenate([np.zeros(0), *found])


def emission_met(
    scene: RenderScene, run: EyeRun, cancelled: Callable[[], bool], film: np.ndarray, number: int
) -> np.ndarray:
    """Emission on the screen (m,) f64, the mean of three channels, of paths through film (m, 2) [px].

    number : of the first among paths of the run's key. Beyond the frame paths go through the nearest pixel.
    """
    frame, m = scene.frame, len(film)
    corner, most = np.array([frame.x0, frame.y0]), np.array([frame.x1, frame.y1]) - 1
    pixel = np.clip(np.floor(film).astype(np.int64), corner, most)
    points = filter_position(scene.camera.filter, film - pixel - 0.5)
    index = (pixel[:, 1] - frame.y0) * (frame.x1 - frame.x0) + pixel[:, 0] - frame.x0
    paths = empty_paths(m, scene.absorbs, scene.trails)
    paths.inside[:] = scene.camera_inside
    numbers = np.arange(number, number + m)
    further_rays(scene.camera, run.key, region_of(frame), index, numbers, points, run.splits, paths)
    paths.unguided[:] = False
    tile = empty_tile(m, False)
    follow(scene, run, paths, tile, cancelled)
    return tile.emission.mean(axis=1, dtype=np.float64) * frame.exposure


def find_images(
    scene: RenderScene, pool: Executor, settings: Settings, cancelled: Callable[[], bool]
) -> LampImages:
    """Where further paths go in every pass."""
    frame = scene.frame
    height, width = frame.y1 - frame.y0, frame.x1 - frame.x0
    if not scene.plan.emission.runs:
        return no_images(height * width)
    probe = Probe(scene, pool, settings, cancelled)
    rng = np.random.default_rng([settings.seed, EDGES])
    corners = np.stack(np.meshgrid(np.arange(frame.x0, frame.x1), np.arange(frame.y0, frame.y1)), -1).reshape(-1, 2)
    look = corners + rng.random(corners.shape)
    edges = at_edge(probe(look, 1.0).reshape(height, width)).ravel()
    number = int(edges.sum())
    further = min(MOST_FURTHER, int(MOST_SHARE * len(edges) / number)) if number else 0
    glints = no_glints(len(edges))
    if enlarged(scene.seen_lights, LARGER) is not None:
        looked = max(min(max(LOOKS * len(edges), LEAST_LOOKED), MOST_LOOKED), len(edges))
        film = [frame.x0, frame.y0] + rng.random((looked, 2)) * [width, height]
        near = film[probe(film, LARGER) > BRIGHT]
        near = near[probe(near, 1.0) <= BRIGHT]  # what is met at its own size is no glint
        glints = allot(*find_boxes(probe, near, settings.seed), scene.camera.filter, frame)
    if cancelled():
        return no_images(len(edges))
    return LampImages(edges, further, glints)


def at_edge(emission: np.ndarray) -> np.ndarray:
    """Which pixels of a picture (h, w) have an edge among them and their eight neighbours."""
    return of_nine(np.minimum, emission) < EVEN * of_nine(np.maximum, emission)


def of_nine(choose: np.ufunc, picture: np.ndarray) -> np.ndarray:
    """The least (np.minimum) or largest (np.maximum) of each pixel of a picture (h, w) and its eight neighbours."""
    wide = np.pad(picture, 1, mode="edge")
    rows = choose(choose(wide[:-2], wide[1:-1]), wide[2:])
    return choose(choose(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
