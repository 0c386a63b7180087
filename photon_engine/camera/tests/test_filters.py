import itertools

import numpy as np
import pytest
from scipy import integrate, stats

from ...issues import RenderError
from ...jit import kernel
from ..filters import REACH, filter_position, filter_table, filter_value, sample_filter

SAMPLES = 200_000
CELLS = 64
# one failure in ten thousand runs of the six cases, were the seed not fixed
SIGNIFICANCE = 1e-4 / 6


@kernel
def sample_many(table, u, out):
    """One offset for each number."""
    for i in range(len(u)):
        out[i] = sample_filter(table, u[i])


def cell_probabilities(name, width, edges):
    """Integral of the normalised filter over each cell."""
    parts = [integrate.quad(lambda x: float(filter_value(name, x, width)), a, b)[0] for a, b in
             itertools.pairwise(edges)]  # fmt: skip
    return np.array(parts) / sum(parts)


@pytest.mark.parametrize("width", [0.7, 1.5])
@pytest.mark.parametrize("name", list(REACH))
def test_samples_follow_the_filter(name, width):
    u = np.random.default_rng(7).random(SAMPLES)
    x = np.empty(SAMPLES)
    sample_many(filter_table(name, width), u, x)
    reach = REACH[name] * width
    assert np.abs(x).max() <= reach
    edges = np.linspace(-reach, reach, CELLS + 1)
    expected = SAMPLES * cell_probabilities(name, width, edges)
    observed = np.histogram(x, edges)[0]
    big = expected >= 10.0  # the chi-squared approximation needs some counts in each cell
    observed = np.append(observed[big], observed[~big].sum())
    expected = np.append(expected[big], expected[~big].sum())
    keep = expected > 0.0
    assert stats.chisquare(observed[keep], expected[keep]).pvalue > SIGNIFICANCE


@pytest.mark.parametrize("name", list(REACH))
def test_the_map_is_odd_and_increasing(name):
    table = filter_table(name, 1.5)
    u = (np.arange(4000) + 0.5) / 4000
    x = np.empty_like(u)
    sample_many(table, u, x)
    assert (np.diff(x) > 0.0).all()
    np.testing.assert_allclose(x, -x[::-1], atol=1e-9)  # 1 - u is rounded, and the tails are steep


def test_blackman_harris_has_the_variance_of_its_window():
    # integral of x^2 over the window, from its cosine series: width^2 (1/3 + sum of 2 (-1)^k a_k / (a_0 (k pi)^2))
    a = (0.35875, 0.48829, 0.14128, 0.01168)
    width = 1.5
    # centred, the window is sum a_k cos(k pi x / width): all terms add up at the middle
    exact = width**2 * (1.0 / 3.0 + sum(2.0 * (-1) ** k * a[k] / (k * np.pi) ** 2 for k in (1, 2, 3)) / a[0])
    u = (np.arange(100_000) + 0.5) / 100_000
    x = np.empty_like(u)
    sample_many(filter_table("BLACKMAN_HARRIS", width), u, x)
    # 2e-4: linear interpolation of the inverse CDF in the tails, measured 3e-5
    assert x.var() == pytest.approx(exact, rel=2e-4)


def test_bad_filters_are_refused():
    with pytest.raises(RenderError, match="MITCHELL"):
        filter_table("MITCHELL", 1.5)
    with pytest.raises(RenderError, match="not positive"):
        filter_table("BOX", 0.0)


@pytest.mark.parametrize("name", list(REACH))
def test_positions_are_the_inverse_of_samples(name):
    table = filter_table(name, 1.5)
    u = np.random.default_rng(8).random(1000)
    x = np.empty(1000)
    sample_many(table, u, x)
    assert filter_position(table, x) == pytest.approx(u, abs=1e-12)
    assert filter_position(table, np.array([-9.0, 0.0, 9.0])).tolist() == [0.0, 0.5, 1.0]
