"""Eye paths in flight, the visible points where they end, and the picture that they add to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..shading.trail import no_trails
from .media import no_bits

# random numbers of direct light and gathering come after those of the eye path's first 255 bounces,
DIRECT_DIMENSION = 4096
SECOND_DIMENSION = 8192  # those of rays from the lobes, which bounce too, after these,
LATE_DIMENSION = 1 << 16  # and those of the eye path's later bounces after all others
FILTER, LENS, CHOICE, LIGHT, LOBE = range(5)  # sets of numbers that are spread evenly over pixels
LATTICE_X, LATTICE_Y = 0.7548776662466927, 0.5698402909980532  # 1 / g, 1 / g^2 with g^3 = g + 1 [Roberts 2018, R2]


class EyePaths(NamedTuple):
    """Eye paths in flight."""

    o: np.ndarray  # (n, 3) f32, origin of the next ray [m]
    d: np.ndarray  # (n, 3) f32, unit
    beta: np.ndarray  # (n, 3) f32, throughput
    key: np.ndarray  # (n,) u64, random numbers
    place: np.ndarray  # (n,) i64, the pixel's in Morton's order; -1: a way besides the pixel's main path
    pixel: np.ndarray  # (n,) i32, index into the tile
    width: np.ndarray  # (n,) f32, radius of half a pixel's footprint at o [m]
    spread: np.ndarray  # (n,) f32, its growth per metre
    t_max: np.ndarray  # (n,) f32, far clipping along the ray until something bends it [m]
    bare: np.ndarray  # (n,) bool, only straight passes so far
    splits: np.ndarray  # (n,) u8, at how many more forks the path goes every way
    unguided: np.ndarray  # (n,) bool, nothing rough met yet: what is seen next guides the denoiser
    inside: np.ndarray  # (n,) i64, bits of the absorbing media it is in; (0,) in a scene without
    trail: np.ndarray  # (n,) i64, what shading/trail.py keeps; (0,) where no material asks
    sky: np.ndarray  # (n, 3) f32, exact radiance of a varying world where this leg escapes; (0, 3): the lights tell it


class VisiblePoints(NamedTuple):
    """Where eye paths end at a rough lobe."""

    hit: np.ndarray  # (m,) i32, index of the hit in the batch of surfaces
    wo: np.ndarray  # (m, 3) f32
    beta: np.ndarray  # (m, 3) f32, throughput over the probability of ending here
    key: np.ndarray  # (m,) u64
    u: np.ndarray  # (m, 6) f64, numbers in [0, 1): which light, where on it (2), which lobe, where in it (2)
    pixel: np.ndarray  # (m,) i32
    footprint: np.ndarray  # (m,) f32, radius of a pixel on the surface [m]
    inside: np.ndarray  # (m,) i64, as in EyePaths, on the side that is seen
    trail: np.ndarray  # (m,) i64, as in EyePaths


class Tile(NamedTuple):
    """The picture of a run of pixels; float32 (n, channels)."""

    direct: np.ndarray
    caustic: np.ndarray
    diffuse: np.ndarray
    emission: np.ndarray
    environment: np.ndarray
    alpha: np.ndarray
    depth: np.ndarray
    normal: np.ndarray
    albedo: np.ndarray
    caustic_bias: np.ndarray  # see gather_kernels.gather
    diffuse_bias: np.ndarray
    guide_albedo: np.ndarray  # of the first rough surface, also through glass and in mirrors; (0, 3): no denoiser
    guide_normal: np.ndarray


class EyeRules(NamedTuple):
    """What the camera sees of the world behind things."""

    transparent: bool  # the world is not drawn where nothing else is
    visible: np.ndarray  # (instances,) bool, seen by camera rays
    holdout: np.ndarray  # (instances,) bool, a hole in the picture where the camera sees it straight
    forward: np.ndarray  # (3,) f64, view axis
    eye: np.ndarray  # (3,) f64, the camera's position, recentred [m]
    key: np.uint64 = np.uint64(0)  # of the pass


def empty_paths(n: int, media: bool = False, trails: bool = False) -> EyePaths:
    """Room for n eye paths from the camera; media: where something absorbs; trails: where a material asks."""
    f3 = [np.empty((n, 3), np.float32) for _ in range(3)]
    f1 = [np.empty(n, np.float32) for _ in range(3)]
    key, place, pixel = np.empty(n, np.uint64), np.empty(n, np.int64), np.empty(n, np.int32)
    flags = (np.empty(n, bool), np.empty(n, np.uint8), np.empty(n, bool))
    return EyePaths(*f3, key, place, pixel, *f1, *flags, no_bits(n, media), no_trails(n, trails), no_sky())


def no_sky() -> np.ndarray:
    """No exact radiance of the world."""
    return np.zeros((0, 3), np.float32)


def empty_tile(n: int, guides: bool) -> Tile:
    """A black tile of n pixels; guides: whether it has those of the denoiser."""
    rgb = [np.zeros((n, 3), np.float32) for _ in range(5)]
    return Tile(
        *rgb,
        np.ones((n, 1), np.float32),
        np.zeros((n, 1), np.float32),
        *(np.zeros((n, 3), np.float32) for _ in range(4)),
        *(np.zeros((n if guides else 0, 3), np.float32) for _ in range(2)),
    )


def empty_points(n: int, media: bool = False, trails: bool = False) -> VisiblePoints:
    """Room for n visible points; media: where something absorbs; trails: where a material asks."""
    return VisiblePoints(
        np.empty(n, np.int32),
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.uint64),
        np.empty((n, 6)),
        np.empty(n, np.int32),
        np.empty(n, np.float32),
        no_bits(n, media),
        no_trails(n, trails),
    )
