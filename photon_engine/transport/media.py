"""Absorbing media inside closed surfaces: which ones a ray is in, and what they take [Beer-Lambert].

A path remembers its media as the bits of a number. Crossing a surface with an absorbing inside sets or clears its
bit, so that media overlap as in Cycles: their coefficients add up, and order does not matter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.flatten import Flattened
from ..geometry.intersect import Intersector
from ..issues import IssueLog
from ..jit import inlined, kernel
from ..lights.table import AREA, POINT, SPOT, LightTable
from ..scene.data import SceneData

MOST = 62  # bits of an integer that stays positive
PROBE = np.array([[0.36, 0.48, 0.8]], np.float32)  # unit; any direction tells what a point is inside of
PROBE_HITS = 256


class Media(NamedTuple):
    """M absorbing media; all arrays are empty when there is none."""

    sigma: np.ndarray  # (M, 3) f64, absorption coefficient [1/m]
    of_prim: np.ndarray  # (T,) i8, medium behind each triangle; -1: none
    at_light: np.ndarray  # (L,) i64, bits of the media that a lamp's position lies in


def no_media() -> Media:
    """Empty space everywhere."""
    return Media(np.zeros((0, 3)), np.zeros(0, np.int8), np.zeros(0, np.int64))


def find_media(scene: SceneData, flat: Flattened, sigma_of_material: list, issues: IssueLog) -> Media:
    """The media of a scene: one for each instance and absorbing material, at most MOST.

    sigma_of_material : for each material (3,) [1/m] or None;  `at_light` is filled in by `locate_lights`.
    """
    geometry = flat.geometry
    absorbing = np.array([s is not None and bool(np.any(s)) for s in sigma_of_material] + [False], bool)
    touched = np.flatnonzero(absorbing[geometry.material]) if len(geometry.material) else np.zeros(0, np.int64)
    if len(touched) == 0:
        return no_media()
    pair = geometry.instance[touched].astype(np.int64) * len(absorbing) + geometry.material[touched]
    pairs, which = np.unique(pair, return_inverse=True)
    if len(pairs) > MOST:  # copies of one material then share a medium, which differs only where they overlap
        pairs, which = np.unique(pair % len(absorbing), return_inverse=True)
    if len(pairs) > MOST:
        issues.warn(scene.name, f"only the first {MOST} of {len(pairs)} absorbing materials absorb", "use fewer")
        pairs = pairs[:MOST]
    of_prim = np.full(len(geometry.material), -1, np.int8)
    of_prim[touched] = np.where(which < MOST, which, -1)
    sigma = np.array([sigma_of_material[p % len(absorbing)] for p in pairs], np.float64)
    return Media(sigma, of_prim, np.zeros(0, np.int64))


def inside_at(media: Media, flat: Flattened, intersector: Intersector, p: np.ndarray) -> int:
    """Bits of the media around a recentred point (3,): surfaces that a ray from there leaves and did not enter."""
    if len(media.sigma) == 0:
        return 0
    geometry, o = flat.geometry, p.astype(np.float64)
    found, entered = 0, 0
    for _ in range(PROBE_HITS):
        hit = intersector.closest(np.ascontiguousarray(o[None], np.float32), PROBE)
        prim = int(hit.prim[0])
        if prim < 0:
            break
        bit = 1 << int(media.of_prim[prim]) if media.of_prim[prim] >= 0 else 0
        a, b, c = geometry.positions[geometry.triangles[prim]].astype(np.float64)
        if np.cross(b - a, c - a) @ PROBE[0] < 0.0:
            entered |= bit
        elif not entered & bit:
            found |= bit
        else:
            entered &= ~bit
        o = o + PROBE[0] * (float(hit.t[0]) + 4e-6 * (flat.radius + float(hit.t[0])))
    return found


def locate_lights(media: Media, flat: Flattened, intersector: Intersector, lights: LightTable) -> Media:
    """The media with `at_light`: lamps inside glass shine from there. Suns, sky and glowing meshes start outside."""
    if len(media.sigma) == 0:
        return media
    at = [
        inside_at(media, flat, intersector, lights.position[l]) if kind in (POINT, SPOT, AREA) else 0
        for l, kind in enumerate(lights.kind)
    ]
    return media._replace(at_light=np.array(at, np.int64))


def no_bits(n: int, media: bool) -> np.ndarray:
    """Room for the media of n paths, in empty space; none where nothing absorbs."""
    return np.zeros(n if media else 0, np.int64)


@inlined
def after_surface(media, inside, prim, cos_from, cos_to):
    """Bits of a path's media after triangle prim, from and to the sides with these cosines to its normal."""
    m = media.of_prim[prim]
    if m < 0 or (cos_from >= 0.0) == (cos_to >= 0.0):
        return inside
    bit = np.int64(1) << np.int64(m)
    return inside | bit if cos_to < 0.0 else inside & ~bit


@kernel
def absorb(media, inside, distance, colors, lost):
    """Multiply colours (n, 3) by exp(-sigma distance) of the media that each path is in; lost (3,): their sum.

    An infinite distance leaves nothing where sigma > 0.
    """
    for i in range(len(inside)):
        if inside[i] == 0:
            continue
        for c in range(3):
            sigma = 0.0
            for m in range(media.sigma.shape[0]):
                if (inside[i] >> m) & 1:
                    sigma += media.sigma[m, c]
            if sigma > 0.0:
                kept = colors[i, c] * math.exp(-sigma * distance[i])
                lost[c] += colors[i, c] - kept
                colors[i, c] = kept
