"""Measured and fitted constants of the sky models, from tables.npz.

hosek_shape (3, 2, 10, 6, 9), hosek_radiance (3, 2, 10, 6): XYZ; albedo 0, 1; turbidity 1 .. 10; knots of the elevation.
    Hosek and Wilkie, An Analytic Model for Full Spectral Sky-Dome Radiance, version 1.4a. Copyright (c) 2012 - 2013,
    Lukas Hosek and Alexander Wilkie, all rights reserved; redistributed under their licence (BSD, three clauses).
irradiance [W/m^2/nm], rayleigh, ozone [1/m] (21,), xyz (21, 3): every 20 nm from 380 to 780 nm, as Blender has them.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np


@cache
def tables() -> dict[str, np.ndarray]:
    """All arrays by name, f64."""
    with np.load(Path(__file__).with_name("tables.npz")) as file:
        return {name: file[name] for name in file.files}
