"""How convex a mesh is at each vertex, as Cycles measures it for Geometry > Pointiness."""

from __future__ import annotations

import numpy as np

NAME = ".pointiness"  # among a mesh's attributes; Blender lets nobody give a name with a point
FLAT = 0.5  # of a flat surface; more is convex


def pointiness(positions: np.ndarray, normals: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Pointiness (V,) f32 of vertices; positions, normals (V, 3) of the vertices, edges (E, 2) i32.

    The angle between the normal and the mean unit vector along a vertex' edges over pi, then the mean over the vertex
    and its neighbours. Vertices at the same place are one; a vertex without edges has 0.
    """
    same, root = np.unique(positions + np.float32(0.0), axis=0, return_inverse=True)  # -0 becomes 0
    root, count = root.ravel(), len(same)
    n = np.zeros((count, 3))
    np.add.at(n, root, normals)
    size = np.linalg.norm(n, axis=1, keepdims=True)
    n /= np.where(size > 0.0, size, 1.0)
    ends = np.unique(np.sort(root[edges], axis=1), axis=0)
    degree = np.bincount(ends.ravel(), minlength=count)
    along = same[ends[:, 1]].astype(np.float64) - same[ends[:, 0]]
    size = np.linalg.norm(along, axis=1, keepdims=True)
    along /= np.where(size > 0.0, size, 1.0)
    mean = np.zeros((count, 3))
    np.add.at(mean, ends[:, 0], along)
    np.add.at(mean, ends[:, 1], -along)
    mean /= np.maximum(degree, 1)[:, None]
    angle = np.arccos(np.clip((n * mean).sum(axis=1), -1.0, 1.0)) / np.pi
    raw = np.where(degree > 0, angle, 0.0)
    total = raw.copy()
    np.add.at(total, ends[:, 0], raw[ends[:, 1]])
    np.add.at(total, ends[:, 1], raw[ends[:, 0]])
    return (total / (degree + 1))[root].astype(np.float32)
