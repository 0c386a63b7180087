"""Sobol's sequence in up to six dimensions, the same numbers as `scipy.stats.qmc.Sobol` gives.

Made here because importing scipy.stats takes as long as a first pass of a small picture.
"""

from __future__ import annotations

import numpy as np

BITS = 32
# (coefficients of the primitive polynomial without its ends, first direction numbers) of each dimension after the
# first, which is van der Corput's [Joe and Kuo 2008, SIAM J. Sci. Comput. 30(5), new-joe-kuo-6.21201]
POLYNOMIALS = (
    (0, (1,)),
    (1, (1, 3)),
    (1, (1, 3, 1)),
    (2, (1, 1, 1)),
    (1, (1, 1, 3, 3)),
)
DIMENSIONS = len(POLYNOMIALS) + 1


def directions(dimensions: int) -> np.ndarray:
    """Direction numbers (D, BITS) u32: column k is XORed in where bit k of a point's Gray code is set."""
    table = np.zeros((dimensions, BITS), np.uint32)
    for d in range(dimensions):
        coefficients, first = POLYNOMIALS[d - 1] if d else (0, (1,) * BITS)
        degree = len(first)
        m = list(first)
        for k in range(degree, BITS):
            new = m[k - degree] ^ (m[k - degree] << degree)
            for j in range(1, degree):
                if (coefficients >> (degree - 1 - j)) & 1:
                    new ^= m[k - j] << j
            m.append(new)
        table[d] = [m[k] << (BITS - 1 - k) for k in range(BITS)]
    return table


def scrambled(table: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Direction numbers (D, BITS) under random linear maps of their bits, and a random first point (D,) u32.

    Lower triangular maps, so that points stay as evenly spread as they were [Matousek 1998, J. Complexity 14(4)].
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed).spawn(1)[0])
    dimensions = len(table)
    power = np.uint32(1) << np.arange(BITS, dtype=np.uint32)
    start = (rng.integers(0, 2, (dimensions, BITS), np.uint32) * power).sum(axis=1, dtype=np.uint32)
    maps = np.tril(rng.integers(0, 2, (dimensions, BITS, BITS), np.uint32)) | np.eye(BITS, dtype=np.uint32)
    # bits from the highest down, as the maps' rows and columns are
    bits = (table[:, :, None] >> np.arange(BITS - 1, -1, -1, dtype=np.uint32)) & 1
    mapped = np.einsum("dij,dkj->dki", maps, bits) & 1
    return (mapped * power[::-1]).sum(axis=2, dtype=np.uint32), start


def sobol(n: int, dimensions: int, seed: int | None = None) -> np.ndarray:
    """The first n points (n, D) u32, in units of 2^-32; with a seed: scrambled."""
    table, start = directions(dimensions), np.zeros(dimensions, np.uint32)
    if seed is not None:
        table, start = scrambled(table, seed)
    points = np.empty((1 << max(n - 1, 0).bit_length(), dimensions), np.uint32)
    points[0] = start
    for k in range(len(points).bit_length() - 1):
        done = 1 << k
        # Gray codes of the next as many numbers: those so far in reverse order, and bit k
        np.bitwise_xor(points[done - 1 :: -1], table[:, k], out=points[done : 2 * done])
    return points[:n]
