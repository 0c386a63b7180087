"""How the gather radius shrinks from pass to pass, and how a pilot bounds the first one."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree


def radius_factor(i: int, alpha: float) -> float:
    """r_i / r_1 for pass i = 1, 2, ... of memoryless progressive photon mapping.

        r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1)   [Knaus and Zwicker 2011, eq. 15]

    In closed form the product is Gamma(i + alpha) / (Gamma(1 + alpha) Gamma(i + 1)).
    """
    log_square = math.lgamma(i + alpha) - math.lgamma(1.0 + alpha) - math.lgamma(i + 1.0)
    return math.exp(0.5 * log_square)


def neighbour_radius(photons: np.ndarray, points: np.ndarray, k: int) -> np.ndarray:
    """Distance from each point to its k-th nearest photon, by a balanced tree.

    photons : (n, 3);  points : (m, 3);  out : (m,) f64, inf where there are fewer than k photons.
    """
    if len(photons) == 0 or len(points) == 0:
        return np.full(len(points), np.inf)
    tree = cKDTree(photons, balanced_tree=True)
    distance, _ = tree.query(points, k=[k])
    return distance[:, 0]
