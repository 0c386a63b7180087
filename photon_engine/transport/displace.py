"""True displacement: vertices moved by what the material's displacement nodes say, before anything is traced.

As in Cycles, a vertex moves once, by the first triangle around it whose material displaces, in the place of the first
instance that wears the mesh; smooth normals are made anew from the moved faces. Meshes are not subdivided for it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.flatten import Flattened, flatten
from ..geometry.intersect import Hits
from ..geometry.surface import surface_points
from ..issues import IssueLog
from ..scene.data import Instance, Mesh, SceneData
from ..scene.memo import Memo
from ..shading.material import offset_program
from ..shading.points import ObjectTable, ShadePoints
from ..shading.program import Program
from .attributes import fill_attributes, generated_coordinates

SMOOTH = 1e-6  # a corner normal this far off its face's makes the face a smooth one


def displaced(scene: SceneData, issues: IssueLog, memo: Memo | None = None) -> SceneData:
    """The scene with its displaced meshes; the scene itself when no material moves vertices.

    memo : what the last render left; a mesh is moved anew when what its own displacement reads has changed
    """
    memo = memo or Memo()
    programs = [offset_program(material, scene.images, IssueLog()) for material in scene.materials]
    if not any(programs):
        return scene
    meshes = list(scene.meshes)
    place: dict[tuple, int] = {}
    instances = list(scene.instances)
    for i, item in enumerate(scene.instances):
        worn = {m: programs[m] for m in item.materials if m >= 0 and programs[m] is not None}
        if not worn:
            continue
        key = (item.mesh, *item.materials)
        if key not in place:
            name = "displaced", len(place)
            place[key] = len(meshes)
            alone = replace(scene, instances=[item])
            view = (scene.camera, scene.frame) if any("camera" in program.needs for program in worn.values()) else None
            inputs = (
                scene.meshes[item.mesh], replace(item, mesh=0), [scene.materials[m] for m in worn], tuple(scene.images),
                view,
            )  # fmt: skip
            meshes.append(memo.get(name, inputs, lambda own, s=alone: _moved(s, programs, own), issues))
        instances[i] = replace(item, mesh=place[key])
    return replace(scene, meshes=meshes, instances=instances) if place else scene


def _moved(scene: SceneData, programs: list[Program | None], issues: IssueLog) -> Mesh:
    """The mesh of the scene's only instance with its vertices moved."""
    flat = flatten(scene, IssueLog())
    objects = ObjectTable.from_instances(scene.instances)
    item = scene.instances[0]
    mesh = scene.meshes[item.mesh]
    worn = _material_of_triangles(mesh, item)
    offset = np.zeros(mesh.positions.shape)
    done = np.zeros(len(mesh.positions), bool)
    for m in np.unique(worn):
        program = programs[m] if m >= 0 else None
        if program is None:
            continue
        triangle = np.flatnonzero(worn == m)
        vertex, first = np.unique(mesh.triangles[triangle].ravel(), return_index=True)
        new = ~done[vertex]
        vertex, first = vertex[new], first[new]
        hits = _corner_hits(flat, triangle[first // 3], first % 3)
        world = np.asarray(program.run(_points(scene, flat, objects, program, hits)), np.float64).T
        offset[vertex] = np.broadcast_to(world, (len(vertex), 3)) @ np.linalg.pinv(item.matrix[:3, :3]).T
        done[vertex] = True
    bad = ~np.isfinite(offset).all(axis=1)
    if bad.any():
        issues.warn(item.name or mesh.name, f"{int(bad.sum())} vertices have a displacement that is no number",
                    "they stay where they are")  # fmt: skip
        offset[bad] = 0.0
    positions = (mesh.positions + offset).astype(np.float32)
    normals = _new_normals(mesh, positions, offset.any(axis=1))
    return replace(mesh, positions=positions, normals=normals, generated=generated_coordinates(mesh))


def _material_of_triangles(mesh: Mesh, item: Instance) -> np.ndarray:
    """Index of each triangle's material, (T,); -1: none."""
    slots = np.array(item.materials or [-1], np.int64)
    which = np.zeros(len(mesh.triangles), np.int64) if mesh.material_index is None else mesh.material_index
    return slots[np.clip(which, 0, len(slots) - 1)]


def _corner_hits(flat: Flattened, triangle: np.ndarray, corner: np.ndarray) -> Hits:
    """Hits exactly at corners of the only instance's triangles; mirrored ones have corners 1 and 2 swapped."""
    if flat.mirrored[0]:
        corner = np.array([0, 2, 1])[corner]
    u, v = (corner == 1).astype(np.float32), (corner == 2).astype(np.float32)
    return Hits(triangle.astype(np.int32), u, v, np.zeros(len(u), np.float32))


def _points(scene: SceneData, flat: Flattened, objects: ObjectTable, program: Program, hits: Hits) -> ShadePoints:
    """What the displacement's nodes may ask at the corners, seen from outside."""
    n = len(hits.prim)
    p, ng, ns = (np.empty((n, 3), np.float32) for _ in range(3))
    surface_points(flat.geometry, hits.prim, hits.u, hits.v, p, ng, ns)
    points = ShadePoints(
        p=p, origin=flat.origin, ng=ng, ns=ns, wo=ns, backfacing=np.zeros(n, bool),
        instance=np.zeros(n, np.int32), objects=objects, parametric=np.stack([hits.u, hits.v], axis=1),
    )  # fmt: skip
    fill_attributes(points, program.needs, scene, flat, hits)
    return points


def _new_normals(mesh: Mesh, positions: np.ndarray, moved: np.ndarray) -> np.ndarray | None:
    """Corner normals (T, 3, 3): the mean of the faces' at moved vertices of smooth faces, their own on flat faces."""
    if mesh.normals is None:
        return None
    before, after = face_normals(mesh.positions, mesh.triangles), face_normals(positions, mesh.triangles)
    smooth = (np.abs(mesh.normals - before[:, None]) > SMOOTH).any(axis=(1, 2))
    total = np.zeros(positions.shape)
    np.add.at(total, mesh.triangles[smooth], np.repeat(after[smooth][:, None], 3, axis=1))
    size = np.linalg.norm(total, axis=1, keepdims=True)
    total /= np.where(size > 0.0, size, 1.0)
    turned = moved.copy()  # a face turns when any of its corners moves, and its normal counts at all three
    turned[mesh.triangles[moved[mesh.triangles].any(axis=1)]] = True
    vertex = np.where(turned[mesh.triangles][..., None], total[mesh.triangles], mesh.normals)
    return np.where(smooth[:, None, None], vertex, after[:, None]).astype(np.float32)


def face_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals (T, 3) f64; zero for a triangle without area."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    n = np.cross(b - a, c - a)
    size = np.linalg.norm(n, axis=1, keepdims=True)
    return n / np.where(size > 0.0, size, 1.0)
