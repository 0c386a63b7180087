"""World triangles, their tree and what is made of them, kept from one render to the next: frames, layers, F12 again.

What went in is compared, by identity first and by value then, so that nobody has to tell what changed: a comparison
reads each array once, far below the cost of a tree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..issues import IssueLog
from ..scene.data import Instance, Mesh, SceneData
from ..scene.memo import Memo, same
from .flatten import Flattened, flatten
from .intersect import Intersector
from .touching import spread_touching


class Placed(NamedTuple):
    """All of an instance that `flatten` reads."""

    mesh: Mesh
    matrix: np.ndarray
    materials: tuple[int, ...]


class Kept:
    """Geometry of the last render, for the next one."""

    def __init__(self) -> None:
        self.flattened = 0  # how often triangles were made
        self.built = 0  # how often a tree was built
        self.memo = Memo()  # what others make of the scene: materials, lights, bounds
        self._inputs: tuple[int, list[Placed], frozenset[int]] | None = None
        self._issues = IssueLog()
        self._flat: Flattened | None = None
        self._intersector: Intersector | None = None

    def flatten(self, scene: SceneData, issues: IssueLog, refracting: frozenset[int] = frozenset()) -> Flattened:
        """As geometry.flatten; the last result when the same goes in. Issues are told again.

        refracting : indices of the materials that may refract; their bodies are kept apart: see geometry/touching.py
        """
        inputs = len(scene.materials), [_placed(scene, item) for item in scene.instances], refracting
        if self._flat is None or not _same_inputs(inputs, self._inputs):
            self._issues = IssueLog()
            flat = flatten(scene, self._issues)
            flat = spread_touching(flat, np.isin(flat.geometry.material, list(refracting)))
            if self._flat is None or not _same_triangles(flat, self._flat):
                self._intersector = None
            self._flat = flat
            self.flattened += 1
        self._inputs = inputs  # the newest arrays: identity is found at once next time
        issues.extend(self._issues)
        return self._flat

    def intersector(self) -> Intersector:
        """The tree over the triangles of the last `flatten`."""
        if self._intersector is None:
            self._intersector = Intersector(self._flat.geometry)
            self.built += 1
        return self._intersector


def _placed(scene: SceneData, item: Instance) -> Placed:
    """What flatten reads of an instance."""
    return Placed(scene.meshes[item.mesh], item.matrix, tuple(item.materials))


def _same_inputs(new: tuple, old: tuple | None) -> bool:
    """Whether flatten would give the same."""
    if old is None or new[0] != old[0] or new[2] != old[2] or len(new[1]) != len(old[1]):
        return False
    compared: set[tuple[int, int]] = set()  # meshes of many instances are compared once
    for a, b in zip(new[1], old[1], strict=True):
        if a.materials != b.materials or not np.array_equal(a.matrix, b.matrix):
            return False
        pair = id(a.mesh), id(b.mesh)
        if pair not in compared and not _same_mesh(a.mesh, b.mesh):
            return False
        compared.add(pair)
    return True


def _same_mesh(a: Mesh, b: Mesh) -> bool:
    """Whether two meshes have the same surface."""
    names = ("positions", "triangles", "normals", "material_index")
    return a is b or all(same(getattr(a, name), getattr(b, name)) for name in names)


def _same_triangles(a: Flattened, b: Flattened) -> bool:
    """Whether the same tree serves both: materials and normals may differ."""
    return same(a.geometry.triangles, b.geometry.triangles) and same(a.geometry.positions, b.geometry.positions)
