"""SUBSURFACE lobes of Blender's nodes: how far light goes below the surface, for each law of Blender's menus.

Random walks by Chiang and Burley 2016. Blender's free paths are the radius itself, or scaled to what older versions
showed. Christensen's and Burley's profile (BURLEY) is replaced by the older random walk, which Blender scales alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import layout as lay
from .layout import Lobe
from .recipes import color, column, diffuse, factor, make

LAWS = {
    "RANDOM_WALK": lay.WALK, "RANDOM_WALK_LEGACY": lay.WALK_LEGACY, "RANDOM_WALK_SKIN": lay.WALK_SKIN,
    "BURLEY": lay.WALK_LEGACY,
}  # fmt: skip
OLD_SCALE = 0.25 / np.pi  # free path of the older random walk over the radius
SMALLEST = 1e-8  # [m] a channel of a smaller radius is diffuse
MOST_AHEAD = {lay.WALK: 0.99, lay.WALK_LEGACY: 0.9, lay.WALK_SKIN: 0.9}  # of the mean cosine
BISECTIONS = 12  # Blender's, hence as coarse


class Flesh(NamedTuple):
    """Inputs of a subsurface lobe, each one value or one for each hit, as in `recipes`."""

    radius: object  # [m], rgb
    ior: object = 1.4
    width: object = 1.0  # GGX width of the surface where light is let in
    anisotropy: object = 0.0
    method: str = "RANDOM_WALK"


def subsurface(base, flesh: Flesh, normal=None, weight=1.0) -> list[Lobe]:
    """A random walk of albedo `base`; channels whose radius is hardly anything are Lambert."""
    albedo, weight = color(base), factor(weight)
    radius = color(flesh.radius)
    law = LAWS.get(flesh.method, lay.WALK)
    deep = radius >= SMALLEST
    shallow = diffuse(albedo * ~deep, 0.0, normal, weight)
    if not deep.any():
        return shallow
    ior = np.clip(column(flesh.ior), 1.01, 3.8)
    path = free_path(radius, albedo, ior, law)
    below = make(
        lay.SUBSURFACE, albedo * deep * weight, normal, color_a=albedo, color_b=np.where(deep, path, 0.0),
        anisotropy=np.clip(column(flesh.anisotropy), -0.99, MOST_AHEAD[law]), ior=ior,
        roughness=np.clip(column(flesh.width), 0.0, 1.0), fresnel=column(law),
    )  # fmt: skip
    return below + shallow


def free_path(radius: np.ndarray, albedo: np.ndarray, ior: np.ndarray, law: int) -> np.ndarray:
    """The free path [m] that a law makes of the radius (n | 1, 3)."""
    if law == lay.WALK:
        return radius
    if law == lay.WALK_LEGACY:
        return radius * OLD_SCALE
    # the radius is that of a dipole's falloff [Jensen et al. 2001]
    x = 1.0 / ior
    inside = x * (-1.44 * x + 0.71) + 0.668 + 0.0636 * ior
    boundary = 4.0 / 3.0 * (1.0 + inside) / (1.0 - inside)
    return radius * np.sqrt(3.0 * (1.0 - reduced_albedo(albedo, boundary[:, None])))


def reduced_albedo(diffuse_albedo: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """The reduced scattering albedo of a dipole with this diffuse reflectance; boundary: 4/3 A."""
    wanted, boundary = np.broadcast_arrays(diffuse_albedo, boundary)
    low, high = np.zeros(wanted.shape), np.ones(wanted.shape)
    middle = low
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        s = np.sqrt(3.0 * (1.0 - middle))
        less = 0.5 * middle * (1.0 + np.exp(-boundary * s)) * np.exp(-s) < wanted
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return np.where(wanted < 1e-4, 0.0, np.where(wanted >= 0.995, 0.999999, middle))
