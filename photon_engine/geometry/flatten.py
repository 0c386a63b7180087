"""Meshes and instances as one list of world triangles, the form that Embree takes.

Positions are computed in double, moved so that the scene's middle is the origin, and rounded to single once: a scene
far from the world's origin keeps its precision.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..issues import IssueLog
from ..scene.data import Instance, Mesh, SceneData


class Geometry(NamedTuple):
    """World triangles as the kernels read them."""

    positions: np.ndarray  # (V, 3) f32, recentred [m]
    triangles: np.ndarray  # (T, 3) i32
    normal_row: np.ndarray  # (T,) i32, row of normals; -1: flat
    normals: np.ndarray  # (S, 3, 3) f32, unit shading normals of the corners of smooth triangles
    material: np.ndarray  # (T,) i32, index into the scene's materials, n_materials: the default material
    instance: np.ndarray  # (T,) i32


@dataclass
class Flattened:
    """Geometry with what is needed to look up other attributes, and where it lies."""

    geometry: Geometry
    origin: np.ndarray  # (3,) f64, subtracted from world positions
    center: np.ndarray  # (3,) f64, recentred bounding sphere
    radius: float
    first_triangle: np.ndarray  # (I + 1,) i64, triangles [first[i], first[i+1]) belong to instance i
    mirrored: np.ndarray  # (I,) bool, corners 1 and 2 are swapped


def flatten(scene: SceneData, issues: IssueLog) -> Flattened:
    """All visible instances as world triangles.

    Triangles with a non-finite corner are dropped and named once per object.
    """
    origin = scene_middle(scene)
    parts = [_instance_part(scene, item, index, origin, issues) for index, item in enumerate(scene.instances)]
    counts = np.array([0] + [len(part.triangles) for part in parts], np.int64)
    geometry = _concatenate(parts)
    used = geometry.positions[geometry.triangles.ravel()] if len(geometry.triangles) else geometry.positions
    center, radius = bounding_sphere(used)
    mirrored = np.array([np.linalg.det(item.matrix[:3, :3]) < 0.0 for item in scene.instances], bool)
    return Flattened(geometry, origin, center, radius, np.cumsum(counts), mirrored)


def scene_middle(scene: SceneData) -> np.ndarray:
    """Where most of the scene is, in double: the median of the instances' middles by triangles; zero if it is empty.

    Not the middle of the whole: one object at 1e6 m would leave single precision 3 cm steps for all the others.
    """
    middles, weights = [], []
    for item in scene.instances:
        points = scene.meshes[item.mesh].positions
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) == 0:
            continue
        box = np.array([points.min(axis=0), points.max(axis=0)], np.float64)
        corners = np.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        world = corners @ item.matrix[:3, :3].T + item.matrix[:3, 3]
        middle = 0.5 * (world.min(axis=0) + world.max(axis=0))
        if np.isfinite(middle).all():
            middles.append(middle)
            weights.append(len(scene.meshes[item.mesh].triangles))
    if not middles or not sum(weights):
        return np.zeros(3)
    values, weight = np.array(middles), np.array(weights)
    order = np.argsort(values, axis=0, kind="stable")
    half = np.argmax(np.cumsum(weight[order], axis=0) >= 0.5 * weight.sum(), axis=0)
    return values[order[half, np.arange(3)], np.arange(3)]


def bounding_sphere(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre (3,) f64 and radius of a sphere around points (n, 3): the box's middle, the farthest point."""
    if len(points) == 0:
        return np.zeros(3), 1.0
    center = 0.5 * (points.min(axis=0).astype(np.float64) + points.max(axis=0))
    radius = float(np.sqrt(((points - center) ** 2).sum(axis=1).max()))
    return center, radius if radius > 0.0 else 1.0


