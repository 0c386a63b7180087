"""The kernel decorator of the reference tracer: the engine's flags, and a cache keyed by all sources in this folder."""

import hashlib
from pathlib import Path

import numba

from photon_engine.jit import FASTMATH, cache_root
from photon_engine.kernel_cache import KernelCache

HERE = Path(__file__).resolve().parent
DIGEST = hashlib.sha256(b"".join(p.read_bytes() for p in sorted(HERE.glob("*.py")))).hexdigest()[:16]


def kernel(function):
    """Compile a function: no GIL, cached, NaN kept; a change in any file of this folder makes a new cache."""
    compiled = numba.njit(nogil=True, fastmath=FASTMATH, error_model="numpy")(function)
    compiled._cache = KernelCache(function, cache_root() / f"brute_{DIGEST}")
    return compiled
