"""SUBSURFACE lobes: which one is picked, what albedo their media have, how far light goes in them."""

import numpy as np
import pytest

from .. import layout as lay
from ..deep import has_deep, pick_deep, same_deep, single_albedo
from ..subsurface import BISECTIONS, free_path, reduced_albedo

KINDS = np.array([[lay.REFLECT, lay.SUBSURFACE, lay.DIFFUSE, lay.SUBSURFACE, lay.NONE]], np.int32)
ROWS = lay.LobeRows(KINDS, np.zeros((1, 5, lay.N_FIELDS), np.float32))
COLORS = np.linspace(0.0, 1.0, 21)


def test_lobes_are_picked_by_weight():
    scratch = np.zeros((5, 8))
    scratch[:, 3] = 9.0, 0.2, 5.0, 0.6, 7.0  # beyond the row: what another hit left
    scratch[:, 4] = lay.CLASS_SHARP, lay.CLASS_DEEP, lay.CLASS_ROUGH, lay.CLASS_DEEP, lay.CLASS_DEEP
    found = [pick_deep(ROWS, 0, scratch, u) for u in (0.0, 0.24, 0.26, 1.0 - 1e-16)]
    assert [k for k, _ in found] == [1, 1, 3, 3]
    assert [p for _, p in found] == pytest.approx([0.25, 0.25, 0.75, 0.75])
    scratch[1:4:2, 3] = 0.0
    assert pick_deep(ROWS, 0, scratch, 0.5)[0] == -1


def test_the_same_lobe_is_found_again_or_the_first():
    assert [same_deep(ROWS, 0, k) for k in (0, 1, 3, 7)] == [1, 1, 3, 1]
    assert has_deep(ROWS, 0)
    without = ROWS._replace(kind=np.where(KINDS == lay.SUBSURFACE, lay.DIFFUSE, KINDS))
    assert same_deep(without, 0, 1) == -1 and not has_deep(without, 0)


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.6])
def test_medium_reflects_the_colour(g):
    """Van de Hulst's albedo of a half-space, by similarity; the inversion is off by up to 0.0036."""
    a = np.array([single_albedo(c, g, lay.WALK) for c in COLORS])
    s = np.sqrt((1.0 - a) / (1.0 - g * a))
    np.testing.assert_allclose((1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s), COLORS, atol=0.005)


def test_older_fit_goes_the_same_way():
    """Both are fits to the same walks where scattering is even: 0.0024 apart."""
    even = np.array([[single_albedo(c, 0.0, law) for law in (lay.WALK, lay.WALK_LEGACY)] for c in COLORS])
    np.testing.assert_allclose(even[:, 0], even[:, 1], atol=0.004)
    ahead = np.array([single_albedo(c, 0.8, lay.WALK_LEGACY) for c in COLORS])
    assert (np.diff(ahead) >= 0.0).all() and (ahead[1:-3] > even[1:-3, 1]).all()


@pytest.mark.parametrize("ior", [1.01, 1.4, 2.5])
def test_dipole_reflects_the_colour(ior):
    """Reflectance of a dipole [Jensen et al. 2001]: the bisection is as coarse as its last step."""
    x = 1.0 / ior
    inside = x * (-1.44 * x + 0.71) + 0.668 + 0.0636 * ior
    boundary = 4.0 / 3.0 * (1.0 + inside) / (1.0 - inside)
    colors = np.linspace(0.05, 0.95, 19)
    found = reduced_albedo(colors, np.array(boundary))

    def reflected(albedo):
        s = np.sqrt(3.0 * (1.0 - albedo))
        return 0.5 * albedo * (1.0 + np.exp(-boundary * s)) * np.exp(-s)

    step = 2.0**-BISECTIONS
    assert (reflected(found - step) <= colors).all() and (colors <= reflected(np.minimum(found + step, 1.0))).all()
    np.testing.assert_allclose(
        free_path(np.ones((1, 3)), np.full((1, 3), colors[9]), np.array([ior]), lay.WALK_SKIN),
        np.sqrt(3.0 * (1.0 - found[9])), rtol=1e-12,
    )  # fmt: skip
