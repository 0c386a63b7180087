"""Skies by formula [Preetham, Shirley and Smits 1999; Hosek and Wilkie 2012]: XYZ by zenith angle and sun angle."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .tables import tables

HORIZON = 0.5 * math.pi - 0.001
HOSEK_SCALE = 2.0 * math.pi / 683.0


class Sun(NamedTuple):
    """Where the sun is: angles from the zenith and about it [rad]."""

    theta: float
    phi: float


def sun_of(direction: tuple[float, float, float]) -> Sun:
    """The sun's angles from the direction to it."""
    x, y, z = np.asarray(direction, float) / max(float(np.linalg.norm(direction)), 1e-12)
    return Sun(math.acos(min(max(z, -1.0), 1.0)), math.atan2(x, y))


def angles(d: np.ndarray, sun: Sun) -> tuple[np.ndarray, np.ndarray]:
    """Zenith angle, kept above the horizon, and angle to the sun, of directions d (3, n), as Blender measures them."""
    theta, phi = np.arccos(np.clip(d[2], -1.0, 1.0)), 0.5 * math.pi - np.arctan2(d[1], d[0])
    cosine = np.sin(theta) * math.sin(sun.theta) * np.cos(sun.phi - phi) + np.cos(theta) * math.cos(sun.theta)
    return np.minimum(theta, HORIZON), np.arccos(np.clip(cosine, -1.0, 1.0))


def perez(shape, theta, gamma):
    """Perez' sky distribution (1 + a e^(b / cos theta)) (1 + c e^(d gamma) + e cos^2 gamma)."""
    a, b, c, d, e = shape
    return (1.0 + a * np.exp(b / np.cos(theta))) * (1.0 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)


def preetham_shapes(t: float) -> list[list[float]]:
    """Perez' coefficients of Y, x and y at turbidity t."""
    return [
        [0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703],
        [-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452],
        [-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529],
    ]


def preetham_zenith(t: float, theta: float) -> list[float]:
    """Y, x and y at the zenith."""
    s = np.array([theta**3, theta**2, theta, 1.0])
    powers = np.array([t * t, t, 1.0])
    chi = (4.0 / 9.0 - t / 120.0) * (math.pi - 2.0 * theta)
    brightness = 0.06 * ((4.0453 * t - 4.9710) * math.tan(chi) - 0.2155 * t + 2.4192)
    x = [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394],
         [0.11693, -0.21196, 0.06052, 0.25886]]  # fmt: skip
    y = [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516],
         [0.15346, -0.26756, 0.06670, 0.26688]]  # fmt: skip
    return [brightness, float(powers @ np.array(x) @ s), float(powers @ np.array(y) @ s)]


def preetham(d: np.ndarray, direction: tuple[float, float, float], turbidity: float) -> np.ndarray:
    """XYZ (3, n) of the sky in directions d."""
    sun = sun_of(direction)
    theta, gamma = angles(d, sun)
    values = []
    for zenith, shape in zip(preetham_zenith(turbidity, sun.theta), preetham_shapes(turbidity), strict=True):
        values.append(zenith * perez(shape, theta, gamma) / perez(shape, 0.0, sun.theta))
    big_y, x, y = values
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(y != 0.0, big_y / y, 0.0)
    return np.stack([x * ratio, big_y, (1.0 - x - y) * ratio])


@lru_cache(maxsize=16)
def hosek_parameters(turbidity: float, albedo: float, elevation: float) -> tuple[np.ndarray, np.ndarray]:
    """Shapes (3, 9) and radiances (3,) of XYZ, interpolated in turbidity, albedo and elevation."""
    s = max(elevation / (0.5 * math.pi), 0.0) ** (1.0 / 3.0)
    knots = np.array([math.comb(5, k) * (1.0 - s) ** (5 - k) * s**k for k in range(6)])
    low = min(max(int(turbidity), 1), 10)
    rest = turbidity - int(turbidity)
    shape, radiance = np.zeros((3, 9)), np.zeros(3)
    data = tables()
    for share, t in ((1.0 - rest, low), (rest, low + 1)):
        if t > 10 or share == 0.0:
            continue
        for k, weight in enumerate((1.0 - albedo, albedo)):
            shape += share * weight * np.einsum("k,ckj->cj", knots, data["hosek_shape"][:, k, t - 1])
            radiance += share * weight * data["hosek_radiance"][:, k, t - 1] @ knots
    return shape, radiance


def hosek(d: np.ndarray, direction: tuple[float, float, float], turbidity: float, albedo: float) -> np.ndarray:
    """XYZ (3, n) of the sky in directions d."""
    sun = sun_of(direction)
    sun = Sun(min(max(sun.theta, 0.0), 0.5 * math.pi), sun.phi)
    theta, gamma = angles(d, sun)
    shapes, radiances = hosek_parameters(min(max(turbidity, 0.0), 10.0), albedo, 0.5 * math.pi - sun.theta)
    c, cg = np.cos(theta), np.cos(gamma)
    out = []
    for (a, b, k0, k1, k2, k3, k4, k5, g), radiance in zip(shapes, radiances, strict=True):
        mie = (1.0 + cg * cg) / (1.0 + g * g - 2.0 * g * cg) ** 1.5
        glow = k0 + k1 * np.exp(k2 * gamma) + k3 * cg * cg + k4 * mie + k5 * np.sqrt(c)
        out.append(radiance * (1.0 + a * np.exp(b / (c + 0.01))) * glow)
    return np.stack(out) * HOSEK_SCALE
