"""White noise: every float of the coordinates has its own value."""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from .hashing import TO_UNIT, color_of, hash1, hash2, word


@kernel
def white_rows(places, dims, value, color):
    """Hashes of places (4, n) f32, bit by bit; value : (n,) f32;  color : (3, n) f32, whose red is the value."""
    for i in range(places.shape[1]):
        p = (float(places[0, i]), float(places[1, i]), float(places[2, i]), float(places[3, i]))
        color[0, i], color[1, i], color[2, i] = color_of(dims, p)
        value[i] = color[0, i]


@kernel
def hash_rows(words, out):
    """Numbers in [0, 1] from integers (n,) i64; out : (n,) f32."""
    for i in range(len(words)):
        out[i] = hash1(word(words[i])) * TO_UNIT


@kernel
def hash_rows_beside_zero(words, out):
    """Numbers in [0, 1] from pairs of integers (n,) i64 and 0; out : (n,) f32."""
    for i in range(len(words)):
        out[i] = hash2(word(words[i]), word(0)) * TO_UNIT


def hash_words(words: np.ndarray) -> np.ndarray:
    """Numbers in [0, 1], (n,) f32, from integers (n,) by Jenkins' hash."""
    out = np.empty(len(words), np.float32)
    hash_rows(np.ascontiguousarray(words, np.int64), out)
    return out
