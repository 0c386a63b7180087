"""The photon map: photons sorted into the cells of a hashed grid, 32 bytes each and at most 4 for the table.

Cells of a row along x have consecutive hashes, so a query reads each row of cells as one run of memory. Where two
rows of one query can share a bucket (small tables, large radii), a photon counts only for the row that it lies in.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from ..jit import kernel
from .batch import Deposits

_STRIDE_Y = 73856093
_STRIDE_Z = 19349663


class PhotonMap(NamedTuple):
    """Photons in the order of their cells' hashes."""

    position: np.ndarray  # (n, 3) f32 [m]
    flux: np.ndarray  # (n, 3) f32 [W]
    wi: np.ndarray  # (n,) u32, packed
    normal: np.ndarray  # (n,) u32, packed
    start: np.ndarray  # (B + 1,) i32, photons [start[b], start[b + 1]) are in bucket b; B a power of two
    cell: float  # edge of a cell [m]
    clash: bool  # whether cells of one query of radius <= cell can share a bucket

    def nbytes(self) -> int:
        """Memory held [bytes]."""
        return sum(field.nbytes for field in self[:5])


def build_map(deposits: Deposits, cell: float) -> PhotonMap:
    """Sort deposits into cells of the given edge [m] (counting sort, stable: independent of threads)."""
    n = len(deposits.position)
    buckets = 1 << math.floor(math.log2(max(n, 1)))
    start = np.zeros(buckets + 1, np.int32)
    order = np.empty(n, np.int32)
    _count_sort(deposits.position, cell, start, order, np.empty(n, np.int32))
    fields = (deposits.position[order], deposits.flux[order], deposits.wi[order], deposits.normal[order])
    return PhotonMap(*fields, start, cell, rows_clash(buckets))


@cache
def rows_clash(buckets: int) -> bool:
    """Whether rows of three cells that are at most two rows apart can overlap in a table of this size."""
    for dy in range(-2, 3):
        for dz in range(-2, 3):
            gap = row_hash(dy, dz) % buckets
            if (dy or dz) and min(gap, buckets - gap) < 3:
                return True
    return False


def empty_map() -> PhotonMap:
    """A map without photons."""
    none = np.zeros(0, np.uint32)
    rgb = np.zeros((0, 3), np.float32)
    return PhotonMap(rgb, rgb, none, none, np.zeros(2, np.int32), 1.0, True)


@kernel
def cell_index(x, cell):
    """Index of the cell along one axis."""
    return np.int64(math.floor(x / cell))


@kernel
def row_hash(iy, iz):
    """Hash of a row of cells; the cell at ix adds ix."""
    return iy * _STRIDE_Y + iz * _STRIDE_Z


@kernel
def _count_sort(position, cell, start, order, bucket):
    """Write bucket starts and the stable order of photons by bucket; bucket (n,) is work space."""
    n = len(position)
    mask = len(start) - 2
    for i in range(n):
        row = row_hash(cell_index(float(position[i, 1]), cell), cell_index(float(position[i, 2]), cell))
        b = (row + cell_index(float(position[i, 0]), cell)) & mask
        bucket[i] = b
        start[b + 1] += 1
    for b in range(mask + 1):
        start[b + 1] += start[b]
    # from the last photon down, each bucket filled from its end: start[b + 1] ends as the start of bucket b
    for i in range(n - 1, -1, -1):
        b = bucket[i] + 1
        start[b] -= 1
        order[start[b]] = i
    for b in range(mask + 1):
        start[b] = start[b + 1]
    start[mask + 1] = n
