"""Aimed photons against whole-light photons, and the merging of targets."""

import math

import numpy as np
import pytest

from ..targets import MAX_TARGETS, build_targets, emit_aimed, merge_spheres, pilot_numbers
from .brute import assert_same, flux_by_region, uniform
from .scenes import EMITTERS, LAMPS, SINGLE, WORLD, frame, lamp, table

CENTERS = np.array([[0.0, 0.0, 0.0], [0.4, 0.1, 0.2], [-0.8, 0.6, 0.4]])
RADII = np.array([0.4, 0.3, 0.2])
N = 120_000


def regions(lights, targets, aimed, n=N, seed=21):
    sums, squares = np.zeros(8), np.zeros(8)
    flux_by_region(lights, targets, 0, uniform(n, 5, seed), aimed, sums, squares)
    mean = sums / n
    return mean, np.sqrt(np.maximum(squares / n - mean**2, 0.0) / n)


@pytest.mark.parametrize("name", SINGLE)
def test_aimed_photons_bring_the_flux_of_whole_light_photons(name):
    """Region by region: through one target alone, through two that overlap, and so on."""
    lights = SINGLE[name]()
    targets = build_targets(lights, CENTERS, RADII)
    assert len(targets.radius) == 3
    whole, aimed = regions(lights, targets, False, 2 * N), regions(lights, targets, True)
    # a region at the rim of a spread that either sort may have missed: the flux of a few photons
    floor = 5.0 * lights.flux[0, 0] / N
    assert_same([x[1:] for x in whole], [x[1:] for x in aimed], floor=floor)
    assert aimed[0][0] <= 0.15 * whole[0][0] + floor, "aimed photons should rarely pass all targets by"


@pytest.mark.parametrize("name", ["sphere", "soft point", "soft spot", "square", "sun disk", "mesh"])
def test_targets_that_touch_or_contain_the_light(name):
    center = np.array([[0.6, -0.4, 1.9], [0.3, 0.0, 1.0], [0.0, 0.2, 0.0]])
    lights = SINGLE[name]()
    targets = build_targets(lights, center, np.array([0.5, 0.45, 0.2]))
    assert_same(
        [x[1:] for x in regions(lights, targets, False, 2 * N)],
        [x[1:] for x in regions(lights, targets, True, 2 * N)],
        floor=5.0 * lights.flux[0, 0] / (2 * N),
    )


def test_a_small_glass_in_a_big_room_gets_its_photons():
    """Aimed photons reach a target of 2e-5 of all directions with a relative error of 2%."""
    lights = table([lamp("POINT", radius=0.3)])
    targets = build_targets(lights, np.array([[0.0, 0.0, 0.0]]), np.array([0.02]))
    mean, error = regions(lights, targets, True, 20_000)
    assert error[1] / mean[1] < 0.02
    assert mean[0] < 0.3 * mean[1], "most photons hit"


@pytest.mark.parametrize("name", ["sun disk", "mesh"])
def test_a_line_that_rounding_puts_beside_its_target_is_black(name):
    """A target of a nanometre a metre off; lines through the very rim of its disk."""
    lights = SINGLE[name]()
    targets = build_targets(lights, np.array([[1.0, 0.3, 0.2]]), np.array([1e-9]))
    rim = 1.0 - 1e-9
    flux = np.array([emit_aimed(lights, targets, 0, 0.5, *(rim, u, rim, u))[2] for u in np.linspace(0.0, 1.0, 400)])
    assert np.isfinite(flux).all()
    assert 0 < (flux.max(axis=1) > 0.0).sum() < 400, "some lines are beside it, some are not"


NARROW = {
    "laser": lamp("AREA", frame((0.2, 0.1, 2.0), (0.2, 0.0, 0.0)), size=(0.02, 0.02), spread=0.0),
    "searchlight": lamp("AREA", frame((0.2, 0.1, 2.0)), size=(0.1, 0.1), spread=0.02),
    "needle spot": lamp("SPOT", frame((0.2, 0.1, 2.0)), spot_size=0.02, spot_blend=0.5),
    "soft needle spot": lamp("SPOT", frame((0.2, 0.1, 2.0)), spot_size=0.02, spot_blend=0.5, radius=0.05),
}


