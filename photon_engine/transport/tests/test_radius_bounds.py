"""Bounds of the radius, and passes whose photons are traced in groups."""

import os

import numpy as np
import pytest

from ...issues import IssueLog
from ...settings import Settings
from .. import renderer as module
from ..pilot import DIFFUSE_LEAST, DIFFUSE_NEIGHBOURS, FULL, PILOT_PHOTONS, Reach, _reach
from ..renderer import Renderer, parts
from .plan_scenes import scene

PASSES = 24


def test_least_and_bound_hold_the_photons_that_they_promise():
    """Photons all over a square: a pass of eight times the pilot's has eight times the density."""
    rng = np.random.default_rng(3)
    photons = np.zeros((20_000, 3))
    photons[:, :2] = rng.random((20_000, 2))
    total = 8 * PILOT_PHOTONS
    reach = _reach(photons, (DIFFUSE_LEAST, DIFFUSE_NEIGHBOURS), total, 1.0)
    density = 8 * 20_000
    # the 8th neighbour's distance has a deviation of 1 / sqrt(8) / 2; 5%: its median's, and that of 1000 probes
    assert np.pi * reach.least**2 * density == pytest.approx(DIFFUSE_LEAST, rel=0.1)
    assert np.pi * reach.bound**2 * density == pytest.approx(DIFFUSE_NEIGHBOURS, rel=0.1)
    assert reach.stored == pytest.approx(20_000 / PILOT_PHOTONS)
    few, full = (_reach(photons, (DIFFUSE_LEAST, DIFFUSE_NEIGHBOURS), n, 1.0) for n in (FULL // 100, FULL))
    assert few.least == pytest.approx(full.least) and few.bound == pytest.approx(10.0 * full.bound)


def test_too_few_photons_leave_the_radius_to_the_pixels():
    for n in (0, 1):
        assert _reach(np.zeros((n, 3)), (8.0, 60.0), 1000, 5.0) == Reach(0.0, 5.0, n / PILOT_PHOTONS)
    few = _reach(np.random.default_rng(1).random((6, 3)), (8.0, 60.0), 1000, 5.0)
    assert 0.0 < few.least < 1e-5 < few.bound, "six photons bound the radius, but tell no density"


def test_photons_all_in_one_place_have_a_radius():
    for at, size in ((0.0, 5.0), (1.0, 1.0), (9.0, 5.0)):  # of the scene, or nearer where they are
        reach = _reach(np.full((1000, 3), at), (8.0, 60.0), 1000, 5.0)
        assert reach.least == reach.bound == pytest.approx(1e-6 * size)


def test_groups_follow_memory():
    assert parts(0, 0.0) == parts(100_000, 8.0) == parts(module.MOST_PHOTONS, 1.0) == 1
    assert parts(100_000_000, 0.0) == 24
    assert parts(module.MOST_PHOTONS, 6.0) == 3


def render(gather: str, diffuse: int = 30_000, passes: int = 6, **surfaces):
    """Passes of a scene, and the statistics."""
    options = {"caustic_photons": 30_000, "diffuse_photons": diffuse, "threads": os.cpu_count(), "final_gather": gather}
    renderer = Renderer(scene(lamps=("Bulb",), **surfaces), Settings(**options), IssueLog())
    try:
        renderer.prepare(lambda text: None)
        images = [renderer.render_pass(i, lambda: False) for i in range(passes)]
        return images, renderer.statistics
    finally:
        renderer.close()


@pytest.mark.parametrize("gather", ["GLOSSY", "ALL"])
def test_groups_make_the_same_picture_in_less_memory(monkeypatch, gather):
    """Three groups have a third of the photons in memory, and the mean of the same picture within its noise."""
    whole, one = render(gather)
    monkeypatch.setattr(module, "MOST_PHOTONS", 10_000)
    split, three = render(gather)
    assert three["map_bytes"] < 0.5 * one["map_bytes"]
    for name in ("caustic", "diffuse"):
        assert three["photons"][name] == pytest.approx(one["photons"][name], rel=0.03)
        assert np.allclose(three["flux"][name], one["flux"][name], rtol=0.02, atol=1e-3 * one["flux"][name].max())
    for name in ("Direct", "Emission", "Alpha", "Depth", "Normal", "Albedo"):
        assert np.array_equal(whole[0][name], split[0][name]), name
    for name in ("Caustic", "Diffuse"):
        a, b = (np.array([image[name].mean() for image in images]) for images in (whole, split))
        assert a.mean() > 0.0
        assert abs(a.mean() - b.mean()) < 4.0 * np.hypot(a.std(), b.std()) / np.sqrt(5) + 0.005 * a.mean(), name


def test_groups_for_one_map_alone_leave_what_rays_of_a_gather_find(monkeypatch):
    """Rays that land on a narrow lobe read both maps, and lamps: once each, however many groups one of the maps has."""
    surfaces = {"wall": "Polished"}
    whole, _ = render("ALL", 10_000, PASSES, **surfaces)
    monkeypatch.setattr(module, "MOST_PHOTONS", 10_000)
    split, _ = render("ALL", 10_000, PASSES, **surfaces)
    a, b = (np.array([image["Diffuse"].mean() for image in images]) for images in (whole, split))
    error = (a - b).std(ddof=1) / PASSES**0.5  # the eye paths are the same, which is most of the noise
    assert error < 0.02 * a.mean(), "found 0.004; where some groups count lamps again it is 0.6"
    assert abs(a.mean() - b.mean()) < 4.0 * error
