"""Sobol's sequence: the numbers that scipy gives."""

import numpy as np
import pytest
from scipy.stats import qmc

from ..sobol import DIMENSIONS, sobol


@pytest.mark.parametrize("seed", [None, 0, 7])
@pytest.mark.parametrize("dimensions", range(1, DIMENSIONS + 1))
def test_the_same_points_as_scipys(dimensions, seed):
    expected = qmc.Sobol(dimensions, scramble=seed is not None, bits=32, rng=seed).random_base2(10)
    np.testing.assert_array_equal(sobol(1024, dimensions, seed), (expected * 2.0**32).astype(np.uint32))
    np.testing.assert_array_equal(sobol(700, dimensions, seed), sobol(1024, dimensions, seed)[:700])


def test_few_points():
    assert sobol(0, 3).shape == (0, 3) and (sobol(1, 3) == 0).all()
