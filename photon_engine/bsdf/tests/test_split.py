"""All ways on from a hit, against the picks that they replace."""

import numpy as np
import pytest

from ...jit import kernel
from ...vec import add, load3, store3
from .. import recipes
from ..batch import sample_batch
from ..layout import CLASS_SHARP
from ..split import is_fork, sample_side, sides
from ..surface import prepare
from .registry import SHARP, TINT, direction, frames, rows_of, zeros

CASES = {
    **SHARP,
    "two_mirrors": lambda: recipes.scale_lobes(recipes.glossy(TINT, 0.0), 0.3)
    + recipes.scale_lobes(recipes.glass(TINT, 0.0, 1.5), 0.7),
    "coated_glass": lambda: recipes.principled(
        base_color=TINT, transmission_weight=0.7, roughness=0.0, coat_weight=0.5, ior=1.4
    ),
}


@kernel
def all_sides(rows, ns, ng, wo, scratch, out):
    """Adds the weights of all sides: out[0] what is reflected, out[1] what crosses; whether it was a fork, ways."""
    weights = prepare(rows, 0, ns, ng, wo, 0.05, scratch)
    ways = 0
    for k in range(rows.kind.shape[1]):
        if rows.kind[0, k] == 0:
            break
        if scratch[k, 4] != 1 or scratch[k, 3] <= 0.0:
            continue
        for side in range(sides(rows.kind[0, k])):
            ok, wi, weight, _ = sample_side(rows, 0, k, side, (ns, ng, wo), scratch, 0.3, 0.6)
            if ok:
                ways += 1
                through = 1 if (wi[0] * ng[0] + wi[1] * ng[1] + wi[2] * ng[2]) * wo[2] < 0.0 else 0
                store3(out, through, add(load3(out, through), weight))
    return is_fork(rows.kind[0], scratch, weights), ways


@pytest.mark.parametrize("mu", [0.95, 0.35, -0.7, -0.9])
@pytest.mark.parametrize("name", CASES)
def test_sides_add_up_to_the_mean_of_the_picks(name, mu):
    """For what is reflected and what crosses, colour by colour; 40000 picks leave 1% of the larger one in noise."""
    rows = rows_of(CASES[name]())
    wo, up = direction(mu), (0.0, 0.0, 1.0)
    n = 40_000
    u = np.random.default_rng(7).random((n, 3))
    ok, wi, weight, *_ = sample_batch(rows, zeros(n), frames(n, wo), u, cls=CLASS_SHARP)
    out = np.zeros((2, 3))
    fork, ways = all_sides(rows, up, up, tuple(wo), np.zeros((rows.kind.shape[1], 8)), out)
    through = wi[:, 2] * wo[2] < 0.0
    picked = np.array([(weight * (ok & (through == side))[:, None]).mean(axis=0) for side in (False, True)])
    # facets of lobes that are not quite smooth differ in slope by 0.0016: the weights by less than 1%
    assert np.allclose(out, picked, atol=0.015 * max(picked.max(), 0.1))
    assert fork or ways <= 1
    assert ways > 0 or not ok.any()


def test_fork_counts_rough_and_straight_ways():
    """A single way is no fork; a rough lobe beside a mirror, or a straight pass beside a rough lobe, is."""
    for lobes, expected in (
        (recipes.glossy(TINT, 0.0), False),
        (recipes.diffuse(TINT), False),
        (recipes.transparent(0.5), False),
        (recipes.glass(TINT, 0.0, 1.5), True),
        (recipes.diffuse(TINT) + recipes.glossy(TINT, 0.0), True),
        (recipes.diffuse(TINT) + recipes.transparent(0.5), True),
    ):
        rows = rows_of(lobes)
        up, scratch = (0.0, 0.0, 1.0), np.zeros((len(lobes) + 1, 8))
        fork, _ = all_sides(rows, up, up, (0.0, 0.6, 0.8), scratch, np.zeros((2, 3)))
        assert fork == expected
