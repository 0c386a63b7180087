"""Textures at places where coordinates have no digits left."""

import numpy as np
import pytest

from ..procedural import perlin, voronoi

FAR = [3e6, 1e12, 1e20, 1e30]


@pytest.mark.parametrize("far", FAR)
@pytest.mark.parametrize("dims", [1, 2, 3, 4])
def test_noise_is_bounded_far_away(dims, far):
    """Whole numbers of cells were counted in 64 bits: from 1e19 cells on, noise was not finite."""
    rng = np.random.default_rng(dims)
    values = [perlin.snoise(dims, tuple(far * rng.uniform(-1.0, 1.0, 4))) for _ in range(200)]
    assert np.isfinite(values).all() and np.abs(values).max() <= 1.0
    assert np.std(values) > 0.01  # still noise


@pytest.mark.parametrize("far", FAR)
def test_cells_are_near_far_away(far):
    """The nearest point of a Voronoi texture is in the place's own cell or beside it."""
    law = (3, 3, voronoi.EUCLIDEAN, 0.5, 1.0)
    for p in far * np.random.default_rng(1).uniform(-1.0, 1.0, (50, 4)):
        _, best, *_ = voronoi.nearest(law, tuple(p))
        assert 0.0 <= best < 2.0
