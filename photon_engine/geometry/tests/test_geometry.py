"""Flattening keeps points, normals and orientation; rays that leave a surface do not hit it again."""

import numpy as np
import pytest

from ...issues import IssueLog
from ...jit import kernel
from ...scene.data import Instance, Mesh, SceneData
from ...vec import load3, store3
from ..flatten import flatten
from ..intersect import Intersector
from ..surface import leave, surface_points


def sphere(n=24, smooth=True):
    """A UV sphere of radius 1 without poles' degenerate triangles dropped on purpose."""
    theta, phi = np.meshgrid(np.linspace(0.01, np.pi - 0.01, n), np.linspace(0, 2 * np.pi, 2 * n), indexing="ij")
    p = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).reshape(-1, 3)
    a = (np.arange(n - 1)[:, None] * 2 * n + np.arange(2 * n - 1)).ravel()
    tris = np.concatenate([np.stack([a, a + 2 * n, a + 1], 1), np.stack([a + 1, a + 2 * n, a + 2 * n + 1], 1)])
    return Mesh(
        "sphere", p.astype(np.float32), tris.astype(np.int32), p[tris].astype(np.float32) if smooth else None, None
    )


def scene_of(mesh, *matrices):
    """One instance of the mesh for each matrix."""
    return SceneData(meshes=[mesh], instances=[Instance(0, m, [-1], f"o{i}") for i, m in enumerate(matrices)])


def random_matrix(seed, mirrored):
    """Rotation, uneven scale, shear; determinant of the wanted sign."""
    rng = np.random.default_rng(seed)
    linear = (
        np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.diag([0.5, 2.0, 1.3]) @ (np.eye(3) + 0.2 * rng.random((3, 3)))
    )
    if (np.linalg.det(linear) < 0) != mirrored:
        linear[:, 0] = -linear[:, 0]
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, rng.normal(size=3)
    return matrix


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("smooth", [False, True])
def test_normals_point_outward_after_any_transform(mirrored, smooth):
    """A transformed sphere is an ellipsoid: both normals agree with its gradient."""
    matrix = random_matrix(5, mirrored)
    flat = flatten(scene_of(sphere(48, smooth), matrix), IssueLog())
    n = len(flat.geometry.triangles)
    p, ng, ns = (np.empty((n, 3), np.float32) for _ in range(3))
    third = np.full(n, 1 / 3, np.float32)
    surface_points(flat.geometry, np.arange(n, dtype=np.int32), third, third, p, ng, ns)
    inverse = np.linalg.inv(matrix[:3, :3])
    gradient = ((p + flat.origin - matrix[:3, 3]) @ inverse.T) @ inverse
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    area = np.isfinite(ng).all(axis=1) & (np.linalg.norm(ng, axis=1) > 0.5)
    assert area.mean() > 0.95
    # facets of a 48-step sphere, stretched 4:1, turn by up to 0.13 rad; the slivers at the poles by more
    assert np.quantile((ng * gradient).sum(axis=1)[area], 0.02) > 0.99
    if smooth:
        assert (ns * gradient).sum(axis=1)[area].min() > 0.995


def test_flat_faces_need_no_normals():
    """Corner normals equal to the face's own are dropped."""
    mesh = sphere(8, False)
    corner = mesh.positions[mesh.triangles]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    mesh.normals = np.repeat(face[:, None], 3, axis=1).astype(np.float32)
    assert len(flatten(scene_of(mesh, random_matrix(1, True)), IssueLog()).geometry.normals) == 0


def test_far_from_the_origin_keeps_its_shape():
    """1e6 m away, recentred in double: the same triangles to single precision of the object's own size."""
    near, far = np.eye(4), np.eye(4)
    far[:3, 3] = (1e6, -3e6, 2e6)
    a, b = (flatten(scene_of(sphere(), m), IssueLog()) for m in (near, far))
    # 3e6 has an ulp of 5e-10 in double; the rest is single precision's own
    assert np.abs(a.geometry.positions - b.geometry.positions).max() < 2e-7


