"""Ray queries. The only place that knows embreex.

Its quirks, hidden here: origins must be offset because tnear is 0; a passed distance array is overwritten; a miss is
primitive -1; the scene is robust (watertight) so that closed meshes do not leak at their edges.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .flatten import Geometry

FAR = np.float32(1e37)


class Hits(NamedTuple):
    """Nearest intersections of a batch of rays."""

    prim: np.ndarray  # (n,) i32, triangle; -1: none
    u: np.ndarray  # (n,) f32, barycentric weight of the second corner
    v: np.ndarray  # (n,) f32, of the third corner
    t: np.ndarray  # (n,) f32, distance in units of |d|


class Intersector:
    """Embree over all triangles of a scene. Queries release the GIL and may run from several threads."""

    def __init__(self, geometry: Geometry) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = None
        if len(geometry.triangles):
            self._scene = EmbreeScene(robust=True)
            self._mesh = TriangleMesh(self._scene, geometry.positions, geometry.triangles)
            self.closest(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # the first query builds the tree

    def closest(self, o: np.ndarray, d: np.ndarray, t_max: np.ndarray | None = None) -> Hits:
        """Nearest triangle along each ray; o, d : (n, 3) f32; t_max : (n,) f32, kept."""
        n = len(o)
        if self._scene is None or n == 0:
            return Hits(np.full(n, -1, np.int32), np.zeros(n, np.float32), np.zeros(n, np.float32), np.full(n, FAR))
        dists = None if t_max is None else t_max.copy()
        out = self._scene.run(o, d, dists=dists, output=1)
        return Hits(out["primID"], out["u"], out["v"], out["tfar"])

    def occluded(self, o: np.ndarray, d: np.ndarray, t_max: np.ndarray) -> np.ndarray:
        """Whether anything lies between o and o + t_max d; (n,) bool."""
        if self._scene is None or len(o) == 0:
            return np.zeros(len(o), bool)
        return self._scene.run(o, d, dists=t_max.copy(), query="OCCLUDED") != -1
