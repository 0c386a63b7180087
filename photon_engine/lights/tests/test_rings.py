"""Photons of suns and sky through disks within disks, against photons spread evenly."""

import numpy as np
import pytest

from ...vec import length
from ..emit import emit_photon
from ..rings import FEWEST, STEP, WORTH, build_rings
from ..table import SUN
from ..table import WORLD as SKY
from ..targets import emit_aimed
from .brute import assert_same, flux_by_region, uniform
from .scenes import LAMPS, RADIUS, SINGLE, WORLD, frame, lamp, table

N = 120_000
SEEN = np.random.default_rng(3).normal((0.6, -0.3, 0.2), 0.1, (500, 3))  # near: most within 0.15 m of 5 m


def regions(lights, rings, aimed, n, seed):
    """Mean flux by the set of disks that a photon passes, (2^C,), and its standard error."""
    sums, squares = np.zeros(2 ** len(rings.radius)), np.zeros(2 ** len(rings.radius))
    flux_by_region(lights, rings, 0, uniform(n, 5, seed), aimed, sums, squares)
    mean = sums / n
    return mean, np.sqrt(np.maximum(squares / n - mean**2, 0.0) / n)


@pytest.mark.parametrize("name", ["sun", "sun disk", "mapped sun", "world", "sky"])
def test_photons_through_disks_bring_the_flux_of_those_spread_evenly(name):
    lights = SINGLE[name]()
    rings = build_rings(lights, SEEN)
    assert len(rings.radius) == 4 and rings.radius[-1] == RADIUS and np.all(np.diff(rings.radius) > 0.0)
    assert np.all(rings.radius[1:-1] / rings.radius[:-2] <= STEP)
    whole, aimed = regions(lights, rings, False, 4 * N, 1), regions(lights, rings, True, N, 2)
    # one in 1000 of those spread evenly passes the innermost disk
    assert_same([x[1:] for x in whole], [x[1:] for x in aimed], floor=5.0 * lights.flux[0, 0] / N)
    everything = len(whole[0]) - 1  # passes all disks
    assert aimed[1][everything] < 0.2 * whole[1][everything], "a hundred times more photons arrive there"


def test_no_photon_weighs_more_than_the_number_of_disks_times_what_it_did():
    lights = SINGLE["sun"]()
    rings = build_rings(lights, SEEN)
    numbers = uniform(2000, 5, 4)
    even = emit_photon(lights, 0, *numbers[0, :4])[2][0]
    phi = np.array([emit_aimed(lights, rings, 0, u[4], *u[:4])[2][0] for u in numbers])
    assert phi.max() <= even * len(rings.radius) * (1.0 + 1e-6)
    assert np.median(phi) < 0.1 * even


def test_light_choice_follows_what_lamps_bring_to_what_is_seen():
    """By flux into the scene a sun gets all photons, and a lamp that lights what is seen none."""
    faint = lamp("SUN", strength=(0.01, 0.01, 0.01))
    near, far = lamp("POINT", frame(SEEN[0])), lamp("POINT", frame((4.5, 0.0, 0.0)))
    lights = table([near, far, faint])
    share = np.diff(build_rings(lights, SEEN).aimed_cdf, prepend=0.0)
    assert list(lights.kind).index(SUN) == 2
    assert share[0] > 10.0 * share[1] and share[2] < 0.1
    assert share.sum() == pytest.approx(1.0) and np.all(share > 0.01)


def test_no_disks_where_they_would_not_pay():
    sun = table([LAMPS["sun"]])
    assert len(build_rings(sun, SEEN).radius)
    assert not len(build_rings(sun, SEEN[: FEWEST - 1]).radius), "hardly anything is seen"
    assert not len(build_rings(sun, np.zeros((100, 3))).radius), "what is seen has no size"
    assert not len(build_rings(table([LAMPS["point"]]), SEEN).radius), "neither sun nor sky"
    width = np.median([length(p) for p in SEEN - np.median(SEEN, axis=0)])
    for wider in (0.9, 1.1):
        points = np.median(SEEN, axis=0) + (SEEN - np.median(SEEN, axis=0)) * RADIUS / (WORTH * width) * wider
        assert (len(build_rings(sun, points).radius) == 0) == (wider > 1.0)
    assert list(table([], world=WORLD).kind) == [SKY] and len(build_rings(table([], world=WORLD), SEEN).radius)
