import math

import numpy as np
import pytest

from ..mis import balance_heuristic, power_heuristic


@pytest.mark.parametrize("heuristic", [power_heuristic, balance_heuristic])
def test_weights_of_both_samplers_add_up_to_one(heuristic):
    for a, b in np.random.default_rng(1).lognormal(0.0, 20.0, (1000, 2)):
        assert heuristic(a, b) + heuristic(b, a) == pytest.approx(1.0, abs=1e-12)


def test_limits():
    assert power_heuristic(math.inf, 3.0) == 1.0
    assert power_heuristic(3.0, math.inf) == 0.0
    assert power_heuristic(0.0, 3.0) == 0.0
    assert power_heuristic(2.0, 1.0) == pytest.approx(0.8)
    assert balance_heuristic(3.0, 1.0) == pytest.approx(0.75)
    assert power_heuristic(1e200, 1e200) == 0.5, "squares must not overflow"
