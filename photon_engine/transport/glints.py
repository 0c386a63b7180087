"""Glints: images of lamps far smaller than a pixel, as glass and polished metal show them.

A path meets one by chance, one of hundreds, and is then thousands of times too bright: a firefly. So they are searched
for once, and every pass sends paths of its own to where they are. The search goes from easy to hard [splitting; Kahn
and Harris 1951]: paths that met a lamp of several times its size are moved a little, at random, until they meet it at
its own size; what lies around the last of them is a box on the film. A pixel's paths are then a mixture, evenly over
its filter and evenly over the boxes, weighed by the balance heuristic [Veach and Guibas 1995, eq. 14]: the mean is
right whatever was found or overlooked. In wine_glass the relative variance of Emission by 4 camera paths a pixel falls
from 3 or more (who knows: 2000 paths a pixel met some glints once) to 0.005.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..camera.filters import filter_position
from ..jit import kernel

STAGES = (8.0, 5.5, 4.0, 2.7, 1.8, 1.3, 1.0)  # sizes of lamps, after the one that found the first paths
PROBES = 16  # paths about each of those that met a lamp
KEPT = 2  # of those that met the lamp, about each parent
NEAREST, FARTHEST = 1e-3, 0.5  # how far they are moved [px], evenly in the logarithm
MOST_PARENTS = 1024
LARGE = 0.1  # [px^2], what covers as much is found by any path
MARGIN = 0.2  # of a box, beyond the outermost paths that met the lamp
TINY = 1e-4  # [px], a box at least
BRIGHT = 1.0  # on the screen, where white is 1: what is darker makes no fireflies
DIM = 0.1  # squared brightness, on the screen, below which errors are not seen: mid-grey light lies beside glints
FAINT = 0.05  # standard deviation of a path, against brightness, that is not worth one
MOST_PATHS = 16  # for a box in a pixel
MOST_SHARE = 0.25  # of the pixels' number that all of them may come to

Probe = Callable[[np.ndarray, float], np.ndarray]  # film (m, 2), size of lamps -> emission on the screen (m,)


class Glints(NamedTuple):
    """Boxes of n pixels, B in all: those of pixel p are first[p] ... first[p + 1] - 1."""

    first: np.ndarray  # (n + 1,) i64
    box: np.ndarray  # (B, 4) f64: from u, to u, from v, to v in the unit square of the pixel's filter
    count: np.ndarray  # (B,) i64, paths of each of the pixel's camera paths


def no_glints(n: int) -> Glints:
    """None in any of n pixels."""
    return Glints(np.zeros(n + 1, np.int64), np.empty((0, 4)), np.empty(0, np.int64))


def find_boxes(probe: Probe, film: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (B, 4) f64 on the film [px]: low x, high x, low y, high y; light: mean and deviation (B, 2) within them.

    film : (m, 2) f64 where paths met enlarged lamps
    """
    rng = np.random.default_rng([seed, len(film)])
    for size in STAGES:
        around = scattered(some(film, MOST_PARENTS, rng), rng)
        film = some_met(around, probe(around.reshape(-1, 2), size).reshape(around.shape[:2]) > BRIGHT, rng)
    film = some(film, MOST_PARENTS, rng)
    if not len(film):
        return np.empty((0, 4)), np.empty((0, 2))
    around = scattered(film, rng)
    met = probe(around.reshape(-1, 2), 1.0).reshape(around.shape[:2]) > BRIGHT
    low = np.where(met[..., None], around, np.inf).min(axis=1)
    high = np.where(met[..., None], around, -np.inf).max(axis=1)
    known = met.any(axis=1)
    boxes = merged(widened(np.stack([low[:, 0], high[:, 0], low[:, 1], high[:, 1]], 1)[known]))
    boxes = boxes[area(boxes) < LARGE]
    at = rng.random((len(boxes), PROBES, 2)) * (boxes[:, None, 1::2] - boxes[:, None, ::2]) + boxes[:, None, ::2]
    light = probe(at.reshape(-1, 2), 1.0).reshape(len(boxes), PROBES)
    return boxes, np.stack([light.mean(axis=1), light.std(axis=1)], 1)


