"""Photons near a point: which cells are read, which photons are near, and the flux of those that lie on a plane.

Of the photons that are read, some lie within the radius, nobody can guess which: they are listed without branches and
then taken LANES at a time, column by column as in matte_kernels, so that the compiler makes vector instructions of it:
two thirds of the time of a loop with branches.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..jit import inlined, kernel
from ..photons.map import PhotonMap, cell_index, row_hash
from ..photons.packing import touches, unpack_facet
from ..vec import dot, load3, scale
from .clearing_kernels import SAME_SURFACE
from .clipping import Clearings

MOST_RISE = 0.25 + 1e-3  # squared sine of 30 degrees, and rounding
LANES = 16  # caustics have ten photons within a radius
MOST_FOUND = 256  # before they are taken

# columns of work space: offset from the point, flux, weight
OFFSET, FLUX, WEIGHT = 0, 3 * LANES, 6 * LANES
N_COLUMNS = 7


class Radius(NamedTuple):
    """How far to look for photons in this pass."""

    pixels: float  # times the footprint of a pixel
    least: float  # whatever the pixel [m]
    bound: float  # at most [m]


class Near(NamedTuple):
    """Work space for the photons near a point."""

    index: np.ndarray  # (MOST_FOUND + 1,) i64, which they are
    value: np.ndarray  # (N_COLUMNS * LANES,) f64
    facet: np.ndarray  # (LANES,) i64, their packed normals


class Lookup(NamedTuple):
    """Where a batch of visible points finds its photons."""

    photons: PhotonMap
    radius: Radius
    clearings: Clearings  # which of them count
    near: Near


def look_up(photons: PhotonMap, radius: Radius, clearings: Clearings) -> Lookup:
    """A lookup with work space of its own."""
    return Lookup(photons, radius, clearings, empty_near())


def empty_near() -> Near:
    """Work space whose unused lanes hold harmless numbers."""
    return Near(np.zeros(MOST_FOUND + 1, np.int64), np.zeros(N_COLUMNS * LANES), np.zeros(LANES, np.int64))


@inlined
def parts_of_row(photons, iy, iz, x0, count):
    """2 where a row of cells from x0 on wraps round the table, else 1."""
    size = len(photons.start) - 1
    return 2 if ((row_hash(iy, iz) + x0) & (size - 1)) + min(count, size) > size else 1


@inlined
def run_of_cells(photons, iy, iz, x0, count, part):
    """Photons [first, last) of a row of cells from x0 on; a row that wraps round the table has a second part."""
    size = len(photons.start) - 1
    count = min(count, size)
    b = (row_hash(iy, iz) + x0) & (size - 1)
    if part == 0:
        return photons.start[b], photons.start[min(b + count, size)]
    return 0, photons.start[max(min(b + count - size, size), 0)]


@inlined
def in_row(q, cell, iy, iz, x0, x1):
    """Whether a photon lies in the row of cells that is being read, not in another one with the same hash."""
    return cell_index(q[1], cell) == iy and cell_index(q[2], cell) == iz and x0 <= cell_index(q[0], cell) <= x1


@inlined
def is_stacked(n, facet, offset, d2):
    """Whether a facet lies above or below the point's own surface, not on what continues it.

    Along an arc, and along a crease of up to 60 degrees seen from its edge, the chord is at most 30 degrees off being
    perpendicular to the sum of the normals (unit vectors).
    """
    x, y, z = n[0] + facet[0], n[1] + facet[1], n[2] + facet[2]
    rise = x * offset[0] + y * offset[1] + z * offset[2]
    return rise * rise > MOST_RISE * d2 * (x * x + y * y + z * z)


@inlined
def scan(photons, first, last, p, r2, row, near, found):
    """List photons [first, last) whose squared distance from p is below r2, behind `found` others; out: how many now.

    row : (whether `in_row` must be asked, iy, iz, x0, x1)
    """
    check, iy, iz, x0, x1 = row
    for j in range(first, last):
        q = load3(photons.position, j)
        dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        near.index[found] = j
        within = dx * dx + dy * dy + dz * dz < r2
        if check:
            within = within and in_row(q, photons.cell, iy, iz, x0, x1)
        found += 1 if within else 0
    return found


@kernel
def flux_near(photons, p, n, own, r2, cut, near, found):
    """Sums of (1 - x^2) phi and of x^2 (1 - x^2) phi over those of the listed photons that lie on the plane.

    The plane goes through p with the normal n; x^2 = d^2 / r2; own : packing.body of that side
    cut : (lines, how many): photons beyond one are left out
    """
    lines, count = cut
    red, green, blue = 0.0, 0.0, 0.0
    red2, green2, blue2 = 0.0, 0.0, 0.0
    v = near.value
    for first in range(0, found, LANES):
        _load(photons, near, first, min(LANES, found - first), p)
        _weigh(near, n, own, r2)
        for k in range(count):
            for j in range(LANES):
                along = lines[k, 0] * v[OFFSET + j] + lines[k, 1] * v[OFFSET + LANES + j]
                past = along + lines[k, 2] * v[OFFSET + 2 * LANES + j] > lines[k, 3]
                v[WEIGHT + j] = 0.0 if past else v[WEIGHT + j]
        for j in range(LANES):
            w = v[WEIGHT + j]
            w2 = w * (1.0 - w)
            r, g, b = v[FLUX + j], v[FLUX + LANES + j], v[FLUX + 2 * LANES + j]
            red, green, blue = red + w * r, green + w * g, blue + w * b
            red2, green2, blue2 = red2 + w2 * r, green2 + w2 * g, blue2 + w2 * b
    return (red, green, blue), (red2, green2, blue2)


@inlined
def _load(photons, near, first, count, p):
    """Put `count` listed photons from the `first` on into the lanes; no flux into those beyond."""
    v = near.value
    for j in range(count):
        i = near.index[first + j]
        for c in range(3):
            v[OFFSET + c * LANES + j] = photons.position[i, c] - p[c]
            v[FLUX + c * LANES + j] = photons.flux[i, c]
        near.facet[j] = photons.normal[i]
    for j in range(count, LANES):
        for c in range(3):
            v[FLUX + c * LANES + j] = 0.0


@inlined
def _weigh(near, n, own, r2):
    """Weights 1 - x^2 of the lanes' photons, 0 of those that lie on another surface."""
    v = near.value
    for j in range(LANES):
        offset = (v[OFFSET + j], v[OFFSET + LANES + j], v[OFFSET + 2 * LANES + j])
        facet = unpack_facet(near.facet[j])
        d2, c, size2 = dot(offset, offset), dot(facet, n), dot(facet, facet)
        same = (c > 0.0) & (c * c >= SAME_SURFACE * SAME_SURFACE * size2)
        stacked = is_stacked(n, scale(facet, 1.0 / math.sqrt(size2)), offset, d2) | touches(near.facet[j], own)
        v[WEIGHT + j] = 1.0 - d2 / r2 if same & (not stacked) else 0.0
