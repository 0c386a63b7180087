"""Light samples of a visible point taken together are those taken one by one."""

import numpy as np
import pytest

from .. import eye_pass
from .plan_scenes import scene
from .test_plan import render


@pytest.mark.parametrize("walls", [("Painted", "Plastic", "Plastic"), ("Painted", "Half", "Plastic")])
def test_samples_taken_together_are_those_taken_one_by_one(walls, monkeypatch):
    """Opaque and see-through shadows, six samples: four and two together."""
    pictures = []
    for together in (1, eye_pass.SAMPLES_AT_ONCE):
        monkeypatch.setattr(eye_pass, "SAMPLES_AT_ONCE", together)
        pictures.append(
            render(scene(*walls, lamps=["Spot", "Bulb"], sky=0.5), {"Direct"}, light_samples=6)[0]["Direct"]
        )
    assert pictures[0].max() > 0.0
    # the same rays; only the order of sums differs where several points share a pixel
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=1e-5, atol=1e-7)
