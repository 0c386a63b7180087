"""Counter-based numbers are uniform, and independent between paths, dimensions, passes, streams and seeds."""

import numpy as np
import pytest
from scipy import stats

from ...jit import kernel
from ..rng import path_key, stream_key, uniform


@kernel
def table(seed, iteration, stream, out):
    """out[path, dimension]."""
    key = stream_key(seed, iteration, stream)
    for i in range(out.shape[0]):
        k = path_key(key, i)
        for j in range(out.shape[1]):
            out[i, j] = uniform(k, j)


def numbers(seed, iteration, stream, paths=20_000, dimensions=12):
    """A table of numbers."""
    out = np.empty((paths, dimensions))
    table(seed, iteration, stream, out)
    return out


def test_uniform_in_every_dimension():
    """Kolmogorov-Smirnov, Sidak-corrected to a 1% false alarm over the twelve dimensions."""
    x = numbers(3, 1, 2)
    assert x.min() >= 0.0 and x.max() < 1.0
    worst = min(stats.kstest(x[:, j], "uniform").pvalue for j in range(x.shape[1]))
    assert worst > 1.0 - 0.99 ** (1.0 / x.shape[1])


@pytest.mark.parametrize("other", [(4, 1, 2), (3, 2, 2), (3, 1, 3)])
def test_keys_give_unrelated_numbers(other):
    """Correlation of 240000 pairs stays within 4.5 standard errors."""
    a, b = numbers(3, 1, 2).ravel(), numbers(*other).ravel()
    assert abs(np.corrcoef(a, b)[0, 1]) < 4.5 / np.sqrt(len(a))


def test_neighbouring_paths_and_dimensions_are_unrelated():
    """Lag-one correlation along both axes of the table."""
    x = numbers(0, 1, 0)
    for a, b in ((x[1:], x[:-1]), (x[:, 1:], x[:, :-1])):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 4.5 / np.sqrt(a.size)


def test_pairs_fill_the_square():
    """Chi-square over 32 x 32 cells of (dimension 0, dimension 1)."""
    x = numbers(1, 7, 1, 200_000, 2)
    counts = np.histogram2d(x[:, 0], x[:, 1], bins=32, range=[[0, 1], [0, 1]])[0]
    assert stats.chisquare(counts.ravel()).pvalue > 0.001
