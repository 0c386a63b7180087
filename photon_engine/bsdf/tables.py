"""Directional albedos of GGX, from tables.npz (see make_tables.py), interpolated linearly.

All are over roughness (unsquared) in x, the cosine to the normal in y, and, where there is an index of refraction,
z = F0^(1/4).
"""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import numpy as np

from ..jit import kernel

# Kernels freeze the tables in their compiled code; the checksum here makes new tables a change of source.
SHA256 = "2c637260981c9622836396cb55c7528594ea363167f90df40ef5a63f277ae6cc"


def load_tables() -> dict[str, np.ndarray]:
    """The tables by name; an error when the file is not the one this source was written for."""
    path = Path(__file__).with_name("tables.npz")
    found = hashlib.sha256(path.read_bytes()).hexdigest()
    if found != SHA256:
        raise ValueError(f"{path.name} has the checksum {found}; run make_tables.py and set SHA256 in tables.py")
    with np.load(path) as file:
        return {name: np.ascontiguousarray(file[name]) for name in file.files}


_TABLES = load_tables()
WHITE = _TABLES["white"]
WHITE_AVG = _TABLES["white_avg"]
GLASS = _TABLES["glass"]
GLASS_AVG = _TABLES["glass_avg"]
INVERSE = _TABLES["inverse"]
INVERSE_AVG = _TABLES["inverse_avg"]
SHARE = _TABLES["share"]
SCHLICK = _TABLES["schlick"]
FILM = _TABLES["film"]


@kernel
def cell(x, size):
    """Index and fraction of x in [0, 1] on a grid of `size` points."""
    x = min(max(x, 0.0), 1.0) * (size - 1)
    i = min(int(x), size - 2)
    return i, x - i


@kernel
def read_2d(table, z, y, x):
    """Bilinear value in slice z of a (Z, Y, X) table; x, y in [0, 1]."""
    i, s = cell(x, table.shape[2])
    j, t = cell(y, table.shape[1])
    low = table[z, j, i] * (1.0 - s) + table[z, j, i + 1] * s
    high = table[z, j + 1, i] * (1.0 - s) + table[z, j + 1, i + 1] * s
    return low * (1.0 - t) + high * t


@kernel
def read_3d(table, z, y, x):
    """Trilinear value of a (Z, Y, X) table; x, y, z in [0, 1]."""
    k, s = cell(z, table.shape[0])
    return read_2d(table, k, y, x) * (1.0 - s) + read_2d(table, k + 1, y, x) * s


@kernel
def read_rows(table, z, x):
    """Bilinear value of a (Z, X) table; x, z in [0, 1]."""
    k, s = cell(z, table.shape[0])
    i, t = cell(x, table.shape[1])
    low = table[k, i] * (1.0 - t) + table[k, i + 1] * t
    high = table[k + 1, i] * (1.0 - t) + table[k + 1, i + 1] * t
    return low * (1.0 - s) + high * s


@kernel
def index_coordinate(eta):
    """z = F0^(1/4) of an index or its inverse."""
    return math.sqrt(abs((eta - 1.0) / (eta + 1.0)))


@kernel
def white_albedo(rough, mu):
    """Directional albedo E of a perfectly reflecting GGX, and its cosine-weighted mean over directions."""
    i, s = cell(rough, WHITE_AVG.shape[1])
    mean = WHITE_AVG[0, i] * (1.0 - s) + WHITE_AVG[0, i + 1] * s
    return read_2d(WHITE, 0, mu, rough), mean


@kernel
def glass_albedo(rough, mu, eta):
    """Directional albedo E of clear dielectric GGX (reflected and refracted), and its mean over directions."""
    z = index_coordinate(eta)
    if eta < 1.0:
        return read_3d(INVERSE, z, mu, rough), read_rows(INVERSE_AVG, z, rough)
    return read_3d(GLASS, z, mu, rough), read_rows(GLASS_AVG, z, rough)


@kernel
def dielectric_share(rough, mu, eta):
    """Mean share between F0 and F90 under the visible normals, for the dielectric curve of index eta."""
    return read_3d(SHARE, index_coordinate(eta), mu, rough)


@kernel
def schlick_share_5(rough, mu):
    """Mean of (1 - cos)^5 under the visible normals."""
    return read_2d(SCHLICK, 0, mu, rough)
