"""Lamps larger than they are, for rays that ask whether one is near."""

from __future__ import annotations

import numpy as np

from .table import AREA, DELTA, POINT, SPOT, SUN, LightTable


def enlarged(lights: LightTable, factor: float) -> LightTable | None:
    """The table with lamps `factor` times as large and as bright as they are, to see whether a ray comes near one.

    Emissive triangles and the world stay as they are. None: there is no lamp that a ray can meet.
    """
    met = (lights.flags & DELTA == 0) & np.isin(lights.kind, (POINT, SPOT, AREA, SUN))
    if not met.any():
        return None
    size, sun = lights.size.copy(), lights.kind == SUN
    size[met & ~sun, :2] *= factor
    size[met & sun, 0] = np.minimum(size[met & sun, 0] * factor**2, 2.0)
    extent = np.hypot(size[:, 0], size[:, 1])[met & ~sun]  # of what the tree's nodes bound
    tree = lights.lamp_tree
    return lights._replace(size=size, lamp_tree=tree._replace(radius=tree.radius + extent.max(initial=0.0)))
