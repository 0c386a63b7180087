"""Pixel filters by importance sampling: where in a pixel's neighbourhood a ray goes.

Each ray counts fully for its own pixel, so that pixels are independent and errors do not spread between them. Shapes
and widths are those of Cycles: a filter of width w [px] reaches w / 2 (box), 1.5 w (Gaussian), w (Blackman-Harris) from
the pixel's centre.
"""

from __future__ import annotations

import math

import numpy as np

from ..issues import RenderError
from ..jit import kernel

TABLE_SIZE = 2049
FINE = 1 << 16  # steps of the numerical integral behind the table

# half width over the filter's width
REACH = {"BOX": 0.5, "GAUSSIAN": 1.5, "BLACKMAN_HARRIS": 1.0}


def filter_value(name: str, x: np.ndarray, width: float) -> np.ndarray:
    """Unnormalised weight at distance x [px] from the centre along one axis; 0 outside the reach.

    Gaussian: exp(-8 (x / w)^2). Blackman-Harris: the 4-term window [Harris 1978] stretched over [-w, w].
    """
    x = np.asarray(x, np.float64)
    if name == "BOX":
        value = np.ones_like(x)
    elif name == "GAUSSIAN":
        value = np.exp(-8.0 * (x / width) ** 2)
    else:
        v = np.pi * (x / width + 1.0)
        value = 0.35875 - 0.48829 * np.cos(v) + 0.14128 * np.cos(2.0 * v) - 0.01168 * np.cos(3.0 * v)
    return np.where(np.abs(x) <= REACH[name] * width, value, 0.0)


def filter_table(name: str, width: float) -> np.ndarray:
    """Distance |x| [px] at TABLE_SIZE equal steps of s in [0, 1], f64, where 1 - (1 - s)^4 is the probability of less.

    The fourth power spreads out the thin tails, in which linear interpolation of the plain inverse CDF is poor.
    """
    if name not in REACH:
        raise RenderError("Pixel Filter", f"'{name}' is not a filter", f"one of: {', '.join(REACH)}")
    if not width > 0.0:
        raise RenderError("Pixel Filter", f"a width of {width:g} px is not positive", "use 1.5")
    reach = REACH[name] * width
    x = np.linspace(0.0, reach, FINE + 1)
    density = filter_value(name, x, width)
    beyond = np.cumsum((0.5 * (density[1:] + density[:-1]))[::-1])[::-1]
    s = 1.0 - np.append(beyond / beyond[0], 0.0) ** 0.25
    table = np.interp(np.linspace(0.0, 1.0, TABLE_SIZE), s, x)
    table[-1] = reach
    return table


@kernel
def sample_filter(table, u):
    """Offset from the pixel's centre along one axis [px], from u in [0, 1)."""
    x = 2.0 * u - 1.0
    position = (1.0 - math.sqrt(math.sqrt(1.0 - abs(x)))) * (len(table) - 1)
    i = min(int(position), len(table) - 2)
    value = table[i] + (position - i) * (table[i + 1] - table[i])
    return value if x >= 0.0 else -value


def filter_position(table: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The number u in [0, 1] for which `sample_filter` tells the offset x [px]: 0 or 1 beyond the filter's reach."""
    s = np.interp(np.abs(x), table, np.linspace(0.0, 1.0, len(table)))
    return 0.5 + 0.5 * np.sign(x) * (1.0 - (1.0 - s) ** 4)
