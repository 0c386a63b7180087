"""Several paths a pixel in a pass, evenly spread: the same mean, less noise than as many passes, and when they pay."""

import numpy as np
import pytest

from ...film.passes import BACKGROUND_DEPTH
from ...issues import IssueLog
from ...plan import FEWEST_PIXELS, camera_paths
from ...settings import Settings
from ..renderer import Renderer
from .plan_scenes import scene

PASSES = 48
EVEN = {"caustic_photons": 100_000, "diffuse_photons": 100_000}
FEW = {"caustic_photons": 64, "diffuse_photons": 64, "light_samples": 1, "threads": 1, "seed": 3}


def passes(count, **values):
    """Direct (passes, 12, 12, 3) of a floor and a wall under a lamp."""
    renderer = Renderer(scene(pane="Matte"), Settings(**{**FEW, **values}), IssueLog())
    renderer.prepare(lambda _text: None)
    found = np.array([renderer.render_pass(i, lambda: False)["Direct"] for i in range(count)], float)
    renderer.close()
    return found


def test_mean_is_the_same_and_noise_less_than_of_as_many_passes():
    one, four = passes(2 * PASSES, eye_samples=1), passes(PASSES, eye_samples=4)
    assert four.var(axis=0, ddof=1).sum() < 0.6 * one.var(axis=0, ddof=1).sum() / 4.0
    gap = one.mean(axis=0) - four.mean(axis=0)
    error = np.sqrt(one.sum(axis=(1, 2, 3)).var(ddof=1) / len(one) + four.sum(axis=(1, 2, 3)).var(ddof=1) / len(four))
    assert abs(gap.sum()) < 3.5 * error and error < 0.01 * one.sum(axis=(1, 2, 3)).mean()


def test_noise_of_neighbours_cancels():
    """Means over 4 x 4 pixels have less variance than independent pixels would leave them (found: 0.63 of it)."""
    found = passes(2 * PASSES, eye_samples=1)
    blocks = found.reshape(2 * PASSES, 3, 4, 3, 4, 3).mean(axis=(2, 4))
    assert 16.0 * blocks.var(axis=0, ddof=1).mean() < 0.8 * found.var(axis=0, ddof=1).mean()


def test_depth_is_of_one_path():
    """At the rim of the floor a pixel is as deep as the floor or as the background, as in Cycles, not in between."""
    renderer = Renderer(scene(pane="Matte"), Settings(**FEW, eye_samples=4), IssueLog())
    renderer.prepare(lambda _text: None)
    picture = renderer.render_pass(0, lambda: False)
    renderer.close()
    depth = picture["Depth"]
    assert (depth == BACKGROUND_DEPTH).any() and depth.min() < 4.01
    assert ((depth == BACKGROUND_DEPTH) | (depth < 4.01)).all()


@pytest.mark.parametrize(
    ("values", "side", "count", "why"),
    [
        ({"eye_samples": 3}, 12, 3, "Camera Paths is 3"),
        ({"eye_samples": 1}, 128, 1, "Camera Paths is 1"),
        (EVEN, 128, 4, "12 photons a pixel"),
        (EVEN, 180, 2, "6.2 photons a pixel"),
        (EVEN, 256, 1, "3.1 photons a pixel"),
        (EVEN, 12, 1, "few pixels"),
        ({"caustic_photons": 0, "diffuse_photons": 0}, 128, 1, "0 photons a pixel"),
    ],
)
def test_paths_follow_from_photons_and_pixels(values, side, count, why):
    data = scene()
    data.frame.x1 = data.frame.y1 = data.frame.width = data.frame.height = side
    assert 90**2 < FEWEST_PIXELS <= 100**2
    decided = camera_paths(data, Settings(**values))
    assert (decided.count, bool(decided)) == (count, count > 1) and why in decided.reason
