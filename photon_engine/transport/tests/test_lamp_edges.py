"""Further paths where a lamp begins or ends: the same mean with a fraction of the noise, and nothing else changes."""

from types import SimpleNamespace

import numpy as np
import pytest

from ...issues import IssueLog
from ...settings import Settings
from ..eye_pass import no_images
from ..lamp_edges import MOST_FURTHER, at_edge, find_images
from ..renderer import Renderer
from .plan_scenes import scene

PASSES = 64
FEW = {"caustic_photons": 64, "diffuse_photons": 64, "light_samples": 1, "threads": 1, "seed": 3}


def prepared(**values):
    """A renderer of a glowing floor, seen past its corners and through a pane of glass."""
    data = scene("Glow", "Mirror", "Glass", lamps=())
    data.camera.window = (-0.6, 0.6, -0.6, 0.6)
    renderer = Renderer(data, Settings(**{**FEW, **values}), IssueLog())
    renderer.prepare(lambda _text: None)
    return renderer


def passes(renderer, name="Emission", count=PASSES):
    """Pictures (passes, pixels, 3)."""
    return np.array([renderer.render_pass(i, lambda: False)[name].reshape(-1, 3) for i in range(count)], float)


def test_edges_lie_around_what_differs():
    picture = np.zeros((5, 6))
    picture[2:, 3:] = 1.0
    expected = np.zeros((5, 6), bool)
    expected[1:, 2:] = True
    expected[3:, 4:] = False
    assert (at_edge(picture) == expected).all()
    assert not at_edge(np.zeros((3, 3))).any() and not at_edge(np.full((3, 3), 7.0)).any()


def test_mean_is_the_same_and_noise_far_less():
    with_edges, plain = prepared(), prepared()
    mask, further, _ = with_edges.lamp_images
    assert 0.1 < mask.mean() < 0.9 and further >= 1
    plain.lamp_images = no_images(len(mask))
    a, b = passes(with_edges), passes(plain)
    assert (a[:, ~mask] == b[:, ~mask]).all()
    noise_a, noise_b = a[:, mask].var(axis=0, ddof=1), b[:, mask].var(axis=0, ddof=1)
    # n even samples have less than 1 / n of the variance of one
    assert noise_a.sum() < 1.2 * noise_b.sum() / (1 + further)
    gap = a[:, mask].sum(axis=(1, 2)) - b[:, mask].sum(axis=(1, 2))
    assert abs(gap.mean()) < 3.5 * gap.std(ddof=1) / PASSES**0.5
    other = passes(with_edges, "Direct", 2), passes(plain, "Direct", 2)
    assert (other[0] == other[1]).all()
    with_edges.close()
    plain.close()


def test_choice_follows_the_seed_alone_and_the_cost_is_bounded():
    renderer = prepared()
    again, further, _ = find_images(renderer.scene, renderer._pool, renderer.settings, lambda: False)
    assert (again == renderer.lamp_images.edges).all() and further == renderer.lamp_images.further
    assert again.sum() * further <= 0.5 * again.size and further <= MOST_FURTHER
    renderer.close()


@pytest.mark.parametrize("runs", [True, False])
def test_nothing_is_looked_for_where_no_emission_is_asked_for(runs):
    renderer = prepared()
    blind = SimpleNamespace(frame=renderer.scene.frame, plan=SimpleNamespace(emission=SimpleNamespace(runs=False)))
    mask, further, _ = find_images(renderer.scene if runs else blind, renderer._pool, renderer.settings, lambda: False)
    assert mask.any() == runs and (further > 0) == runs
    renderer.close()

