import numpy as np

from ..pointiness import FLAT, pointiness

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
EDGES = np.array([[a, b] for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 2.0], np.int32)


def test_cube_and_plane():
    """A cube's edges lie 125.3 degrees from the normal at its corners; a flat grid's mean edge is zero or across."""
    normals = CORNERS / np.sqrt(np.float32(3.0))
    expected = np.arccos(-1.0 / np.sqrt(3.0)) / np.pi
    np.testing.assert_allclose(pointiness(CORNERS, normals, EDGES), expected, rtol=1e-6)
    np.testing.assert_allclose(pointiness(CORNERS, -normals, EDGES), 1.0 - expected, rtol=1e-6)
    flat = CORNERS * np.float32([1.0, 1.0, 0.0])
    np.testing.assert_allclose(pointiness(flat, np.tile(np.float32([0, 0, 1]), (8, 1)), EDGES), FLAT, rtol=1e-6)


def test_doubled_vertices_are_one():
    """A cube of which every vertex is there twice, one for each of two shells of edges."""
    normals = CORNERS / np.sqrt(np.float32(3.0))
    twice = pointiness(np.tile(CORNERS, (2, 1)), np.tile(normals, (2, 1)), np.concatenate([EDGES, EDGES + 8]))
    np.testing.assert_allclose(twice, np.tile(pointiness(CORNERS, normals, EDGES), 2), rtol=1e-6)


def test_lonely_vertex():
    assert pointiness(np.zeros((1, 3), np.float32), np.zeros((1, 3), np.float32), np.zeros((0, 2), np.int32))[0] == 0.0
