"""Rays that nodes send from the points they shade: Ambient Occlusion, Bevel and Raycast."""

from __future__ import annotations

from threading import Lock

import numpy as np

from ..geometry.flatten import Flattened
from ..geometry.intersect import Hits, Intersector
from ..geometry.surface import RELATIVE_OFFSET, surface_points

f32 = np.float32


class NodeRays:
    """Ray queries of a scene, in its recentred coordinates. Trees of single instances are made when first asked for."""

    def __init__(self, flat: Flattened, intersector: Intersector) -> None:
        self.flat = flat
        self.intersector = intersector
        self._own: dict[int, Intersector] = {}
        self._lock = Lock()

    def free(self, points, d: np.ndarray, t_max: np.ndarray, own: bool) -> np.ndarray:
        """Whether nothing lies within t_max (n,) [m] along d (n, 3) of the points; own: nothing of the same object."""
        o = self._leaving(points, d)
        d, t_max = np.ascontiguousarray(d, f32), np.ascontiguousarray(t_max, f32)
        if not own:
            return ~self.intersector.occluded(o, d, t_max)
        out = np.ones(len(o), bool)
        for instance in np.unique(points.instance):
            index = np.flatnonzero(points.instance == instance)
            out[index] = ~self._tree(int(instance)).occluded(o[index], d[index], t_max[index])
        return out

    def crossings(self, points, o: np.ndarray, d: np.ndarray, t_max: np.ndarray, most: int) -> list[tuple]:
        """The points' own objects along rays o + t d: up to `most` lists (index, p, ng, ns) of crossings.

        p, ng, ns (k, 3) f32; normals face outward.
        """
        found = []
        start = np.array(o, f32)
        d, left = np.ascontiguousarray(d, f32), np.ascontiguousarray(t_max, f32).copy()
        alive = np.arange(len(o))
        for _ in range(most):
            prim, u, v, t = self.within(points.instance[alive], start[alive], d[alive], left[alive])
            met = prim >= 0
            alive = alive[met]
            if not len(alive):
                break
            p, ng, ns = (np.empty((len(alive), 3), f32) for _ in range(3))
            surface_points(self.flat.geometry, prim[met], u[met], v[met], p, ng, ns)
            found.append((alive, p, ng, ns))
            step = t[met] + RELATIVE_OFFSET * np.abs(start[alive]).max(axis=1).clip(self.flat.radius * 0.125)
            start[alive] += step[:, None].astype(f32) * d[alive]
            left[alive] -= step
            alive = alive[left[alive] > 0.0]
        return found

    def nearest(self, points, o: np.ndarray | None, d: np.ndarray, t_max: np.ndarray, own: bool) -> tuple:
        """(hit, t, self, n) of the first surface along rays o + t d, from the points where o is None.

        hit, self (n,) bool, the latter where it is of the point's own object; t (n,) f32; n (n, 3) f32, the shading
        normal on the side that was hit.
        """
        start = self._leaving(points, d) if o is None else np.ascontiguousarray(o, f32)
        d, t_max = np.ascontiguousarray(d, f32), np.ascontiguousarray(t_max, f32)
        prim, u, v, t = (np.array(field) for field in self._first(points, start, d, t_max, own))
        hit = prim >= 0
        normal = np.zeros((len(d), 3), f32)
        p, ng, ns = (np.empty((int(hit.sum()), 3), f32) for _ in range(3))
        surface_points(self.flat.geometry, prim[hit], u[hit], v[hit], p, ng, ns)
        normal[hit] = np.where((ng * d[hit]).sum(axis=1, keepdims=True) > 0.0, -ns, ns)
        mine = np.zeros(len(d), bool)
        mine[hit] = self.flat.geometry.instance[prim[hit]] == points.instance[hit]
        return hit, t, mine, normal

    def _first(self, points, start, d, t_max, own: bool) -> tuple:
        """Nearest hits (prim, u, v, t), with `own` among the points' own objects."""
        if not own:
            return self.intersector.closest(start, d, t_max)
        return self.within(points.instance, start, d, t_max)

    def within(self, instance: np.ndarray, o: np.ndarray, d: np.ndarray, t_max: np.ndarray) -> Hits:
        """Nearest triangle of the instance given for each ray; o, d (n, 3) f32, recentred; instance (n,)."""
        prim, u, v, t = (np.empty(len(d), kind) for kind in (np.int32, f32, f32, f32))
        for which in np.unique(instance):
            mine = slice(None) if instance[0] == which and (instance == which).all() else instance == which
            hits = self._tree(int(which)).closest(o[mine], d[mine], t_max[mine])
            prim[mine] = np.where(hits.prim >= 0, hits.prim + np.int32(self.flat.first_triangle[which]), -1)
            u[mine], v[mine], t[mine] = hits.u, hits.v, hits.t
        return Hits(prim, u, v, t)

    def _leaving(self, points, d: np.ndarray) -> np.ndarray:
        """Origins (n, 3) f32, recentred, of rays along d, off the surface as `geometry.surface.offset_origin` does."""
        p = points.p
        corners = points.corners
        reach = 0.5 * np.ptp(corners, axis=1).max(axis=1)
        size = np.maximum(np.abs(p).max(axis=1), 0.125 * reach)
        side = np.copysign(RELATIVE_OFFSET * size, (d * points.ng).sum(axis=1))
        return np.ascontiguousarray(p + side[:, None] * points.ng, f32)

    def _tree(self, instance: int) -> Intersector:
        """Embree over one instance."""
        with self._lock:
            if instance not in self._own:
                first, last = self.flat.first_triangle[instance : instance + 2]
                triangles = np.ascontiguousarray(self.flat.geometry.triangles[first:last])
                self._own[instance] = Intersector(self.flat.geometry._replace(triangles=triangles))
            return self._own[instance]
