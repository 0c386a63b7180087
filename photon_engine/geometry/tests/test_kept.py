"""What is kept is what would be made anew, and nothing is made twice."""

from dataclasses import replace

import numpy as np

from ...issues import IssueLog
from ...scene.data import Graph, Instance, Material, Mesh, SceneData
from ..flatten import flatten
from ..kept import Kept


def scene(shift=0.0, material=0):
    """A quad, twice; all arrays are new ones."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    mesh = Mesh("Quad", positions, np.array([[0, 1, 2], [0, 2, 3]], np.int32), None, None)
    there = np.eye(4)
    there[2, 3] = 2.0 + shift
    materials = [Material("A", Graph()), Material("B", Graph())]
    return SceneData(meshes=[mesh], instances=[Instance(0, np.eye(4), [0], "a"), Instance(0, there, [material], "b")],
                     materials=materials)  # fmt: skip


def same(a, b):
    """Whether two flattened scenes are equal to the bit."""
    return all(np.array_equal(x, y) for x, y in zip(a.geometry, b.geometry, strict=True)) and (
        np.array_equal(a.origin, b.origin) and a.radius == b.radius
    )


def test_equal_input_makes_nothing_anew():
    kept = Kept()
    first = kept.flatten(scene(), IssueLog())
    tree = kept.intersector()
    moved_camera = scene()
    moved_camera.camera = replace(moved_camera.camera, matrix=np.diag([1.0, 1.0, 1.0, 1.0]) + 1.0)
    assert kept.flatten(moved_camera, IssueLog()) is first and kept.intersector() is tree
    assert (kept.flattened, kept.built) == (1, 1)


def test_what_moves_or_changes_is_made_anew():
    kept = Kept()
    kept.flatten(scene(), IssueLog())
    kept.intersector()
    moved = kept.flatten(scene(shift=1.0), IssueLog())
    kept.intersector()
    assert (kept.flattened, kept.built) == (2, 2) and same(moved, flatten(scene(shift=1.0), IssueLog()))
    other = scene(shift=1.0)
    other.meshes[0].positions[2, 2] = 0.5
    bent = kept.flatten(other, IssueLog())
    kept.intersector()
    assert (kept.flattened, kept.built) == (3, 3) and same(bent, flatten(other, IssueLog()))
    gone = scene(shift=1.0)
    del gone.instances[1]
    assert same(kept.flatten(gone, IssueLog()), flatten(gone, IssueLog())) and kept.flattened == 4


def test_another_material_or_other_normals_keep_the_tree():
    kept = Kept()
    kept.flatten(scene(), IssueLog())
    tree = kept.intersector()
    other = kept.flatten(scene(material=1), IssueLog())
    assert kept.intersector() is tree and other.geometry.material.tolist() == [0, 0, 1, 1]
    smooth = scene(material=1)
    smooth.meshes[0].normals = np.tile(np.float32([0.6, 0.0, 0.8]), (2, 3, 1))
    assert len(kept.flatten(smooth, IssueLog()).geometry.normals) == 4 and kept.intersector() is tree


def test_issues_are_told_each_time():
    kept = Kept()
    for _ in range(2):
        bad = scene()
        bad.meshes[0].positions[0, 0] = np.inf
        issues = IssueLog()
        kept.flatten(bad, issues)
        assert len(issues) == 2
    assert kept.flattened == 1
