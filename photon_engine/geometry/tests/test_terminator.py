import numpy as np
import pytest

from ..flatten import Geometry
from ..terminator import bulge, lift, lift_amount

ANGLE = 0.4  # of a facet's edge seen from the middle of its sphere [rad]


def facet(smooth=True):
    """A triangle with its corners on the unit sphere about z."""
    ring = 2.0 * np.pi / 3.0 * np.arange(3)
    sine = ANGLE / np.sqrt(3.0)
    corners = np.stack([sine * np.cos(ring), sine * np.sin(ring), np.full(3, np.sqrt(1.0 - sine**2))], 1)
    normals = corners if smooth else np.tile([0.0, 0.0, 1.0], (3, 1))
    zero = np.zeros(1, np.int32)
    triangles = np.array([[0, 1, 2]], np.int32)
    return Geometry(
        corners.astype(np.float32), triangles, zero, normals[None].astype(np.float32), zero, zero
    )


def heights(geometry):
    """Distance from the middle of the sphere of points all over the facet after the full lift."""
    v = [tuple(map(float, p)) for p in geometry.positions]
    n = [tuple(map(float, p)) for p in geometry.normals[0]]
    out = []
    for a in np.linspace(0.0, 1.0, 9):
        for b in np.linspace(0.0, 1.0 - a, 5):
            p, m = ((1.0 - a - b) * x[0] + a * x[1] + b * x[2] for x in (np.array(v), np.array(n)))
            out.append(np.linalg.norm(p + m * bulge(*v, *n, a, b)))
    return np.array(out)


def test_lifted_points_clear_the_sphere():
    """A ray from there meets no neighbouring facet, which all lie within the sphere; corners stay."""
    radii = heights(facet())
    assert radii.min() > 1.0 - 1e-6
    assert radii.max() < 1.0 + 0.5 * ANGLE**2
    assert np.sum(radii < 1.0 + 1e-6) == 7  # the grid's corner points: 5 of them lie on the third corner


def test_a_flat_triangle_stays():
    assert lift(facet(False), 0, 0.3, 0.3, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), 0.1) == (0.0, 0.0, 0.0)
    middle, up = np.sqrt(1.0 - ANGLE**2 / 3.0), (0.0, 0.0, 1.0)
    corners = [tuple(map(float, p)) for p in facet(False).positions]
    assert corners[0][2] == pytest.approx(middle)
    assert bulge(*corners, up, up, up, 0.3, 0.3) == pytest.approx(0.0, abs=1e-12)


def test_lift_only_near_the_terminator():
    assert lift_amount(0.5, 0.2, 0.1) == 0.0
    assert lift_amount(0.5, 0.05, 0.1) == pytest.approx(0.5)
    assert lift_amount(0.05, 0.05, 0.1) == pytest.approx(1.0)
    assert lift_amount(0.5, -0.2, 0.1) == 1.0
    up, light = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
    assert lift(facet(), 0, 0.3, 0.3, up, up, (0.0, 0.6, 0.8), 0.1) == (0.0, 0.0, 0.0)
    assert lift(facet(), 0, 0.3, 0.3, up, up, light, 0.0) == (0.0, 0.0, 0.0), "the object's offset is 0"
    assert lift(facet(), 0, 0.3, 0.3, up, up, light, 0.1)[2] > 0.01


def test_light_from_behind_lifts_to_its_side():
    """Seen from inside, the same facet is hollow: the parabola bends away, the corners' planes hold the rest."""
    down, light = (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
    assert lift(facet(), 0, 0.3, 0.3, down, down, light, 0.1)[2] <= 0.0
