"""The photon map finds every photon once; packing and the radius schedule keep their promises."""

import numpy as np
import pytest

from ..batch import Deposits
from ..map import build_map, cell_index, row_hash
from ..packing import body, pack_direction, pack_facet, unpack_direction, unpack_facet
from ..radius import neighbour_radius, radius_factor


def random_deposits(n, spread, seed=1):
    """Photons in a box of the given size around the origin."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(-spread, spread, (n, 3)).astype(np.float32)
    return Deposits(
        position,
        rng.random((n, 3)).astype(np.float32),
        np.arange(n, dtype=np.uint32),
        np.zeros(n, np.uint32),
        np.zeros(n, np.uint8),
    )


def found(photons, p, r):
    """Labels of photons within r of p, by walking the cells as the gather does."""
    cell = photons.cell
    mask = len(photons.start) - 2
    lo = [cell_index(x - r, cell) for x in p]
    hi = [cell_index(x + r, cell) for x in p]
    labels = []
    for iz in range(lo[2], hi[2] + 1):
        for iy in range(lo[1], hi[1] + 1):
            for ix in range(lo[0], hi[0] + 1):
                b = (row_hash(iy, iz) + ix) & mask
                for j in range(photons.start[b], photons.start[b + 1]):
                    q = photons.position[j].astype(float)
                    cells = [cell_index(x, cell) for x in q]
                    if cells == [ix, iy, iz] and ((q - p) ** 2).sum() < r * r:
                        labels.append(int(photons.wi[j]))
    return labels


@pytest.mark.parametrize("n, spread, cell", [(2000, 1.0, 0.2), (2000, 100.0, 3.0), (7, 1.0, 0.5), (500, 1e-3, 1e-4)])
def test_every_photon_is_found_once(n, spread, cell):
    """Against brute force, also where few buckets make cells collide (n = 7)."""
    deposits = random_deposits(n, spread)
    photons = build_map(deposits, cell)
    rng = np.random.default_rng(2)
    for p in rng.uniform(-spread, spread, (20, 3)):
        for r in (0.3 * cell, cell, 2.5 * cell):
            near = np.flatnonzero(((deposits.position.astype(float) - p) ** 2).sum(axis=1) < r * r)
            assert sorted(found(photons, p, r)) == near.tolist()


def test_a_stored_photon_takes_less_than_40_bytes():
    """For counts that suit and that do not suit a power of two."""
    for n in (1000, 1024, 2047, 100_000):
        assert build_map(random_deposits(n, 1.0), 0.1).nbytes() / n < 40.0


def test_packed_directions_are_close():
    """The stated errors of directions and of facets, over all octants and axes; a facet keeps its side and object."""
    rng = np.random.default_rng(3)
    v = rng.normal(size=(2000, 3))
    v = np.concatenate([v / np.linalg.norm(v, axis=1, keepdims=True), np.eye(3), -np.eye(3)])
    back = np.array([unpack_direction(pack_direction(tuple(x))) for x in v])
    assert np.linalg.norm(back - v, axis=1).max() < 7e-5
    for front, instance in ((False, 0), (True, 31), (True, 1000)):
        codes = [pack_facet(tuple(x), front, instance) for x in v]
        back = np.array([unpack_facet(code) for code in codes])
        assert np.linalg.norm(back / np.linalg.norm(back, axis=1, keepdims=True) - v, axis=1).max() < 6e-4
        assert {int(code) & 63 for code in codes} == {body(front, instance)}


def test_radius_schedule_is_the_recurrence():
    """r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1) [Knaus and Zwicker 2011], and never collapses."""
    for alpha in (0.3, 2.0 / 3.0, 1.0):
        square = 1.0
        for i in range(1, 1001):
            assert radius_factor(i, alpha) ** 2 == pytest.approx(square, rel=1e-9)
            square *= (i + alpha) / (i + 1)
    assert radius_factor(1000, 2.0 / 3.0) == pytest.approx(0.333, abs=0.001)


def test_neighbour_radius_against_sorting():
    """The k-th distance, of photons in a room's air and on two of its walls."""
    rng = np.random.default_rng(4)
    photons, points = rng.random((300, 3)), np.vstack([rng.random((10, 3)), [[-3.0, 0.0, 0.5], [9.0, 9.0, 9.0]]])
    photons[:100, 0], photons[100:200, 2] = 0.0, 1.0
    distance = np.sort(np.linalg.norm(photons[None] - points[:, None], axis=2), axis=1)
    assert np.allclose(neighbour_radius(photons, points, 7), distance[:, 6])
    assert np.isinf(neighbour_radius(photons[:3], points, 7)).all()
