"""Gabor noise by sparse convolution [Lagae et al. 2009; Tavernier et al. 2019; Tricard et al. 2019, Phasor noise]."""

from __future__ import annotations

import math

from ...jit import kernel
from .hashing import random3, random4

IMPULSES = 8  # in each cell
CUBE_DEVIATION = math.sqrt(IMPULSES * 0.5 / (4.0 * math.sqrt(2.0)))  # of the 3D noise [Lagae, Eq. 9, f -> inf]
PLANE_DEVIATION = math.sqrt(IMPULSES * 0.5 * 0.25)
# rows of the parameters of `gabor_rows`
FREQUENCY, ISOTROPY, ORIENTATION, X, Y, Z = range(6)
N_PARAMETERS = 6


@kernel
def wavelet(d2, phase):
    """A Gabor kernel as a phasor: Gauss and Hann windows of the squared distance, times e^(i phase)."""
    size = math.exp(-math.pi * d2) * (0.5 + 0.5 * math.cos(math.pi * d2))
    return size * math.cos(phase), size * math.sin(phase)


@kernel
def plane_cell(cell, x, y, law):
    """Sum of a cell's impulses at (x, y) in the cell; law: frequency, isotropy, orientation [rad]."""
    frequency, isotropy, orientation = law
    real = imaginary = 0.0
    for i in range(IMPULSES):
        k = 3.0 * i
        px = x - random3(cell[0], cell[1], k + 1.0)
        py = y - random3(k + 1.0, cell[0], cell[1])
        d2 = px * px + py * py
        if d2 >= 1.0:
            continue
        angle = orientation + (random3(cell[0], cell[1], k) - 0.5) * math.pi * isotropy
        sign = -1.0 if random3(cell[0], cell[1], k + 2.0) < 0.5 else 1.0
        phase = 2.0 * math.pi * frequency * (px * math.cos(angle) + py * math.sin(angle))
        a, b = wavelet(d2, phase)
        real += sign * a
        imaginary += sign * b
    return real, imaginary


@kernel
def turned(axis, isotropy, seed):
    """The unit axis moved at random in both spherical angles, up to pi times the isotropy."""
    if isotropy == 0.0:
        return axis
    x, y, z = axis
    flat = math.sqrt(x * x + y * y)
    inclination = math.acos(min(max(z, -1.0), 1.0))
    azimuth = math.acos(min(max(x / flat, -1.0), 1.0)) if flat > 0.0 else 0.0
    azimuth = -azimuth if y < 0.0 else azimuth
    inclination += random4(seed[0], seed[1], seed[2], seed[3]) * math.pi * isotropy
    azimuth += random4(seed[2], seed[0], seed[3], seed[1]) * math.pi * isotropy
    s = math.sin(inclination)
    return (s * math.cos(azimuth), s * math.sin(azimuth), math.cos(inclination))


@kernel
def cube_cell(cell, p, frequency, isotropy, axis):
    """Sum of a cell's impulses at p in the cell."""
    cx, cy, cz = cell
    real = imaginary = 0.0
    for i in range(IMPULSES):
        k = 3.0 * i
        px = p[0] - random4(cx, cy, cz, k + 1.0)
        py = p[1] - random4(cz, cx, k + 1.0, cy)
        pz = p[2] - random4(k + 1.0, cz, cy, cx)
        d2 = px * px + py * py + pz * pz
        if d2 >= 1.0:
            continue
        way = turned(axis, isotropy, (cx, cy, cz, k))
        sign = -1.0 if random4(cx, cy, cz, k + 2.0) < 0.5 else 1.0
        a, b = wavelet(d2, 2.0 * math.pi * frequency * (px * way[0] + py * way[1] + pz * way[2]))
        real += sign * a
        imaginary += sign * b
    return real, imaginary


@kernel
def phasor(place, law, axis, in_space):
    """The noise as a complex number: the sum over the cells around a place."""
    fx, fy = math.floor(place[0]), math.floor(place[1])
    fz = math.floor(place[2]) if in_space else 0
    x, y, z = place[0] - fx, place[1] - fy, place[2] - fz
    depth = 1 if in_space else 0
    real = imaginary = 0.0
    for k in range(-depth, depth + 1):
        for j in range(-1, 2):
            for i in range(-1, 2):
                if in_space:
                    cell = (float(fx + i), float(fy + j), float(fz + k))
                    a, b = cube_cell(cell, (x - i, y - j, z - k), law[0], law[1], axis)
                else:
                    a, b = plane_cell((float(fx + i), float(fy + j)), x - i, y - j, law)
                real += a
                imaginary += b
    return real, imaginary


@kernel
def gabor_rows(places, parameters, in_space, out):
    """Gabor noise of a batch; places : (4, n) f32;  parameters : (N_PARAMETERS, n | 1) f32

    out : (3, n) f32: value in [0, 1] (about), phase in [0, 1], intensity
    """
    step = 0 if parameters.shape[1] == 1 else 1
    scale = 1.0 / (6.0 * (CUBE_DEVIATION if in_space else PLANE_DEVIATION))
    for i in range(places.shape[1]):
        q = parameters[:, i * step]
        law = (max(float(q[FREQUENCY]), 0.001), float(q[ISOTROPY]), float(q[ORIENTATION]))
        place = (float(places[0, i]), float(places[1, i]), float(places[2, i]))
        if not math.isfinite(place[0] + place[1] + place[2]):
            place = (0.0, 0.0, 0.0)
        real, imaginary = phasor(place, law, (float(q[X]), float(q[Y]), float(q[Z])), in_space)
        out[0, i] = 0.5 * imaginary * scale + 0.5
        out[1, i] = (math.atan2(imaginary, real) + math.pi) / (2.0 * math.pi)
        out[2, i] = math.sqrt(real * real + imaginary * imaginary) * scale
