"""How the gather radius shrinks from pass to pass, and how a pilot bounds the first one."""

from __future__ import annotations

import math

import numpy as np

from ..jit import inlined, kernel

LINE = np.array([0.8, 0.48, 0.36])  # of unit length: a step along it is no longer than the distance
EVEN_SO = 1.0 - 1e-9  # but for rounding


def radius_factor(i: int, alpha: float) -> float:
    """r_i / r_1 for pass i = 1, 2, ... of memoryless progressive photon mapping.

        r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1)   [Knaus and Zwicker 2011, eq. 15]

    In closed form the product is Gamma(i + alpha) / (Gamma(1 + alpha) Gamma(i + 1)).
    """
    log_square = math.lgamma(i + alpha) - math.lgamma(1.0 + alpha) - math.lgamma(i + 1.0)
    return math.exp(0.5 * log_square)


def neighbour_radius(photons: np.ndarray, points: np.ndarray, k: int) -> np.ndarray:
    """Distance from each point to its k-th nearest photon.

    photons : (n, 3);  points : (m, 3);  out : (m,) f64, inf where there are fewer than k photons.

    Photons are sorted along an oblique line, along which no wall lies all in one place, and looked at from the point
    outward until the rest is too far off along the line alone. For a thousand points that is hardly slower than a tree,
    and scipy's takes ten times as long to import.
    """
    out = np.full(len(points), np.inf)
    if len(photons) and len(points):
        place = photons @ LINE
        order = np.argsort(place, kind="stable")
        photons, place = np.ascontiguousarray(photons[order], np.float64), place[order]
        points, own = np.ascontiguousarray(points, np.float64), points @ LINE
        nearest_in_order(photons, place, points, own, np.searchsorted(place, own), np.empty(k), out)
    return out


@kernel
def nearest_in_order(photons, place, points, own, first, nearest, out):
    """`neighbour_radius` of photons in ascending order of their place (n,) on a line; points are at own (m,) on it.

    first : (m,) i64, the first photon that is not before the point;  nearest : (k,) f64, work space
    """
    n = len(photons)
    for i in range(len(points)):
        nearest[:] = math.inf
        low, high = first[i] - 1, first[i]
        while low >= 0 or high < n:
            down = own[i] - place[low] if low >= 0 else math.inf
            up = place[high] - own[i] if high < n else math.inf
            step = EVEN_SO * min(down, up)
            if step * step > nearest[-1]:
                break
            j = low if down < up else high
            low -= 1 if down < up else 0
            high += 0 if down < up else 1
            insert(nearest, squared_distance(photons, j, points, i))
        out[i] = math.sqrt(nearest[-1])


@inlined
def squared_distance(a, i, b, j):
    """Of rows i and j."""
    x, y, z = a[i, 0] - b[j, 0], a[i, 1] - b[j, 1], a[i, 2] - b[j, 2]
    return x * x + y * y + z * z


@inlined
def insert(ascending, value):
    """Put a value into its place among ascending ones, the largest of which falls out."""
    k = len(ascending) - 1
    if value < ascending[k]:
        while k > 0 and ascending[k - 1] > value:
            ascending[k] = ascending[k - 1]
            k -= 1
        ascending[k] = value