@pytest.mark.parametrize("name", NARROW)
def test_a_beam_narrower_than_its_target_brings_all_its_flux(name):
    """By few photons: drawn from the target's sphere, one in a thousand would start within the beam."""
    lights = table([NARROW[name]])
    targets = build_targets(lights, CENTERS * 0.5, RADII * 2.0)
    mean, error = regions(lights, targets, True, 4000)
    whole, spread = regions(lights, targets, False, 40_000)
    assert_same([x[1:] for x in (whole, spread)], [x[1:] for x in (mean, error)], floor=1e-3 * lights.flux[0, 0])
    assert mean[1:].sum() == pytest.approx(whole[1:].sum(), rel=0.05)
    assert np.sqrt((error[1:] ** 2).sum()) < 0.05 * mean[1:].sum()


def test_a_beam_that_misses_all_targets_has_no_flux_into_them():
    away = lamp("AREA", frame((0.2, 3.0, 2.0), (0.2, 3.0, 0.0)), size=(0.02, 0.02), spread=0.0)
    assert not build_targets(table([away, NARROW["laser"]]), CENTERS, RADII).flux[0].any()


def test_light_choice_follows_the_flux_into_the_targets():
    lights = table([LAMPS["point"], LAMPS["square"], LAMPS["sun"]], EMITTERS, WORLD)
    targets = build_targets(lights, CENTERS, RADII)
    share = np.diff(targets.aimed_cdf, prepend=0.0)
    flux = targets.flux.sum(1)
    assert share == pytest.approx(0.95 * flux / flux.sum() + 0.05 / 5)
    assert targets.aimed_cdf[-1] == 1.0 and np.all(targets.pick[:, -1] == 1.0)


def test_estimated_flux_is_that_of_photons():
    for name in ("point", "square", "sun disk", "world", "mesh"):
        lights = SINGLE[name]()
        targets = build_targets(lights, CENTERS[2:], RADII[2:])
        phi = np.array([emit_aimed(lights, targets, 0, *u)[2] for u in uniform(4000, 5, 3)]) @ [0.2126, 0.7152, 0.0722]
        assert targets.flux[0, 0] == pytest.approx(phi.mean(), rel=0.03), "256 spread-out photons, and 4000 random ones"


def test_no_lights_and_no_targets():
    assert len(build_targets(table(), CENTERS, RADII).aimed_cdf) == 0
    assert len(build_targets(SINGLE["point"](), np.zeros((0, 3)), np.zeros(0)).radius) == 0


@pytest.mark.parametrize("n", [1, 2, 16, 17, 64, 1000])
def test_merged_spheres_contain_all(n):
    rng = np.random.default_rng(n)
    center, radius = rng.normal(size=(n, 3)), rng.uniform(0.0, 0.2, n)
    c, r = merge_spheres(center, radius)
    assert len(r) <= min(n, MAX_TARGETS)
    d = np.linalg.norm(center[:, None] - c[None], axis=2) + radius[:, None]
    assert np.all((d <= r[None] * (1 + 1e-9)).any(axis=1))


def test_distant_clusters_stay_apart():
    """Two groups far from each other must not become one sphere."""
    rng = np.random.default_rng(1)
    center = np.concatenate([rng.normal(0.0, 1.0, (40, 3)), rng.normal((100.0, 0.0, 0.0), 1.0, (40, 3))])
    _, r = merge_spheres(center, np.full(80, 0.1))
    assert r.max() < 6.0


def test_a_sphere_inside_another_is_dropped():
    c, r = merge_spheres(np.array([[0.0, 0, 0], [0.1, 0, 0]]), np.array([1.0, 0.2]))
    assert len(r) == 1 and r[0] == 1.0 and np.all(c == 0.0)


def test_pilot_numbers_are_spread():
    x = pilot_numbers(256)
    assert x.shape == (256, 4) and x.min() >= 0.0 and x.max() < 1.0
    for k in range(4):
        assert np.histogram(x[:, k], bins=16, range=(0, 1))[0].min() == 16
    assert math.isclose(x.mean(), 0.5, abs_tol=0.01)


def test_a_lamp_that_shines_away_from_all_targets():
    """Its flux into them is 0: its photons, few as they are, go to all evenly."""
    away = lamp("SPOT", frame((0.0, 0.0, 3.0), (0.0, 0.0, 9.0)), radius=0.01, spot_size=0.3)
    for lights in (table([away]), table([away, LAMPS["point"]])):
        targets = build_targets(lights, CENTERS, RADII)
        np.testing.assert_allclose(targets.pick[0], [1 / 3, 2 / 3, 1.0])
        assert np.isfinite(targets.aimed_cdf).all() and targets.aimed_cdf[-1] == 1.0
    assert targets.aimed_cdf[0] < 0.03, "only its share of the floor"
