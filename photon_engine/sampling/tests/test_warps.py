"""Every warp against its density."""

import math

import numpy as np
import pytest

from .. import warps
from .chi2 import least, p_value

N = 200_000
BINS = 24

RECTANGLES = [
    (-1.0, 1.0, -1.0, 1.0, 1.0),
    (0.5, 3.0, -2.0, -1.0, 0.2),
    (2.0, 9.0, 3.0, 4.0, 5.0),
    (-0.1, 2.0, -3.0, 0.01, 0.05),
]


def numbers(seed=7, n=N):
    return np.random.default_rng(seed).random((n, 2))


def counts(xy, low, high):
    edges = [np.linspace(low[k], high[k], BINS + 1) for k in range(2)]
    found, _, _ = np.histogram2d(*np.asarray(xy).T, bins=edges)
    assert found.sum() == len(xy), "samples outside the domain"
    return found


def expected(density, low, high, n=N, fine=16):
    """Counts from a density over [low, high], by midpoints."""
    x, y = ((np.arange(BINS * fine) + 0.5) / (BINS * fine) * (high[k] - low[k]) + low[k] for k in range(2))
    values = np.array([[density(a, b) for b in y] for a in x])
    cell = (high[0] - low[0]) * (high[1] - low[1]) / (BINS * fine) ** 2
    return n * cell * values.reshape(BINS, fine, BINS, fine).sum((1, 3))


# name -> (sample to (x, y), density of (x, y), low, high); directions as (cos theta, phi): area is solid angle
def polar(direction):
    return direction[2], math.atan2(direction[1], direction[0])


CASES = {
    "disk": (warps.square_to_disk, warps.disk_pdf, (-1, -1), (1, 1)),
    "triangle": (warps.square_to_triangle, warps.triangle_pdf, (0, 0), (1, 1)),
    "sphere": (
        lambda u, v: polar(warps.square_to_sphere(u, v)),
        lambda c, phi: warps.sphere_pdf(),
        (-1, -math.pi),
        (1, math.pi),
    ),
    "cosine hemisphere": (
        lambda u, v: polar(warps.square_to_cosine_hemisphere(u, v)),
        lambda c, phi: warps.cosine_hemisphere_pdf(c),
        (0, -math.pi),
        (1, math.pi),
    ),
    "cone": (
        lambda u, v: polar(warps.square_to_cone(u, v, 0.3)),
        lambda c, phi: warps.cone_pdf(1.0 - c, 0.3),
        (0.7, -math.pi),
        (1, math.pi),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_samples_follow_the_density(name):
    warp, density, low, high = CASES[name]
    fine = 64 if name in ("disk", "triangle") else 16  # bins cut by a border need it
    assert p_value(
        counts([warp(u, v) for u, v in numbers()], low, high), expected(density, low, high, fine=fine)
    ) > least(9)


@pytest.mark.parametrize("rect", RECTANGLES)
def test_rectangle_is_sampled_uniformly_in_solid_angle(rect):
    x0, x1, y0, y1, h = rect
    total = warps.rectangle_solid_angle(*rect)
    found = counts([warps.square_to_rectangle_w(u, v, *rect) for u, v in numbers()], (x0, y0), (x1, y1))
    x, y = np.linspace(x0, x1, BINS + 1), np.linspace(y0, y1, BINS + 1)
    share = [[warps.rectangle_solid_angle(x[i], x[i + 1], y[j], y[j + 1], h) for j in range(BINS)] for i in range(BINS)]
    assert np.sum(share) == pytest.approx(total, rel=1e-9)
    assert p_value(found, N * np.array(share) / total) > least(9)


@pytest.mark.parametrize("rect", RECTANGLES)
def test_rectangle_solid_angle_is_the_integral_of_its_definition(rect):
    x0, x1, y0, y1, h = rect
    n = 1000
    x = x0 + (np.arange(n) + 0.5) / n * (x1 - x0)
    y = (y0 + (np.arange(n) + 0.5) / n * (y1 - y0))[:, None]
    integral = (h / (x * x + y * y + h * h) ** 1.5).mean() * (x1 - x0) * (y1 - y0)
    assert warps.rectangle_solid_angle(*rect) == pytest.approx(integral, rel=1e-4)  # midpoint rule, 1000 steps


def test_tiny_rectangle_keeps_its_digits():
    """a b h / d^3 when it is small; the sum of four angles minus 2 pi would hold no digit of 1e-12 sr."""
    omega = warps.rectangle_solid_angle(1.0, 1.000001, 2.0, 2.000001, 2.0)
    assert omega == pytest.approx(1e-12 * 2.0 / 9.0**1.5, rel=1e-3)


def test_one_minus_cos_of_a_tiny_angle():
    assert warps.one_minus_cos(1e-20) == pytest.approx(0.5e-20, rel=1e-12)
    assert warps.one_minus_cos(0.75) == pytest.approx(0.5)
    assert warps.one_minus_cos(1.0) == 1.0


def test_corners_of_the_square_stay_inside():
    for u in (0.0, 0.5, 1.0 - 2.0**-53):
        for v in (0.0, 0.5, 1.0 - 2.0**-53):
            for d in (
                warps.square_to_sphere(u, v),
                warps.square_to_cosine_hemisphere(u, v),
                warps.square_to_cone(u, v, 1e-9),
            ):
                assert sum(x * x for x in d) == pytest.approx(1.0, abs=1e-12)
            for rect in RECTANGLES:
                x, y = warps.square_to_rectangle_w(u, v, *rect)
                assert rect[0] <= x <= rect[1] and rect[2] <= y <= rect[3]
