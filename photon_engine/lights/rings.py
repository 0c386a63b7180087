"""Disks within disks through which suns and the sky send their photons: dense where the camera looks, some everywhere.

Over a ground of a kilometre, photons spread evenly over the scene leave one in a million for what stands in front of
the camera. The disks are those of spheres around what is seen, each up to STEP times wider than the one within, the
last round the whole scene; photons go to all in equal numbers and are weighted by the mixture's density, as aimed ones
are (targets.py) [Veach and Guibas 1995; Jensen 1996]. So no photon weighs more than the number of disks times what it
did, and light that comes from afar is there too. Other lamps, which have their own places, send theirs as ever, but
how many each gets follows from what it brings to the disks.
"""

from __future__ import annotations

import math

import numpy as np

from .table import LUMINANCE, MESH, SUN, WORLD, LightTable, make_cdf
from .targets import Targets, shares

STEP = 4.0  # times wider is each sphere, at most
WORTH = 16.0  # times wider must the scene be than what is seen; below, a final gather is noisier for it
FEWEST = 16  # visible points that tell where the camera looks


def no_rings(lights: LightTable) -> Targets:
    """Photons are spread evenly over the scene."""
    n = len(lights.kind)
    return Targets(np.zeros((0, 3)), np.zeros(0), np.zeros((n, 0)), np.zeros((n, 0)), np.zeros(n))


def build_rings(lights: LightTable, seen: np.ndarray) -> Targets:
    """Disks for visible points (n, 3); none where the camera sees much of the scene, or there is no sun nor sky."""
    distant = np.isin(lights.kind, (SUN, WORLD))
    if not distant.any() or len(seen) < FEWEST:
        return no_rings(lights)
    middle = np.median(seen.astype(np.float64), axis=0)
    near = float(np.median(np.linalg.norm(seen - middle, axis=1)))
    if not 0.0 < near * WORTH <= lights.radius:
        return no_rings(lights)
    count = math.ceil(math.log(lights.radius / near) / math.log(STEP))
    inner = near * (lights.radius / near) ** (np.arange(count) / count)
    center = np.concatenate([np.tile(middle, (count, 1)), lights.center[None]])
    radius = np.append(inner, lights.radius)
    brought = irradiances(lights, middle, radius)
    even = np.tile(np.arange(1.0, count + 2.0) / (count + 1), (len(distant), 1))
    return Targets(center, radius, even, brought, make_cdf(shares(brought.sum(axis=1))))


def irradiances(lights: LightTable, middle: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """What each light brings to each disk, roughly (L, C) [W/m^2]: a lamp inside all its flux, one outside a part."""
    flux = lights.flux @ LUMINANCE
    distant = np.isin(lights.kind, (SUN, WORLD))[:, None]
    away = np.linalg.norm(lights.position - middle, axis=1)
    away = np.where(lights.kind == MESH, 0.0, away)[:, None]  # wherever: it is many lamps
    spread = np.where(distant, lights.radius, np.maximum(radius, 2.0 * away))
    return flux[:, None] / (math.pi * spread**2)