def _instance_part(scene: SceneData, item: Instance, index: int, origin: np.ndarray, issues: IssueLog) -> Geometry:
    """One instance's triangles in recentred world space, indices starting at 0."""
    mesh = scene.meshes[item.mesh]
    linear = item.matrix[:3, :3]
    positions = (mesh.positions.astype(np.float64) @ linear.T + (item.matrix[:3, 3] - origin)).astype(np.float32)
    triangles = mesh.triangles
    good = np.isfinite(positions).all(axis=1)
    if not good.all():
        keep = good[triangles].all(axis=1)
        positions = np.where(good[:, None], positions, np.float32(0.0))
        issues.warn(
            item.name or mesh.name,
            f"{int((~keep).sum())} triangles have a corner that is not a finite number and are left out",
            "look at the mesh's modifiers and the object's transform",
        )
        # dropping them would shift attributes of the triangles behind, so they collapse to a point instead
        triangles = np.where(keep[:, None], triangles, triangles[:, :1])
    normal_row, normals = _world_normals(mesh, linear)
    if np.linalg.det(linear) < 0.0:  # a mirror image: turn the corners round to keep the outside outside
        triangles = triangles[:, [0, 2, 1]]
        normals = normals[:, [0, 2, 1]]
    slots = np.array(item.materials or [-1], np.int32)
    slots = np.where(slots < 0, len(scene.materials), slots).astype(np.int32)
    which = np.zeros(len(triangles), np.int32) if mesh.material_index is None else mesh.material_index
    material = slots[np.clip(which, 0, len(slots) - 1)]
    return Geometry(
        positions,
        np.ascontiguousarray(triangles, np.int32),
        normal_row,
        np.ascontiguousarray(normals),
        material,
        np.full(len(triangles), index, np.int32),
    )


def _world_normals(mesh: Mesh, linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of world corner normals, and for each triangle its row or -1 when it is flat."""
    n = len(mesh.triangles)
    if mesh.normals is None:
        return np.full(n, -1, np.int32), np.zeros((0, 3, 3), np.float32)
    # normals go with the cofactor matrix, which unlike the inverse exists for a flattened object too
    cofactor = np.stack(
        [
            np.cross(linear[:, 1], linear[:, 2]),
            np.cross(linear[:, 2], linear[:, 0]),
            np.cross(linear[:, 0], linear[:, 1]),
        ],
        axis=1,
    )
    if np.linalg.det(linear) < 0.0:
        cofactor = -cofactor
    world = mesh.normals @ cofactor.T.astype(np.float32)
    size = np.linalg.norm(world, axis=2, keepdims=True)
    world = (world / np.where(size > 0.0, size, 1.0)).astype(np.float32)
    same = (np.abs(world - world[:, :1]).max(axis=(1, 2)) < 1e-6) & (size.min(axis=(1, 2)) > 0.0)
    smooth = ~same | ~_matches_face(mesh, same)
    row = np.where(smooth, np.cumsum(smooth) - 1, -1).astype(np.int32)
    return row, world[smooth]


def _matches_face(mesh: Mesh, candidates: np.ndarray) -> np.ndarray:
    """Whether the (constant) corner normal of candidate triangles is the face's own; (T,) bool, True elsewhere."""
    out = np.ones(len(candidates), bool)
    index = np.flatnonzero(candidates)
    corner = mesh.positions[mesh.triangles[index]].astype(np.float64)
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(face, axis=1)
    cosine = (face * mesh.normals[index, 0]).sum(axis=1)
    out[index] = cosine > (1.0 - 1e-5) * size
    return out


def _concatenate(parts: list[Geometry]) -> Geometry:
    """Join the instances' parts, shifting vertex and normal indices."""
    if not parts:
        zero = np.zeros(0, np.int32)
        return Geometry(
            np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), zero, np.zeros((0, 3, 3), np.float32), zero, zero
        )
    vertex = np.cumsum([0] + [len(part.positions) for part in parts])
    normal = np.cumsum([0] + [len(part.normals) for part in parts])
    rows = [
        np.where(part.normal_row >= 0, part.normal_row + shift, -1) for part, shift in zip(parts, normal, strict=False)
    ]
    return Geometry(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.triangles + shift for part, shift in zip(parts, vertex, strict=False)]).astype(np.int32),
        np.concatenate(rows).astype(np.int32),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.material for part in parts]).astype(np.int32),
        np.concatenate([part.instance for part in parts]).astype(np.int32),
    )
