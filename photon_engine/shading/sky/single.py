"""A sky by single scattering in air, aerosols and ozone [Nishita et al. 1993], 21 wavelengths, as Blender's."""

from __future__ import annotations

import math

import numpy as np

from .tables import tables

AIR_SCALE, AEROSOL_SCALE = 8e3, 1.2e3  # heights over which densities fall by e [m]
AEROSOL = 2e-5  # scattering coefficient [1/m]; absorption adds 11%
G = 0.76  # anisotropy of aerosols
EARTH, TOP = 6360e3, 6420e3  # radii [m]
STEPS = 32
STEP_NM = 20.0
HIGHEST = 59999.0
# Gauss-Laguerre quadrature of order 8, its last node within the atmosphere: places, and weights times e^x
NODES, WEIGHTS = np.polynomial.laguerre.laggauss(8)
PLACES, SHARES = NODES / 25.0, WEIGHTS * np.exp(NODES) / 25.0


def densities(height):
    """Relative densities (..., 3) of air, aerosols and ozone."""
    ozone = np.maximum(0.0, 1.0 - np.abs(height - 25000.0) / 15000.0)
    return np.stack([np.exp(-height / AIR_SCALE), np.exp(-height / AEROSOL_SCALE), ozone], axis=-1)


def leaving(p, d):
    """Distance (n,) at which rays leave the atmosphere, from inside."""
    b = np.einsum("ij,ij->i", p, np.broadcast_to(d, p.shape))
    return -b + np.sqrt(b * b - (np.einsum("ij,ij->i", p, p) - TOP * TOP))


def hits_earth(p, d):
    """Whether rays meet the ground."""
    b = np.einsum("ij,ij->i", p, np.broadcast_to(d, p.shape))
    return (np.broadcast_to(d, p.shape)[:, 2] < 0.0) & (b * b - (np.einsum("ij,ij->i", p, p) - EARTH * EARTH) >= 0.0)


def optical_depth(p, d):
    """Densities integrated to the end of the atmosphere, (n, 3) [m]."""
    size = leaving(p, d)
    total = np.zeros((len(p), 3))
    for place, share in zip(PLACES, SHARES, strict=True):
        q = p + (place * size)[:, None] * d
        total += share * densities(np.linalg.norm(q, axis=1) - EARTH)
    return total * size[:, None]


def extinction():
    """Coefficients (3, 21) of air, aerosols and ozone [1/m]."""
    data = tables()
    return np.stack([data["rayleigh"], np.full(len(data["rayleigh"]), 1.11 * AEROSOL), data["ozone"]])


def radiance(d, sun, altitude, amounts):
    """XYZ (n, 3) of the sky in directions d (n, 3); sun (3,);  amounts (3,): factors of the densities."""
    data = tables()
    p = np.tile([0.0, 0.0, EARTH + altitude], (len(d), 1))
    length = leaving(p, d) / STEPS
    mu = d @ sun
    air = 3.0 / (16.0 * math.pi) * (1.0 + mu * mu)
    aerosol = 3.0 * (1.0 - G * G) * (1.0 + mu * mu) / (8.0 * math.pi * (2.0 + G * G))
    aerosol /= (1.0 + G * G - 2.0 * G * mu) ** 1.5
    depth, spectrum, coefficients = np.zeros((len(d), 3)), np.zeros((len(d), 21)), extinction()
    p += 0.5 * length[:, None] * d
    for _ in range(STEPS):
        density = amounts * densities(np.linalg.norm(p, axis=1) - EARTH)
        depth += length[:, None] * density
        lit = np.flatnonzero(~hits_earth(p, sun))
        total = depth[lit] + amounts * optical_depth(p[lit], sun)
        scattered = (air[lit] * density[lit, 0])[:, None] * data["rayleigh"]
        scattered += (aerosol[lit] * density[lit, 1] * AEROSOL)[:, None]
        spectrum[lit] += np.exp(-(total @ coefficients)) * scattered * length[lit, None]
        p += length[:, None] * d
    return (spectrum * data["irradiance"]) @ data["xyz"] * STEP_NM


def direction(latitude, longitude):
    """Unit vectors (n, 3)."""
    c = np.cos(latitude)
    return np.stack([c * np.cos(longitude), c * np.sin(longitude), np.sin(latitude) + 0.0 * longitude], axis=-1)


def half_sky(latitudes, width, elevation, altitude, amounts):
    """XYZ (rows, width, 3) at latitudes (rows,), mirrored about the sun's meridian."""
    longitudes = 2.0 * math.pi / width * np.arange(width // 2) - math.pi
    lat, lon = np.meshgrid(latitudes, longitudes, indexing="ij")
    sun = direction(np.array(elevation), np.array(0.0))
    sky = radiance(direction(lat.ravel(), lon.ravel()), sun, altitude, amounts).reshape(*lat.shape, 3)
    return np.concatenate([sky, sky[:, ::-1]], axis=1)


def picture(elevation, altitude, amounts, size):
    """XYZ (H, W, 3), bottom row first: the whole sky, its lower half the fading horizon; size: (W, H)."""
    width, height = size
    half = height // 2
    altitude = min(max(altitude, 1.0), HIGHEST)
    upper = half_sky(0.5 * math.pi * (np.arange(half, height) / half - 1.0) ** 2, width, elevation, altitude, amounts)
    z = np.sin(0.5 * math.pi * (np.arange(half) / half - 1.0) ** 2)
    fade = np.where(z < 0.4, 1.0 - 2.5 * z, 0.0) ** 3
    return np.concatenate([upper[:1] * fade[:, None, None], upper])


def old_picture(elevation, altitude, amounts, size):
    """XYZ (H, W, 3) of the upper half of the sky alone, as Blender 4.5 has it."""
    width, height = size
    rows = (0.5 * math.pi + 0.25 * math.pi / height) * (np.arange(height) / height) ** 2
    return half_sky(rows, width, elevation, altitude, amounts)


def sun_ends(elevation, diameter, altitude, amounts):
    """XYZ (2, 3) of the lowest and the highest point of the sun's disc; black below the horizon."""
    altitude = min(max(altitude, 1.0), HIGHEST)
    solid_angle = 2.0 * math.pi * (1.0 - math.cos(0.5 * diameter))
    if elevation + 0.5 * diameter <= 0.0:
        return np.zeros((2, 3))
    data = tables()
    ends = np.maximum([elevation - 0.5 * diameter, elevation + 0.5 * diameter], 0.0)
    d = direction(ends, np.zeros(2))
    depth = optical_depth(np.tile([0.0, 0.0, EARTH + altitude], (2, 1)), d) * amounts
    spectrum = data["irradiance"] * np.exp(-(depth[:, :2] @ extinction()[:2])) / solid_angle
    return spectrum @ data["xyz"] * STEP_NM
