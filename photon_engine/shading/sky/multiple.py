"""A sky by multiple scattering at four wavelengths [Garlin 2024, Spectral sky], as Blender's."""

from __future__ import annotations

import math

import numpy as np

ALBEDO = 0.3  # of the ground
G = 0.8  # anisotropy of aerosols
EARTH, THICKNESS = 6371.0, 100.0  # [km]
TOP = EARTH + THICKNESS
STEPS = 64
LUT = (256, 64)  # cosines, altitudes
HIGHEST = 99999.0  # [m]
# at 630, 560, 490 and 430 nm, over a town
IRRADIANCE = np.array([1.679, 1.828, 1.986, 1.307])
AIR = np.array([6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2])  # scattering at the ground [1/km]
OZONE = 334.5 * np.array([3.472e-25, 3.914e-25, 1.349e-25, 11.03e-27])  # mean column times cross sections
AEROSOL_ABSORPTION = np.array([2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23])
AEROSOL_SCATTERING = np.array([1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22])
AEROSOL_DENSITY, BACKGROUND, AEROSOL_HEIGHT = 1.3681e20, 2e6, 0.73
TO_XYZ = np.array([
    [53.386917738564668, 22.981337506691025, 0.0],
    [43.904844466369358, 71.347795700053394, 0.10250686796574131],
    [1.6137278251608962, 18.422960591455485, 31.742921188390806],
    [20.762668673810577, 2.3614213523314368, 110.48009643252140],
])


def coefficients(h, amounts):
    """Scattering by air, scattering by aerosols and extinction, (n, 4) each [1/km], at heights h (n,) [km]."""
    air = np.exp(-0.07771971 * h**1.16364243)[:, None] * AIR * amounts[0]
    aerosol = AEROSOL_DENSITY * (np.exp(-h / AEROSOL_HEIGHT) + BACKGROUND / AEROSOL_DENSITY) * amounts[1]
    log = np.log(np.maximum(h, 1e-4))
    ozone = (3.78547397e20 * np.exp(-((log - 3.22261) ** 2) * 5.55555555 - log))[:, None] * OZONE * amounts[2]
    scattered = aerosol[:, None] * AEROSOL_SCATTERING
    return air, scattered, air + scattered + aerosol[:, None] * AEROSOL_ABSORPTION + ozone


def leaving(r, mu, radius):
    """Distance (n,) to a sphere about the Earth's centre; r: distance from it, mu: cosine to the zenith; < 0: none."""
    b, c = r * mu, r * r - radius * radius
    root = b * b - c
    t = np.sqrt(np.maximum(root, 0.0))
    near, far = -b - t, -b + t
    return np.where(root < 0.0, -1.0, np.where((c > 0.0) & (b > 0.0), -1.0, np.where(near < 0.0, far, near)))


def transmittance(mu, height, amounts):
    """Transmittance (n, 4) from relative heights (n,) to the end of the atmosphere at cosines mu (n,)."""
    r = EARTH + THICKNESS * height
    step = leaving(r, mu, TOP) / STEPS
    total = np.zeros((len(mu), 4))
    for i in range(STEPS):
        t = (i + 0.5) * step
        h = np.maximum(np.sqrt(r * r + t * t + 2.0 * r * t * mu) - EARTH, 0.0)
        total += coefficients(h, amounts)[2] * step[:, None]
    return np.exp(-total)


