"""Bodies that touch are kept apart by a hair, when one of them refracts."""

import numpy as np

from photon_engine.geometry.flatten import flatten
from photon_engine.geometry.touching import outward, spread_touching
from photon_engine.issues import IssueLog
from tests.brute import scenes as s

HAIR = 1e-4  # [m] more than any body of these scenes grows


def spread(parts, refracting):
    """World positions of each part before and after; refracting: of each part."""
    flat = flatten(s.build(parts), IssueLog())
    after = spread_touching(flat, np.array(refracting)[flat.geometry.material])
    before, now = (x.geometry.positions + x.origin for x in (flat, after))
    cuts = np.cumsum([len(mesh.positions) for mesh, _ in parts])[:-1]
    return list(zip(np.split(before, cuts), np.split(now, cuts), strict=True))


def glass_box(lo, hi):
    """A part."""
    return s.box(lo, hi), s.glass()


def test_second_of_two_blocks_grows_on_all_sides():
    (a, a2), (b, b2) = spread([glass_box((-1, -1, -1), (0, 1, 1)), glass_box((0, -1, -1), (1, 1, 1))], [True, True])
    assert np.array_equal(a, a2)
    grown = np.abs(b2 - (0.5, 0, 0)) - np.abs(b - (0.5, 0, 0))
    assert grown.min() > 0.0 and grown.max() < HAIR and np.allclose(grown, grown[0, 0], rtol=0.1)


def test_a_block_on_a_table_grows_and_the_table_stays():
    table = s.quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), s.diffuse()
    (a, a2), (_, b2) = spread([table, glass_box((-1, -1, 0), (1, 1, 1))], [False, True])
    assert np.array_equal(a, a2) and 0.0 < -b2[:, 2].min() < HAIR


def test_what_does_not_touch_or_refract_stays():
    apart = [glass_box((-1, -1, -1), (0, 1, 1)), glass_box((1e-3, -1, -1), (1, 1, 1))]
    touching = [glass_box((-1, -1, -1), (0, 1, 1)), glass_box((0, -1, -1), (1, 1, 1))]
    beside = [glass_box((-1, -1, -1), (0, 0, 0)), glass_box((0.5, 0.5, -1), (1, 1, 0))]  # planes in common, no place
    for parts, refracting in ((apart, [True, True]), (touching, [False, False]), (beside, [True, True])):
        for before, after in spread(parts, refracting):
            assert np.array_equal(before, after)


def test_a_corner_goes_as_far_as_its_faces_need():
    """Three faces at right angles each move by 1: the corner by (1, 1, 1), however many triangles a face has."""
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [0, 4, 1]])
    way = outward(triangles, np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), 5)
    assert np.allclose(way[0], (1, 1, 1))


def test_something_far_away_changes_nothing_near():
    far = s.quad((3e5, 9e5, -4e5), (1, 0, 0), (0, 1, 0)), s.diffuse()
    parts = [glass_box((-1, -1, -1), (1, 1, 1)), glass_box((-1, -1, 1.5), (1, 1, 2)), far]
    for before, after in spread(parts, [True, True, False]):
        assert np.array_equal(before, after)
