"""Rates of whole passes."""

import numpy as np
import pytest

from ...film.passes import LIGHT_NAMES
from ...issues import IssueLog
from ...settings import Settings
from ..renderer import Renderer
from .plan_scenes import scene

PASSES = 256
RUNS = (1, 4, 16)  # passes


def test_noise_of_every_component_falls_as_the_root_of_the_passes():
    """Means of 1, 4 and 16 passes; of 16 there are 16, for 144 pixels that share photons: exponents to about 0.02.

    Passes that were not independent, whose evenly spread numbers were carried from one to the next, would show here.
    """
    settings = Settings(caustic_photons=300, diffuse_photons=300, light_samples=1, threads=1, seed=5, alpha=1.0)
    renderer = Renderer(scene(wall="Glow", sky=0.5), settings, IssueLog())
    renderer.prepare(lambda _text: None)
    pictures = [renderer.render_pass(i, lambda: False) for i in range(PASSES)]
    renderer.close()
    parts = {name: np.array([picture[name] for picture in pictures], float) for name in LIGHT_NAMES}
    parts["Combined"] = sum(parts.values())
    for name, one in parts.items():
        spread = [
            np.sqrt(one.reshape(PASSES // n, n, *one.shape[1:]).mean(axis=1).var(axis=0, ddof=1).mean()) for n in RUNS
        ]
        assert spread[0] > 0.0, name
        assert np.polyfit(np.log(RUNS), np.log(spread), 1)[0] == pytest.approx(-0.5, abs=0.05), name