def test_bad_vertices_are_named_and_left_out():
    """Only the triangles that use them go."""
    mesh = sphere(8)
    mesh.positions[20] = np.nan
    issues = IssueLog()
    flat = flatten(scene_of(mesh, np.eye(4)), issues)
    assert [issue.object for issue in issues] == ["o0"]
    assert np.isfinite(flat.geometry.positions).all()
    hits = Intersector(flat.geometry).closest(
        np.array([[0, 0, 0]], np.float32), np.array([[0.6, -0.64, 0.48]], np.float32)
    )
    assert hits.prim[0] >= 0


@kernel
def leave_all(geometry, prim, p, ng, w, out):
    """`leave` of a batch."""
    for i in range(len(p)):
        store3(out, i, leave(geometry, prim[i], load3(p, i), load3(ng, i), load3(w, i)))


def rays_off(geometry, prim, rng):
    """Rays that leave random points of these triangles to all sides: origins, directions, which go outward."""
    n = len(prim)
    u = rng.random(n).astype(np.float32)
    v = (rng.random(n) * (1 - u)).astype(np.float32)
    p, ng, ns, start = (np.empty((n, 3), np.float32) for _ in range(4))
    surface_points(geometry, prim, u, v, p, ng, ns)
    w = rng.normal(size=(n, 3)).astype(np.float32)
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    leave_all(geometry, prim, p, ng, w, start)
    return start, w, (w * ng).sum(axis=1) > 0.0


@pytest.mark.parametrize("size, place", [(1.0, 0.0), (1e-4, 0.0), (1e4, 0.0), (1.0, 300.0)])
def test_rays_that_leave_do_not_come_back_at_once(size, place):
    """10^5 rays at all angles off a sphere outward: none may hit it again; rays inward all do.

    Off-centre by 300 radii the coordinates have 1/300 of the digits, and the offset must grow with them.
    """
    matrix = np.diag([size, size, size, 1.0])
    other = matrix.copy()
    other[:3, 3] = 2.0 * place * size
    scene = scene_of(sphere(64, False), matrix, other) if place else scene_of(sphere(64, False), matrix)
    flat = flatten(scene, IssueLog())
    rng = np.random.default_rng(6)
    prim = rng.integers(0, flat.first_triangle[1], 100_000).astype(np.int32)
    start, w, outward = rays_off(flat.geometry, prim, rng)
    hits = Intersector(flat.geometry).closest(start, w)
    near = (hits.prim >= 0) & (hits.t < 3.0 * size)
    assert not near[outward].any()
    assert near[~outward].mean() > 0.999  # the poles are open


def strips(widths, turn):
    """A flat sheet of strips 1 m long, each of two triangles, turned; its middle is the origin."""
    x = np.concatenate([[0.0], np.cumsum(widths)]) - 0.5 * np.sum(widths)
    points = np.stack([np.tile(x, 2), np.repeat([-0.5, 0.5], len(x)), np.zeros(2 * len(x))], 1) @ turn.T
    i, n = np.arange(len(widths)), len(x)
    triangles = np.concatenate([np.stack([i, i + 1, n + i + 1], 1), np.stack([i, n + i + 1, n + i], 1)])
    return Mesh("strips", points.astype(np.float32), triangles.astype(np.int32), None, None)


def test_a_sheet_of_triangles_of_all_sizes_is_not_met_by_rays_that_leave_it():
    """100 m beside 10 micrometres: each starts off its own triangle, and may not meet the large one beside it."""
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    widths = 10.0 ** np.linspace(-5.0, 2.0, 15)
    flat = flatten(scene_of(strips(np.concatenate([widths[::-1], widths]), turn), np.eye(4)), IssueLog())
    start, w, _ = rays_off(flat.geometry, rng.integers(0, 60, 300_000).astype(np.int32), rng)
    hits = Intersector(flat.geometry).closest(start, w)
    # rounded corners bend the sheet: by 3e-8 of 1e-5 where it is finest
    steep = np.abs(w @ turn[:, 2]) > 0.02
    assert not (hits.prim[steep] >= 0).any()
