"""Lamps larger than they are are met by all rays that pass them that near."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ..enlarge import enlarged
from ..sample import lamps_along_ray, suns_along_ray
from ..table import MANY
from .scenes import EMITTERS, LAMPS, WORLD, frame, lamp, table

FACTOR = 5.0
EYE = (0.0, 0.0, 0.0)
TINY = {
    "sphere": {"radius": 0.01}, "soft point": {"radius": 0.01}, "spot sphere": {"radius": 0.01},
    "square": {"size": (0.02, 0.02)}, "sun disk": {"angle": 0.01},
}  # fmt: skip


def met(lights, x):
    """Whether a ray that passes x [m] beside a point 2 m above meets a lamp."""
    d = tuple(np.array([x, 0.0, 2.0]) / math.hypot(x, 2.0))
    seen = lamps_along_ray(lights, EYE, d, math.inf, EYE, 0.0, 0, 0)[0] + suns_along_ray(lights, d, EYE, 0.0, 0, 0)[0]
    return seen > 0.0


@pytest.mark.parametrize("many", [1, MANY + 8])
@pytest.mark.parametrize("name", list(TINY))
def test_lamps_are_met_from_as_much_farther(name, many):
    """The half size is 0.01 m at 2 m; further lamps, whose choice takes a tree, are elsewhere."""
    others = [lamp("POINT", frame((4.0 + 0.1 * i, 5.0, 0.1 * i)), radius=0.01) for i in range(many - 1)]
    lights = table([replace(LAMPS[name], matrix=frame((0.0, 0.0, 2.0)), **TINY[name]), *others])
    large = enlarged(lights, FACTOR)
    for x in np.linspace(-0.07, 0.07, 29):  # no edge of a square, however it is turned, between 1 and 1.42
        if abs(x) < 0.0095 or 0.0145 < abs(x):
            assert met(lights, x) == (abs(x) < 0.01), x
        if abs(x) < 0.0475 or 0.0725 < abs(x):
            assert met(large, x) == (abs(x) < 0.05), x


def test_what_no_ray_meets_is_not_enlarged():
    assert enlarged(table([LAMPS["point"]], EMITTERS, WORLD), FACTOR) is None
    assert enlarged(table([], EMITTERS), FACTOR) is None
