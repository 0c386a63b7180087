"""More rays from narrow lobes: the same mean with far less noise, and no more rays from others."""

import numpy as np
import pytest

from ...issues import IssueLog
from ...settings import Settings
from .. import renderer as module
from .plan_scenes import scene

PASSES = 96
FEW = {"caustic_photons": 64, "diffuse_photons": 2000, "threads": 1, "seed": 3}


def passes(most, monkeypatch, **surfaces):
    """Direct + Diffuse (passes, pixels, 3) of a scene, and how many rays the eye passes took."""
    monkeypatch.setattr(module, "MOST_LOBE_RAYS", most)
    renderer = module.Renderer(scene(**surfaces), Settings(**FEW), IssueLog())
    renderer.prepare(lambda _text: None)
    found = [renderer.render_pass(i, lambda: False) for i in range(PASSES)]
    rays = renderer.statistics["rays"]["eye"]
    renderer.close()
    return np.array([(p["Direct"] + p["Diffuse"]).reshape(-1, 3) for p in found], float), rays


@pytest.mark.parametrize(
    ("surfaces", "least"),
    [
        # half of a rough mirror's light is found by the four shadow rays as before
        ({"floor": "Polished", "wall": "Black", "lamps": (), "sky": 1.0}, 0.75),
        ({"floor": "Frosted", "wall": "Glow", "lamps": ()}, 0.45),
    ],
)
def test_mean_is_the_same_and_noise_far_less(surfaces, least, monkeypatch):
    (four, _), (one, _) = (passes(most, monkeypatch, pane="Clear", **surfaces) for most in (4, 1))
    assert four.var(axis=0, ddof=1).sum() < least * one.var(axis=0, ddof=1).sum()  # found: 0.58 and 0.28
    gap = (four - one).sum(axis=(1, 2))
    error = gap.std(ddof=1) / PASSES**0.5
    assert abs(gap.mean()) < 3.5 * error and error < 0.08 * one.sum(axis=(1, 2)).mean()


def test_wide_lobes_send_one(monkeypatch):
    surfaces = {"floor": "Satin", "pane": "Clear", "lamps": ("Area",), "sky": 0.3}
    assert passes(4, monkeypatch, **surfaces)[1] == passes(1, monkeypatch, **surfaces)[1]
