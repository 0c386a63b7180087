"""Lamps that do not shine alike all ways: what their nodes multiply the strength with, by direction."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..jit import kernel
from ..vec import load3


class Beams(NamedTuple):
    """Maps of B lamps; empty in most scenes."""

    of_light: np.ndarray  # (L,) i32, index of a light's map, or -1
    frame: np.ndarray  # (B, 3, 3) f64, rows: the lamp's axes in the world
    map: np.ndarray  # (B, H, W, 3) f32 in [0, 1]; rows from local +Z to -Z, columns round from local +X


def local_directions(height: int, width: int) -> np.ndarray:
    """Unit directions (height, width, 3) f64, local to a lamp, of a map's points."""
    theta = np.linspace(0.0, math.pi, height)[:, None]
    phi = np.arange(width) / width * 2.0 * math.pi
    sine = np.sin(theta)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta) + 0.0 * phi], axis=-1)


def axes_of(matrix: np.ndarray) -> np.ndarray:
    """A lamp's axes as rows (3, 3) f64: the columns of its matrix (4, 4), of length 1."""
    linear = np.asarray(matrix, np.float64)[:3, :3]
    return (linear / np.maximum(np.linalg.norm(linear, axis=0), 1e-30)).T


def pack_beams(maps: list[np.ndarray | None], frames: list[np.ndarray]) -> Beams:
    """The maps of all lights, None where one shines alike all ways; maps have one shape."""
    held = [i for i, item in enumerate(maps) if item is not None]
    of_light = np.full(len(maps), -1, np.int32)
    of_light[held] = np.arange(len(held))
    if not held:
        return Beams(of_light, np.zeros((0, 3, 3)), np.zeros((0, 2, 2, 3), np.float32))
    stack = np.array([maps[i] for i in held], np.float32)
    return Beams(of_light, np.array([frames[i] for i in held], np.float64), stack)


def mean_share(beam: np.ndarray, kind: str) -> float:
    """About what share a map (H, W, 3) leaves of a lamp's flux: mean over where it shines; at least 1e-3."""
    theta = np.linspace(0.0, math.pi, len(beam))
    weight = np.sin(theta) * ((theta >= 0.5 * math.pi) | (kind == "POINT"))
    if kind == "SUN":
        weight = (theta == theta[-1]).astype(float)
    return max(float((beam.mean(axis=(1, 2)) * weight).sum() / weight.sum()), 1e-3)


@kernel
def beam_value(beams, b, d):
    """Map b (rgb) along the unit direction d in which light travels; bilinear."""
    f = beams.frame
    x = f[b, 0, 0] * d[0] + f[b, 0, 1] * d[1] + f[b, 0, 2] * d[2]
    y = f[b, 1, 0] * d[0] + f[b, 1, 1] * d[1] + f[b, 1, 2] * d[2]
    z = f[b, 2, 0] * d[0] + f[b, 2, 1] * d[1] + f[b, 2, 2] * d[2]
    height, width = beams.map.shape[1], beams.map.shape[2]
    v = math.atan2(math.sqrt(x * x + y * y), z) / math.pi * (height - 1)
    u = math.atan2(y, x) / (2.0 * math.pi)
    u = (u - math.floor(u)) * width
    i = min(int(v), height - 2)
    j = min(int(u), width - 1)
    k = j + 1 if j + 1 < width else 0
    t, s = v - i, u - j
    a, b0 = (1.0 - t) * (1.0 - s), (1.0 - t) * s
    c, e = t * (1.0 - s), t * s
    m = beams.map
    return (
        a * m[b, i, j, 0] + b0 * m[b, i, k, 0] + c * m[b, i + 1, j, 0] + e * m[b, i + 1, k, 0],
        a * m[b, i, j, 1] + b0 * m[b, i, k, 1] + c * m[b, i + 1, j, 1] + e * m[b, i + 1, k, 1],
        a * m[b, i, j, 2] + b0 * m[b, i, k, 2] + c * m[b, i + 1, j, 2] + e * m[b, i + 1, k, 2],
    )


@kernel
def radiance_along(lights, l, d):
    """`lights.radiance` of light l (rgb) as it shines along d: times its map."""
    r, g, b = load3(lights.radiance, l)
    beams = lights.beams
    if len(beams.map) == 0 or beams.of_light[l] < 0:
        return (r, g, b)
    share = beam_value(beams, beams.of_light[l], d)
    return (r * share[0], g * share[1], b * share[2])
