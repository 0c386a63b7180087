"""Counter-based random numbers: a number is a hash of (seed, pass, stream, path, dimension).

Nothing is carried from one draw to the next, so a pass is the same on any machine, thread count and chunk size.
The mixer is the finaliser of SplitMix64 [Steele et al. 2014, OOPSLA, Fig. 16].
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel

# streams: what the numbers are for
STREAM_PILOT = 0
STREAM_CAUSTIC = 1
STREAM_DIFFUSE = 2
STREAM_EYE = 3

DIMENSIONS_PER_BOUNCE = 16

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MUL1 = np.uint64(0xBF58476D1CE4E5B9)
_MUL2 = np.uint64(0x94D049BB133111EB)
_DIM = np.uint64(0xD1342543DE82EF95)
_S27 = np.uint64(27)
_S30 = np.uint64(30)
_S31 = np.uint64(31)
_S11 = np.uint64(11)
_S32 = np.uint64(32)
_TO_UNIT = 2.0**-53


@kernel
def mix(x):
    """Bijective scrambling of 64 bits."""
    x = (x ^ (x >> _S30)) * _MUL1
    x = (x ^ (x >> _S27)) * _MUL2
    return x ^ (x >> _S31)


@kernel
def stream_key(seed, iteration, stream):
    """Key of all numbers of one purpose in one pass. seed, iteration, stream: non-negative integers."""
    x = mix(np.uint64(seed) * _GOLDEN + _MUL1)
    x = mix(x + np.uint64(iteration) * _GOLDEN)
    return mix(x + np.uint64(stream) * _GOLDEN)


def make_key(seed: int, iteration: int, stream: int) -> np.uint64:
    """stream_key for Python callers: numba would return a plain int, which is a kernel argument of another type."""
    return np.uint64(stream_key(seed, iteration, stream))


@kernel
def path_key(key, path):
    """Key of one path (photon or pixel) within a stream."""
    return mix(key + np.uint64(path) * _GOLDEN)


@kernel
def uniform(key, dimension):
    """The number of a path's dimension: double in [0, 1)."""
    return float(mix(key + np.uint64(dimension + 1) * _DIM) >> _S11) * _TO_UNIT


@kernel
def shifted(points, key, index, dimension):
    """Number of a low-discrepancy point, moved by a random digital shift that the key decides. Double in [0, 1).

    points : (N, D) u32. XOR with random bits keeps how evenly the points fill the cube and makes each of them
    uniform, so a mean over them is unbiased, and means of different keys are independent [Kollig and Keller 2002].
    """
    shift = np.uint32(mix(key + np.uint64(dimension + 1) * _DIM) >> _S32)
    return float(points[index, dimension] ^ shift) * 2.0**-32
