"""Reading a lobe's numbers."""

from __future__ import annotations

from ..jit import kernel

ONE = (1.0, 1.0, 1.0)
BLACK = (0.0, 0.0, 0.0)


@kernel
def field3(rows, row, k, offset):
    """Three numbers of a lobe as a tuple of doubles."""
    p = rows.params
    return (float(p[row, k, offset]), float(p[row, k, offset + 1]), float(p[row, k, offset + 2]))


@kernel
def mix3(a, b, t):
    """a + (b - a) t."""
    return (a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t)