def scattered(film: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Each place (m, 2) and PROBES others about it, nearer ones more densely: (m, 1 + PROBES, 2)."""
    reach = NEAREST * (FARTHEST / NEAREST) ** rng.random((len(film), PROBES, 1))
    moved = film[:, None] + reach * rng.uniform(-1.0, 1.0, (len(film), PROBES, 2))
    return np.concatenate([film[:, None], moved], axis=1)


def some(film: np.ndarray, most: int, rng: np.random.Generator) -> np.ndarray:
    """At most so many of the places (m, 2)."""
    return film if len(film) <= most else film[rng.choice(len(film), most, replace=False)]


def some_met(around: np.ndarray, met: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Of the places (m, k, 2) about each of m parents at most KEPT that met (m, k) a lamp, at random: (n, 2)."""
    order = np.where(met, rng.random(met.shape), np.inf)
    chosen = np.argsort(order, axis=1)[:, :KEPT]
    return np.take_along_axis(around, chosen[..., None], 1)[np.take_along_axis(met, chosen, 1)]


def area(boxes: np.ndarray) -> np.ndarray:
    """Of boxes (B, 4)."""
    return (boxes[:, 1] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 2])


def widened(boxes: np.ndarray) -> np.ndarray:
    """Boxes (B, 4) with a margin all round."""
    size = boxes[:, 1::2] - boxes[:, ::2]
    more = np.maximum(MARGIN * size, 0.5 * TINY)
    wide = boxes.copy()
    wide[:, ::2] -= more
    wide[:, 1::2] += more
    return wide


def merged(boxes: np.ndarray) -> np.ndarray:
    """Boxes (B, 4), of which none has its middle in another: those that had are one now."""
    kept, n = np.empty_like(boxes), 0
    for box in boxes[np.argsort(-area(boxes))]:
        x, y = 0.5 * (box[::2] + box[1::2])
        low_x, high_x, low_y, high_y = kept[:n].T
        around = np.flatnonzero((low_x <= x) & (x <= high_x) & (low_y <= y) & (y <= high_y))
        if len(around):
            other = kept[around[0]]
            other[::2], other[1::2] = np.minimum(other[::2], box[::2]), np.maximum(other[1::2], box[1::2])
        else:
            kept[n] = box
            n += 1
    return kept[:n]


def allot(boxes: np.ndarray, light: np.ndarray, table: np.ndarray, frame) -> Glints:
    """The boxes of every pixel whose filter reaches there, with paths enough to be seen no more than other noise.

    boxes, light : as of `find_boxes`;  table : of the filter;  frame : scene.data.Frame
    """
    width, height = frame.x1 - frame.x0, frame.y1 - frame.y0
    rows = []
    for (x0, x1, y0, y1), (mean, deviation) in zip(boxes, light, strict=True):
        px = np.arange(max(int(x0 - table[-1] - 0.5), frame.x0), min(int(x1 + table[-1] + 0.5) + 1, frame.x1))
        py = np.arange(max(int(y0 - table[-1] - 0.5), frame.y0), min(int(y1 + table[-1] + 0.5) + 1, frame.y1))
        u0, u1 = (filter_position(table, x - px - 0.5) for x in (x0, x1))
        v0, v1 = (filter_position(table, y - py - 0.5) for y in (y0, y1))
        share = (v1 - v0)[:, None] * (u1 - u0)  # of the pixel's paths that fall into the box
        noise = share * deviation / np.sqrt((share * mean) ** 2 + DIM)
        for j, i in np.argwhere(noise > FAINT):
            pixel = (py[j] - frame.y0) * width + px[i] - frame.x0
            rows.append((pixel, u0[i], u1[i], v0[j], v1[j], noise[j, i]))
    if not rows:
        return no_glints(width * height)
    table_of = np.array(sorted(rows))
    wanted = np.clip(4.0 * table_of[:, 5], 1.0, MOST_PATHS)
    wanted *= min(1.0, MOST_SHARE * width * height / wanted.sum())
    table_of, wanted = table_of[wanted >= 0.5], wanted[wanted >= 0.5]
    first = np.searchsorted(table_of[:, 0], np.arange(width * height + 1))
    return Glints(first.astype(np.int64), table_of[:, 1:5].copy(), np.round(wanted).astype(np.int64))


@kernel
def mixture(glints, pixels, points, even, out):
    """Weights (m,) f64 of paths through points (m, 2) in the unit squares of pixels (m,), by the balance heuristic.

    even : (m,) f64, how many paths the pixel has evenly over its filter. The sum of emission times weight over all
    paths of a pixel is its estimate.
    """
    for i in range(len(pixels)):
        density = even[i]
        u, v = points[i, 0], points[i, 1]
        for b in range(glints.first[pixels[i]], glints.first[pixels[i] + 1]):
            u0, u1, v0, v1 = glints.box[b, 0], glints.box[b, 1], glints.box[b, 2], glints.box[b, 3]
            if u0 <= u and u < u1 and v0 <= v and v < v1:
                density += glints.count[b] / ((u1 - u0) * (v1 - v0))
        out[i] = 1.0 / density
