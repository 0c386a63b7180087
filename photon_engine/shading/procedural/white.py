"""White noise: every float of the coordinates has its own value."""

from __future__ import annotations

from ...jit import kernel
from .hashing import color_of


@kernel
def white_rows(places, dims, value, color):
    """Hashes of places (4, n) f32, bit by bit; value : (n,) f32;  color : (3, n) f32, whose red is the value."""
    for i in range(places.shape[1]):
        p = (float(places[0, i]), float(places[1, i]), float(places[2, i]), float(places[3, i]))
        color[0, i], color[1, i], color[2, i] = color_of(dims, p)
        value[i] = color[0, i]
