import numpy as np
import pytest
from scipy import stats

from ...jit import kernel
from ..aperture import sample_aperture

SAMPLES = 100_000
SIGNIFICANCE = 1e-4 / 6  # of all cases together one failure in ten thousand seeds


@kernel
def sample_many(blades, rotation, inv_ratio, u, out):
    """One lens point for each pair of numbers."""
    for i in range(len(u)):
        out[i, 0], out[i, 1] = sample_aperture(blades, rotation, inv_ratio, u[i, 0], u[i, 1])


def lens_points(blades, rotation=0.0, ratio=1.0, n=SAMPLES):
    out = np.empty((n, 2))
    sample_many(blades, rotation, 1.0 / ratio, np.random.default_rng(3).random((n, 2)), out)
    return out


def inside(points, blades, rotation):
    """Whether points lie in the aperture: the disk, or within the apothem of every side of the polygon."""
    if blades < 3:
        return np.hypot(*points.T) <= 1.0 + 1e-12
    middles = rotation + 2.0 * np.pi * np.arange(blades) / blades
    heights = points @ np.stack([np.cos(middles), np.sin(middles)])
    return (heights <= np.cos(np.pi / blades) + 1e-12).all(axis=1)


@pytest.mark.parametrize(("blades", "rotation", "ratio"), [
    (0, 0.0, 1.0), (0, 0.0, 2.0), (3, 0.0, 1.0), (5, 0.7, 1.0), (6, 0.2, 0.5), (9, 2.0, 1.0),
])  # fmt: skip
def test_lens_points_are_uniform(blades, rotation, ratio):
    points = lens_points(blades, rotation, ratio) * (ratio, 1.0)
    assert inside(points, blades, rotation).all()
    cells = 16
    edges = np.linspace(-1.0, 1.0, cells + 1)
    observed = np.histogram2d(*points.T, bins=(edges, edges))[0].ravel()
    # area of the aperture in each cell by 32 x 32 midpoints
    grid = -1.0 + (np.arange(cells * 32) + 0.5) / (cells * 16)
    mask = inside(np.stack(np.meshgrid(grid, grid, indexing="ij"), -1).reshape(-1, 2), blades, rotation)
    area = mask.reshape(cells, 32, cells, 32).sum(axis=(1, 3)).ravel()
    whole = area == 32 * 32  # cells on the rim are known to 3% only: too coarse for the test
    expected = observed[whole].sum() / whole.sum()
    assert stats.chisquare(observed[whole], np.full(whole.sum(), expected)).pvalue > SIGNIFICANCE
    # all of the aperture is reached: the share of whole cells is their share of its area
    exact = np.pi if blades < 3 else 0.5 * blades * np.sin(2.0 * np.pi / blades)
    share = whole.sum() * (2.0 / cells) ** 2 / exact
    sigma = np.sqrt(share * (1.0 - share) / SAMPLES)
    assert observed[whole].sum() / SAMPLES == pytest.approx(share, abs=4.0 * sigma)


def test_corners_lie_where_blades_and_rotation_say():
    points = lens_points(4, 0.3)
    corners = 0.3 + np.pi / 4.0 * np.array([1, 3, 5, 7])
    far = points[np.hypot(*points.T) > 0.97]
    angle = np.arctan2(far[:, 1], far[:, 0])
    off = np.abs(np.angle(np.exp(1j * (angle[:, None] - corners))))
    assert len(far) > 50
    # a point of a square at radius r is at most pi/4 - acos(cos(pi/4) / r) from a corner
    assert off.min(axis=1).max() < np.pi / 4.0 - np.arccos(np.cos(np.pi / 4.0) / 0.97)


def test_ratio_squeezes_horizontally():
    points = lens_points(0, ratio=2.0)
    assert np.abs(points[:, 0]).max() == pytest.approx(0.5, abs=2e-3)  # 100 000 points reach the rim within 1e-3
    assert np.abs(points[:, 1]).max() == pytest.approx(1.0, abs=2e-3)
