"""A world that varies with direction, as a table over the sphere that is sampled by its brightness.

Row j of H covers the polar angles [j, j + 1] pi / H from +z, column i of W the azimuths [i, i + 1] 2 pi / W - pi
from +x. A texel is one radiance over its solid angle; what the eye sees directly is computed exactly instead
(`Sky.radiance_at`). The kernels that read it are in sky_sample.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..issues import IssueLog
from ..scene.data import Image, World
from ..shading.points import sky_points
from ..shading.program import Program, compile_graph

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
WIDTH = 1024  # of a table without images
LEAST_WIDTH, MOST_WIDTH = 512, 4096
AT_ONCE = 1 << 17  # directions evaluated together
FINE = 12  # a texel at the edge of something very bright is averaged over FINE^2 directions
HOT = 8.0  # times the mean of all: bright enough for that
MOST_HOT = 20_000
FLOOR = 0.01  # of the samples is spread evenly, so that no texel is left out by rounding


class SkyMap(NamedTuple):
    """The table; all arrays are empty for a constant world."""

    radiance: np.ndarray  # (H, W, 3) f32 [W/m^2/sr]
    rows: np.ndarray  # (H,) f64, cumulative share of each row
    columns: np.ndarray  # (H, W) f64, cumulative share within the row


class Sky(NamedTuple):
    """A varying world: its table and its program."""

    map: SkyMap
    program: Program

    def radiance_at(self, d: np.ndarray, trail: np.ndarray | None = None) -> np.ndarray:
        """Exact radiance (n, 3) f32 in unit directions d (n, 3).

        trail : (n,) i64 of the paths that look; None: light is sampled
        """
        out = np.empty((len(d), 3), np.float32)
        for first in range(0, len(d), AT_ONCE):
            part = d[first : first + AT_ONCE]
            looking = None if trail is None else trail[first : first + AT_ONCE]
            out[first : first + AT_ONCE] = self.program.emission(sky_points(part, looking))
        return np.maximum(out, 0.0)


def no_map() -> SkyMap:
    """The table of a constant world."""
    return SkyMap(np.zeros((0, 0, 3), np.float32), np.zeros(0), np.zeros((0, 0)))


def build_sky(world: World, images: list[Image], issues: IssueLog) -> Sky | None:
    """The sky of a world whose nodes vary; None: `World.color` says it all."""
    if world.graph is None or world.graph.surface is None:
        return None
    program = compile_graph(world.graph, world.name, images, issues)
    if program.constant:
        return None
    width = table_width(world, images)
    sky = Sky(no_map(), program)
    radiance = tabulate(sky, width // 2, width)
    if not np.isfinite(radiance).all():
        issues.warn(world.name, "its nodes give values that are no numbers in some directions", "these are black")
        radiance = np.where(np.isfinite(radiance), radiance, np.float32(0.0))
    return sky._replace(map=make_map(radiance))


def table_width(world: World, images: list[Image]) -> int:
    """Columns of the table: the widest image's, within limits."""
    used = [node.props.get("image") for node in world.graph.nodes] if world.graph is not None else []
    widths = [images[i].pixels.shape[1] for i in used if isinstance(i, int) and images[i].pixels is not None]
    return 2 * (min(max([LEAST_WIDTH, *widths]) if widths else WIDTH, MOST_WIDTH) // 2)


def directions(row: np.ndarray, column: np.ndarray, shape: tuple[int, int], s: float, t: float) -> np.ndarray:
    """Unit vectors (n, 3) f32 at the place (s, t) in [0, 1]^2 of texels, even in solid angle."""
    height, width = shape
    top, bottom = np.cos(row * math.pi / height), np.cos((row + 1) * math.pi / height)
    z = top + (bottom - top) * s
    phi = (column + t) * 2.0 * math.pi / width - math.pi
    r = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).astype(np.float32)


def texel_means(sky: Sky, row: np.ndarray, column: np.ndarray, shape: tuple[int, int], n: int) -> np.ndarray:
    """Mean radiance (len(row), 3) f32 of texels over n x n directions each."""
    total = np.zeros((len(row), 3))
    for k in range(n * n):
        s, t = (k // n + 0.5) / n, (k % n + 0.5) / n
        total += sky.radiance_at(directions(row, column, shape, s, t))
    return (total / (n * n)).astype(np.float32)


def tabulate(sky: Sky, height: int, width: int) -> np.ndarray:
    """Radiance table (H, W, 3) f32: 2 x 2 directions a texel, more around the sun."""
    shape = (height, width)
    row, column = (grid.ravel() for grid in np.mgrid[:height, :width])
    table = texel_means(sky, row, column, shape, 2).reshape(height, width, 3)
    bright = table @ LUMINANCE
    around = np.pad(bright, ((1, 1), (0, 0)), mode="edge")
    around = np.concatenate([around[:, -1:], around, around[:, :1]], axis=1)
    views = [around[j : j + height, i : i + width] for j in range(3) for i in range(3)]
    high, low = np.max(views, axis=0), np.min(views, axis=0)
    hot = np.flatnonzero((high > HOT * bright.mean()) & (high > 2.0 * low))
    if 0 < len(hot) <= MOST_HOT:
        table.reshape(-1, 3)[hot] = texel_means(sky, row[hot], column[hot], shape, FINE)
    return table


def make_map(radiance: np.ndarray) -> SkyMap:
    """The table with its sampling distribution: luminance times solid angle, FLOOR of it even."""
    height = len(radiance)
    angle = -np.diff(np.cos(np.arange(height + 1) * math.pi / height))
    weight = np.maximum(radiance @ LUMINANCE, 0.0)
    mean = (weight.mean(axis=1) * angle).sum() / 2.0
    weight = (1.0 - FLOOR) * weight + FLOOR * (mean if mean > 0.0 else 1.0)
    columns = np.cumsum(weight, axis=1)
    rows = np.cumsum(columns[:, -1] * angle)
    columns /= columns[:, -1:]
    columns[:, -1] = 1.0
    rows /= rows[-1]
    rows[-1] = 1.0
    return SkyMap(np.ascontiguousarray(radiance, np.float32), rows, columns)


def mean_radiance(sky: SkyMap) -> np.ndarray:
    """Mean (3,) over the sphere [W/m^2/sr]."""
    height = len(sky.rows)
    angle = -np.diff(np.cos(np.arange(height + 1) * math.pi / height))
    return (sky.radiance.mean(axis=1, dtype=np.float64) * angle[:, None]).sum(axis=0) / 2.0
