"""How many of a point's shadow rays go to suns: one is enough for a disk that is all seen or all hidden."""

from __future__ import annotations

import math

import numpy as np

from .select import FLOOR
from .table import SUN, WORLD, LightTable

NARROW = 1.0 - math.cos(0.0176)  # 1 - cos of the half angle of a sun that casts hard shadows: 2 degrees in all
LEAST = 1e-3  # of all weight: every light stays possible


def one_ray_to_suns(lights: LightTable, samples: int) -> LightTable:
    """The table with selection weights by which a narrow sun gets one of `samples` stratified shadow rays, not more.

    By power a sun takes most of them, and the sky, which needs them, what is left. Only where all lights are suns and
    a world: others have weights by place. The table itself where no narrow sun would get more than one ray.
    """
    suns, sky = lights.kind == SUN, lights.kind == WORLD
    narrow = suns & (lights.size[:, 0] <= NARROW)
    n = len(lights.kind)
    if samples < 2 or not narrow.any() or narrow.all() or not (suns | sky).all():
        return lights
    share = (1.0 - FLOOR) * lights.power / lights.power.sum() + FLOOR / n
    much = narrow & (share > 1.0 / samples)
    if not much.any():
        return lights
    # weights whose shares are 1 / samples once the floor is added; the others keep their proportions
    wanted = max((1.0 / samples - FLOOR / n) / (1.0 - FLOOR), LEAST)
    rest = 1.0 - wanted * np.count_nonzero(much)
    if rest <= 0.0:
        return lights
    power = np.where(much, wanted, lights.power * (rest / lights.power[~much].sum()))
    return lights._replace(power=power)