class Atmosphere:
    """Transmittances tabulated by cosine and height."""

    def __init__(self, amounts) -> None:
        """amounts: factors of air, aerosols and ozone."""
        self.amounts = amounts
        mu, height = np.meshgrid(np.linspace(-1.0, 1.0, LUT[0]), np.linspace(0.0, 1.0, LUT[1]))
        self.table = transmittance(mu.ravel(), height.ravel(), amounts).reshape(LUT[1], LUT[0], 4)

    def at(self, mu, height):
        """Transmittance (..., 4), bilinear in the table; mu and height (...) are broadcast."""
        x = (LUT[0] - 1) * np.clip(0.5 * mu + 0.5, 0.0, 1.0)
        y = (LUT[1] - 1) * np.clip(height, 0.0, 1.0)
        i, j = x.astype(int), y.astype(int)
        i2, j2 = np.minimum(i + 1, LUT[0] - 1), np.minimum(j + 1, LUT[1] - 1)
        s, t = (x - i)[..., None], (y - j)[..., None]
        low = (1.0 - s) * self.table[j, i] + s * self.table[j, i2]
        if not t.any():
            return low
        return (1.0 - t) * low + t * ((1.0 - s) * self.table[j2, i] + s * self.table[j2, i2])

    def scattered_before(self, mu, height, r):
        """Light (rows, n, 4) that was scattered before, by the ground and by the air, for unit irradiance.

        mu : (rows, n), cosines to the sun;  height, r : (rows, 1)
        """
        zero, one = np.zeros_like(height), np.ones_like(height)
        omega = 2.0 * math.pi * (1.0 - np.sqrt(np.maximum(1.0 - (EARTH / r) ** 2, 0.0)))
        up = self.at(one, zero) / self.at(one, height)
        ground = (omega * mu * ALBEDO / (4.0 * math.pi * math.pi))[..., None] * self.at(mu, zero) * up
        air = 0.02 / (1.0 + 5.0 * np.exp(-17.92 * mu))
        return air[..., None] * np.array([0.217, 0.347, 0.594, 1.0]) + ground

    def inscattering(self, d, sun, altitude):
        """Spectra (rows, n, 4) of the light scattered into rays from an altitude [km].

        d : (rows, n, 3), the directions of a row have one elevation, so that its rays pass the same heights
        """
        r0, z = EARTH + altitude, d[:, 0, 2]
        here = np.full(len(z), r0)
        to_ground = leaving(here, z, EARTH)
        step = np.where(to_ground < 0.0, leaving(here, z, TOP), to_ground) / STEPS
        toward = d @ sun
        air_phase = (3.0 / (16.0 * math.pi) * (1.0 + toward * toward))[..., None]
        aerosol_phase = ((1.0 - G * G) / (4.0 * math.pi * (1.0 + G * G - 2.0 * G * toward) ** 1.5))[..., None]
        total, through = np.zeros((*d.shape[:2], 4)), np.ones((len(z), 1, 4))
        for i in range(STEPS):
            t = (i + 0.5) * step
            r = np.sqrt(r0 * r0 + t * t + 2.0 * r0 * t * z)
            h = np.maximum(r - EARTH, 0.0)
            mu = (t[:, None] * toward + r0 * sun[2]) / r[:, None]
            air, aerosol, ext = (c[:, None] for c in coefficients(h, self.amounts))
            height = h[:, None] / THICKNESS
            lit, before = self.at(mu, height), self.scattered_before(mu, height, r[:, None])
            passed = np.exp(-step[:, None, None] * ext)
            share = through * IRRADIANCE * (1.0 - passed) / np.maximum(ext, 1e-7)
            total += share * ((air * air_phase + aerosol * aerosol_phase) * lit + (air + aerosol) * before)
            through = through * passed
        return total


def picture(elevation, altitude, amounts, size):
    """XYZ (H, W, 3), bottom row first: the whole sky, its rows crowded at the horizon; size: (W, H)."""
    width, height = size
    altitude = min(max(altitude, 1.0), HIGHEST) / 1000.0
    azimuth = 2.0 * math.pi * (np.arange(width // 2) + 0.5) / width
    line = 2.0 * (np.arange(height) + 0.5) / height - 1.0
    elev, az = np.meshgrid(np.copysign(line * line, line) * 0.5 * math.pi, azimuth, indexing="ij")
    d = np.stack([np.cos(elev) * np.cos(az), np.cos(elev) * np.sin(az), np.sin(elev)], axis=-1)
    sky = Atmosphere(amounts).inscattering(d, sun_direction(elevation), altitude) @ TO_XYZ
    return np.concatenate([sky, sky[:, ::-1]], axis=1)


def sun_direction(elevation):
    """Unit vector to the sun in the pictures."""
    return np.array([-math.cos(elevation), 0.0, math.sin(elevation)])


def sun_ends(elevation, diameter, altitude, amounts):
    """XYZ (2, 3) of the lowest and the highest point of the sun's disc."""
    altitude = min(max(altitude, 1.0), HIGHEST) / 1000.0
    solid_angle = 2.0 * math.pi * (1.0 - math.cos(0.5 * diameter))
    mu = np.sin([elevation - 0.5 * diameter, elevation + 0.5 * diameter])
    return (IRRADIANCE * transmittance(mu, np.full(2, altitude / THICKNESS), amounts) / solid_angle) @ TO_XYZ


def horizon_angle(altitude):
    """How far below the horizontal the ground begins [rad]; altitude [m]."""
    return 0.5 * math.pi - math.asin(EARTH / (EARTH + altitude / 1000.0))
