"""Both tracers' ray queries and Fresnel's law against their naive twins."""

import numpy as np
import pytest

from photon_engine.bsdf.fresnel import fresnel_dielectric
from photon_engine.geometry.flatten import flatten
from photon_engine.geometry.intersect import Intersector
from photon_engine.issues import IssueLog
from tests import naive
from tests.brute import scenes as s
from tests.brute.bvh import build_tree, intersect
from tests.brute.materials import fresnel as brute_fresnel


@pytest.fixture(scope="module")
def rays():
    """A turned, mirrored and stretched ball and a box, with rays from around them: corners, o, d and what they hit."""
    scene = s.build([(s.sphere((0, 0, 0), 1.0, 16), s.diffuse()), (s.box((1, 1, 1), (2, 2, 2)), s.diffuse())])
    scene.instances[0].matrix = np.array([[0.9, 0.4, 0, 0.3], [-0.5, 0.7, 0.2, 0], [0, 0.3, -1.2, 0.1], [0, 0, 0, 1.0]])
    rng = np.random.default_rng(5)
    o = rng.normal(size=(400, 3)) * 3
    d = rng.normal(size=(400, 3)) * 0.7 - o
    o, d = o.astype(np.float32), (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(np.float32)
    corners = naive.world_corners(scene)
    hits = [naive.nearest_hit(corners, *map(np.float64, ray), 1e9) for ray in zip(o, d, strict=True)]
    return scene, corners, o, d, np.array([h[0] for h in hits]), np.array([h[1] for h in hits])


def test_embree_finds_the_nearest(rays):
    """Hit or miss, and the distance; within f32 of edges a neighbour may be hit at the same distance."""
    scene, _, o, d, triangle, t = rays
    flat = flatten(scene, IssueLog())
    hits = Intersector(flat.geometry).closest((o - flat.origin).astype(np.float32), d)
    assert 0.3 < (triangle >= 0).mean() < 0.9
    assert ((hits.prim >= 0) != (triangle >= 0)).sum() <= 1  # a ray may graze a silhouette
    both = (hits.prim >= 0) & (triangle >= 0)
    np.testing.assert_allclose(hits.t[both], t[both], rtol=2e-5, atol=2e-5)
    assert (hits.prim[both] == triangle[both]).mean() > 0.99


def test_box_tree_finds_the_nearest(rays):
    """The reference tracer's own tree, in doubles: the very same triangles."""
    _, corners, o, d, triangle, t = rays
    tree, order = build_tree(corners)
    stack = np.empty(256, np.int32)
    for k in range(len(o)):
        i, at, _, _ = intersect(tree, tuple(map(float, o[k])), tuple(map(float, d[k])), 1e9, -1, stack)
        assert (order[i] if i >= 0 else -1) == triangle[k]
        assert at == pytest.approx(t[k], rel=1e-9)


@pytest.mark.parametrize("eta", [1.5, 1.0 / 1.5, 1.333, 1.0001])
def test_fresnel(eta):
    """Both tracers' reflectance from 0 to 90 degrees, total reflection included."""
    for angle in np.radians(np.linspace(0.0, 89.9, 60)):
        expected = naive.fresnel(angle, eta)
        assert fresnel_dielectric(np.cos(angle), eta)[0] == pytest.approx(expected, abs=1e-8)
        assert brute_fresnel(np.cos(angle), eta)[0] == pytest.approx(expected, abs=1e-8)
