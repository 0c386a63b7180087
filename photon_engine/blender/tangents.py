"""Tangents of a UV layer per triangle corner, after MikkTSpace, without its limit to triangles and quads.

Blender's ``Mesh.calc_tangents`` refuses faces with more than four corners and writes into the mesh it is asked about.
"""

from __future__ import annotations

import numpy as np


def corner_tangents(
    positions: np.ndarray, triangles: np.ndarray, normals: np.ndarray | None, uv: np.ndarray
) -> np.ndarray:
    """Tangent and bitangent sign, (T, 3, 4) f32; the bitangent is ``sign * cross(n, t)``.

    [Mikkelsen 2008, Simulation of Wrinkled Surfaces Revisited]: the direction of growing u of each triangle, projected
    on the plane of the corner's normal, is averaged by corner angle over triangles that share position, normal, UV and
    handedness. positions (V, 3), triangles (T, 3), normals (T, 3, 3) or None for flat faces, uv (T, 3, 2).
    """
    p = positions[triangles].astype(np.float64)
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    geometric = _unit(np.cross(e1, e2))
    n = np.repeat(geometric[:, None, :], 3, axis=1) if normals is None else normals.astype(np.float64)
    d1, d2 = (uv[:, i].astype(np.float64) - uv[:, 0] for i in (1, 2))
    area = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
    sign = np.where(area >= 0.0, 1.0, -1.0)
    along_u = _unit((e1 * d2[:, 1:] - e2 * d1[:, 1:]) * sign[:, None])
    along_u[area == 0.0] = 0.0  # no direction: such a triangle takes its neighbours'
    weighted = _project(along_u[:, None, :], n) * _corner_angles(p, n)[..., None]

    group = _groups(triangles, n, uv, sign)
    total = np.stack([np.bincount(group, weighted[..., axis].ravel()) for axis in range(3)], axis=1)
    tangent = _unit(total)[group].reshape(n.shape)
    none = np.einsum("tcx,tcx->tc", tangent, tangent) < 0.5
    tangent[none] = _any_perpendicular(n[none])
    return np.concatenate([tangent, np.repeat(sign[:, None, None], 3, axis=1)], axis=2).astype(np.float32)


def _unit(v: np.ndarray) -> np.ndarray:
    """Rows divided by their length; zero rows stay."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length > 0.0, length, 1.0)


def _project(v: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Unit part of v in the plane of the unit normal n."""
    return _unit(v - np.sum(v * n, axis=-1, keepdims=True) * n)


def _corner_angles(p: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Angle of each corner between its edges, projected on the normal's plane, (T, 3) [rad]."""
    forward = _project(np.roll(p, -1, axis=1) - p, n)
    backward = _project(np.roll(p, 1, axis=1) - p, n)
    return np.arccos(np.clip(np.sum(forward * backward, axis=-1), -1.0, 1.0))


def _groups(triangles: np.ndarray, n: np.ndarray, uv: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """A number for each corner, equal where position, normal, UV and handedness are, (3 T,) i64."""
    floats = np.concatenate([n.reshape(-1, 3), uv.reshape(-1, 2), np.repeat(sign, 3)[:, None]], axis=1)
    words = (floats.astype(np.float32) + np.float32(0.0)).view(np.uint32)  # -0 and 0 become one
    # sorting 64-bit hashes is five times faster than sorting rows; among 3 million corners the chance that any two
    # differ and collide is 3e-7
    key = triangles.ravel().astype(np.uint64)
    for column in words.T:
        key = (key ^ (key >> np.uint64(29)) ^ column) * np.uint64(0xBF58476D1CE4E5B9)
    return np.unique(key, return_inverse=True)[1].reshape(-1)


def _any_perpendicular(n: np.ndarray) -> np.ndarray:
    """Some unit vector across each n."""
    axis = np.where(np.abs(n[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    return _project(axis, n)
