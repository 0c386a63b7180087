"""Even numbers: squares of pixels fill the unit square, each pixel's numbers are uniform, keys are independent."""

import numpy as np
import pytest

from ..even import even_pair, morton
from ..rng import make_key

SIDE = 32


def numbers(key, which=0, x0=0):
    """(SIDE, SIDE, 2) of a square of pixels."""
    pixels = range(SIDE)
    return np.array([[even_pair(key, morton(x0 + x, y), which) for x in pixels] for y in pixels])


@pytest.mark.parametrize("which", [0, 3])
def test_every_square_has_one_number_in_each_of_its_equal_parts(which):
    points = numbers(make_key(1, 2, 3), which, 3 * SIDE)
    for k in (1, 2, 3, 4):
        n = 1 << k
        for y in range(0, SIDE, n):
            for x in range(0, SIDE, n):
                square = points[y : y + n, x : x + n].reshape(-1, 2)
                for a in range(2 * k + 1):  # parts of width 2^-a and height 2^(a - 2k)
                    cells = np.floor(square * [2**a, 2 ** (2 * k - a)]) @ [2 ** (2 * k - a), 1]
                    assert len(set(cells)) == n * n


def test_paths_of_one_pixel_are_such_a_square_too():
    key, place = make_key(4, 0, 3), morton(5, 9)
    four = np.array([even_pair(key, 4 * place + k, 1) for k in range(4)])
    assert len({(int(2 * u), int(2 * v)) for u, v in four}) == 4 and len(set(np.floor(4 * four[:, 0]))) == 4


def test_a_pixels_numbers_are_uniform_and_keys_and_sets_independent():
    place = morton(3, 1)
    found = np.array(
        [[*even_pair(key, place, 0), *even_pair(key, place, 1), *even_pair(key, place + 7, 0)]
         for key in (make_key(0, i, 3) for i in range(4000))]
    )  # fmt: skip
    assert ((found >= 0.0) & (found < 1.0)).all()
    for column in found.T:  # Kolmogorov and Smirnov's distance, 99.9% of uniform samples are below 1.95 / sqrt(n)
        assert np.abs(np.sort(column) - (np.arange(4000) + 0.5) / 4000).max() < 1.95 / 4000**0.5
    correlation = np.corrcoef(found.T)[np.triu_indices(6, 1)]
    assert np.abs(correlation).max() < 4.0 / 4000**0.5 + 0.02  # near pixels shun each other a little


def test_morton_fills_squares_one_after_another():
    places = np.array([[morton(x, y) for x in range(8)] for y in range(8)])
    assert sorted(places.ravel()) == list(range(64))
    assert sorted(places[2:4, 4:6].ravel()) == list(range(24, 28))
