"""What textures ask about a hit: UVs, tangents, attributes, generated and object coordinates."""

from __future__ import annotations

import numpy as np

from ..geometry.flatten import Flattened
from ..geometry.intersect import Hits
from ..scene.data import Mesh, SceneData
from ..shading.points import ShadePoints


def fill_attributes(points: ShadePoints, needs: frozenset[str], scene: SceneData, flat: Flattened, hits: Hits) -> None:
    """Fill in the fields of points that the program's needs name."""
    lookup = _Lookup(scene, flat, hits, points.instance)
    for need in sorted(needs):
        kind, _, name = need.partition(":")
        if kind == "uv":
            points.uvs[name] = lookup.corners(lambda mesh, layer=name: mesh.uvs.get(layer or mesh.active_uv), 2)
        elif kind == "tangent":
            points.tangents[name] = lookup.corners(
                lambda mesh, layer=name: mesh.tangents.get(layer or mesh.active_uv), 4, (1.0, 0.0, 0.0, 1.0)
            )
        elif kind == "attribute":
            points.attributes[name] = lookup.corners(lambda mesh, key=name: mesh.attributes.get(key), 4)
        elif kind == "generated":
            points.generated = lookup.vertices(generated_coordinates)
        elif kind == "normal_local":
            points.normal_local = lookup.corners(corner_normals, 3)
        elif kind == "object":
            points.object = _object_coordinates(points)
        elif kind == "camera":
            to_camera = np.linalg.inv(scene.camera.matrix)
            to_camera[2] = -to_camera[2]
            points.camera = to_camera.astype(np.float32)


def generated_coordinates(mesh: Mesh) -> np.ndarray:
    """Generated coordinates (V, 3): Blender's, or the position within the mesh's box."""
    if mesh.generated is not None:
        return mesh.generated
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    return (mesh.positions - low) / np.where(high > low, high - low, 1.0)


def corner_normals(mesh: Mesh) -> np.ndarray:
    """Corner normals (T, 3, 3) in mesh space; those of the faces when the mesh is flat."""
    if mesh.normals is not None:
        return mesh.normals
    corner = mesh.positions[mesh.triangles]
    face = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(face, axis=1, keepdims=True)
    return np.repeat((face / np.where(size > 0.0, size, 1.0))[:, None], 3, axis=1)


class _Lookup:
    """Interpolates attributes of meshes at hits, mesh by mesh."""

    def __init__(self, scene: SceneData, flat: Flattened, hits: Hits, instance: np.ndarray) -> None:
        self.scene = scene
        self.n = len(hits.prim)
        mesh = np.array([item.mesh for item in scene.instances], np.int32)
        # mirrored instances have corners 1 and 2 swapped
        swap = flat.mirrored[instance]
        u, v = np.where(swap, hits.v, hits.u), np.where(swap, hits.u, hits.v)
        self.weights = np.stack([1.0 - u - v, u, v], axis=1).astype(np.float32)
        self.triangle = hits.prim - flat.first_triangle[instance]
        which = mesh[instance]
        self.groups = [(m, np.flatnonzero(which == m)) for m in np.unique(which)]

    def corners(self, get, size: int, default: tuple[float, ...] = ()) -> np.ndarray:
        """(n, size) f32 from per-corner data get(mesh) (T, 3, c); zeros, or the default, where a mesh has none."""
        out = np.zeros((self.n, size), np.float32)
        if default:
            out[:] = default
        for m, index in self.groups:
            data = get(self.scene.meshes[m])
            if data is not None:
                values = data[self.triangle[index]]
                out[index, : values.shape[2]] = np.einsum("nc,ncd->nd", self.weights[index], values)
        return out

    def vertices(self, get) -> np.ndarray:
        """(n, 3) f32 from per-vertex data get(mesh) (V, 3)."""
        out = np.zeros((self.n, 3), np.float32)
        for m, index in self.groups:
            mesh = self.scene.meshes[m]
            values = get(mesh)[mesh.triangles[self.triangle[index]]]
            out[index] = np.einsum("nc,ncd->nd", self.weights[index], values)
        return out


def _object_coordinates(points: ShadePoints) -> np.ndarray:
    """World points in the space of their objects."""
    table = points.objects
    local = points.p - table.location[points.instance]
    return np.einsum("nij,nj->ni", table.inverse[points.instance], local).astype(np.float32)
