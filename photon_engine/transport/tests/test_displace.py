"""Vertices moved by the material's displacement."""

import numpy as np
import pytest

from ...issues import IssueLog
from ...scene.data import Graph, Instance, Material, Mesh, Node, SceneData, Socket
from ..displace import displaced, face_normals

STRETCH = np.diag([2.0, 1.0, 1.0, 1.0])


def octahedron(smooth: bool) -> Mesh:
    """Eight triangles about the origin, corners at distance 1."""
    positions = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], np.float32)
    triangles = [(i, j, k) for i in (0, 3) for j in (1, 4) for k in (2, 5)]
    triangles = np.array([t if sum(c > 2 for c in t) % 2 == 0 else (t[0], t[2], t[1]) for t in triangles], np.int32)
    return Mesh("Ball", positions, triangles, positions[triangles] if smooth else None, None)


def material(method: str, space: str = "OBJECT", height=0.75) -> Material:
    """Displaced by (height - 0.25) 0.6 along the normal."""
    inputs = {"Height": Socket(height), "Midlevel": Socket(0.25), "Scale": Socket(0.6),
              "Normal": Socket(None, kind="VECTOR")}  # fmt: skip
    node = Node("ShaderNodeDisplacement", "Displacement", {"space": space}, inputs, {"Displacement": "VECTOR"})
    return Material("Rough", Graph([node], None, None, Socket(None, 0, "Displacement", "VECTOR")), method)


def moved(method="DISPLACEMENT", smooth=True, matrix=None, space="OBJECT", height=0.75):
    """The scene before and after."""
    matrix = np.eye(4) if matrix is None else matrix
    scene = SceneData(meshes=[octahedron(smooth)], materials=[material(method, space, height)])
    scene.instances = [Instance(0, matrix, [0]), Instance(0, matrix, [-1])]
    return scene, displaced(scene, IssueLog())


def test_smooth_ball_grows():
    """Every vertex moves by 0.3 along its normal; the other instance keeps its mesh; normals stay."""
    before, after = moved()
    assert [item.mesh for item in after.instances] == [1, 0]
    np.testing.assert_allclose(after.meshes[1].positions, 1.3 * before.meshes[0].positions, atol=1e-6)
    np.testing.assert_allclose(after.meshes[1].normals, before.meshes[0].normals, atol=1e-6)


def test_flat_faces_get_the_first_face_of_a_vertex():
    """A flat mesh stays closed: each vertex moves once, along a face around it, by 0.3."""
    before, after = moved(smooth=False)
    step = after.meshes[1].positions - before.meshes[0].positions
    np.testing.assert_allclose(np.linalg.norm(step, axis=1), 0.3, atol=1e-6)
    faces = face_normals(before.meshes[0].positions, before.meshes[0].triangles)
    for v in range(6):
        around = faces[(before.meshes[0].triangles == v).any(axis=1)]
        assert (around @ step[v]).max() == pytest.approx(0.3, abs=1e-6)
    assert after.meshes[1].normals is None


@pytest.mark.parametrize("mirrored", [False, True])
def test_world_space_and_scaled_objects(mirrored):
    """In world space the step is 0.3 m whatever the object's scale; in object space it is scaled with it."""
    matrix = STRETCH @ np.diag([-1.0, 1.0, 1.0, 1.0]) if mirrored else STRETCH
    for space, expected in (("WORLD", 0.15), ("OBJECT", 0.3)):
        before, after = moved(matrix=matrix, space=space)
        step = np.linalg.norm(after.meshes[1].positions - before.meshes[0].positions, axis=1)
        assert step[0] == pytest.approx(expected, abs=1e-6) and step[3] == pytest.approx(expected, abs=1e-6)


def test_bump_only_moves_nothing():
    before, after = moved("BUMP")
    assert after is before


def test_what_is_no_number_is_reported():
    scene, _ = moved()
    scene.materials = [material("BOTH", height=float("nan"))]
    issues = IssueLog()
    after = displaced(scene, issues)
    np.testing.assert_array_equal(after.meshes[1].positions, scene.meshes[0].positions)
    assert "6 vertices" in str(next(iter(issues)))
