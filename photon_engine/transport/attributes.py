"""What textures ask about a hit: UVs, tangents, attributes, generated and object coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.flatten import Flattened
from ..geometry.intersect import Hits
from ..scene.data import Mesh, SceneData
from ..shading.points import ShadePoints


def fill_attributes(points: ShadePoints, needs: frozenset[str], scene: SceneData, flat: Flattened, hits: Hits) -> None:
    """Fill in the fields of points that the program's needs name."""
    lookup = _Lookup(scene, flat, hits.prim, _weights(flat, points.instance, hits.u, hits.v, 1.0), points.instance)
    for need in sorted(needs):
        kind, _, name = need.partition(":")
        if kind == "uv":
            points.uvs[name] = lookup.corners(lambda mesh, layer=name: mesh.uvs.get(layer or mesh.active_uv), 2)
        elif kind == "tangent":
            points.tangents[name] = lookup.corners(
                lambda mesh, layer=name: mesh.tangents.get(layer or mesh.active_uv), 4, (1.0, 0.0, 0.0, 1.0)
            )
        elif kind == "attribute":
            points.attributes[name] = lookup.attribute(name)
        elif kind == "generated":
            points.generated = lookup.vertices(generated_coordinates)
        elif kind == "normal_local":
            points.normal_local = lookup.corners(corner_normals, 3)
        elif kind == "object":
            points.object = _object_coordinates(points)
        elif kind == "camera":
            points.camera = points.to_space(scene.camera.from_world())
            points.window = (*scene.camera.window, float(scene.camera.kind == "PERSP"))
        elif kind == "corners":
            points.corners = corners_from(points.p, flat, hits.prim)
        elif kind == "island":
            points.island_random = lookup.faces(lambda mesh: mesh.island_random)


def corners_from(p: np.ndarray, flat: Flattened, prim: np.ndarray) -> np.ndarray:
    """Corners of triangles (n, 3, 3) f32 from recentred points p (n, 3) [m]."""
    corner = flat.geometry.positions[flat.geometry.triangles[prim]].astype(np.float64)
    return (corner - p[:, None, :]).astype(np.float32)


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


def _weights(flat: Flattened, instance: np.ndarray, u: np.ndarray, v: np.ndarray, total: float) -> np.ndarray:
    """Weights (n, 3) f32 of the corners in the mesh: total - u - v, u, v; mirrored instances have 1 and 2 swapped."""
    swap = flat.mirrored[instance]
    u, v = np.where(swap, v, u), np.where(swap, u, v)
    return np.stack([total - u - v, u, v], axis=1).astype(np.float32)


class Neighbours:
    """Points a pixel's width beside the hits, in the planes of their triangles, for bump: see `points.Around`.

    Coordinates are continued linearly beyond the triangle, as ray differentials do.
    """

    def __init__(
        self, points: ShadePoints, needs: frozenset[str], scene: SceneData, flat: Flattened, hits: Hits
    ) -> None:
        self.points = points
        self.needs = needs
        self.scene, self.flat, self.prim = scene, flat, hits.prim
        self.dp = tangents_of_length(points.facing(points.ng), pixel_width(scene, points))
        self._found: dict[tuple[int, float], ShadePoints] = {}

    def at(self, axis: int, width: float) -> ShadePoints:
        """The points moved by width dp[axis]."""
        key = (axis, width)
        if key not in self._found:
            self._found[key] = self._moved(self.dp[axis] * np.float32(width))
        return self._found[key]

    def _moved(self, offset: np.ndarray) -> ShadePoints:
        """The points moved by offset (n, 3) within the planes of their triangles."""
        points, geometry = self.points, self.flat.geometry
        corner = geometry.positions[geometry.triangles[self.prim]].astype(np.float64)
        u, v = in_triangle(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0], offset)
        weights = _weights(self.flat, points.instance, u, v, 0.0)
        lookup = _Lookup(self.scene, self.flat, self.prim, weights, points.instance)
        moved = replace(points, p=points.p + offset, uvs={}, attributes={})
        for need in self.needs:
            kind, _, name = need.partition(":")
            if kind == "uv":
                slope = lookup.corners(lambda mesh, layer=name: mesh.uvs.get(layer or mesh.active_uv), 2)
                moved.uvs[name] = points.uvs[name] + slope
            elif kind == "attribute":
                moved.attributes[name] = points.attributes[name] + lookup.attribute(name)
            elif kind == "generated":
                moved.generated = points.generated + lookup.vertices(generated_coordinates)
            elif kind == "object":
                moved.object = _object_coordinates(moved)
            elif kind == "corners":
                moved.corners = points.corners - offset[:, None, :]
        return moved


def tangents_of_length(n: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two vectors (n, 3) f32 of a length (n,) across the unit normals n and each other: (1, 1, 1) x n and n x that.

    The frame of Cycles' ray differentials, so that differences over a step err alike.
    """
    x, y, z = n.T
    even = (x == y) & (x == z)
    s = np.stack([z - y, np.where(even, x + z, x - z), np.where(even, -y - x, y - x)], axis=1)
    s /= np.linalg.norm(s, axis=1, keepdims=True)
    return (s * length[:, None]).astype(np.float32), (np.cross(n, s) * length[:, None]).astype(np.float32)


def in_triangle(e1: np.ndarray, e2: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(u, v) f64 with u e1 + v e2 = offset, all (n, 3), offset in the plane of the edges."""
    a, b, c = (np.einsum("ij,ij->i", x, y) for x, y in ((e1, e1), (e1, e2), (e2, e2)))
    p, q = np.einsum("ij,ij->i", e1, offset), np.einsum("ij,ij->i", e2, offset)
    det = np.maximum(a * c - b * b, 1e-300)
    return (c * p - b * q) / det, (a * q - b * p) / det


# shifts below this part of the coordinates would be lost in single precision
LEAST_SHIFT = 2e-5


def pixel_width(scene: SceneData, points: ShadePoints) -> np.ndarray:
    """Width (n,) f32 [m] of a camera's pixel at points, for photons too: both must see the same slopes.

    The mean of how far a step of a pixel across and up turns the ray, times its length: Cycles' compact differentials.
    """
    camera, frame = scene.camera, scene.frame
    across = (camera.window[1] - camera.window[0]) / frame.width
    up = (camera.window[3] - camera.window[2]) / frame.height
    width = np.full(len(points), 0.5 * (across + up))
    if camera.kind == "PERSP":
        away = points.p - (camera.matrix[:3, 3] - points.origin)
        size = np.linalg.norm(away, axis=1)
        axes = camera.matrix[:3, :3] / np.linalg.norm(camera.matrix[:3, :3], axis=0)
        d = (away / np.where(size > 0.0, size, 1.0)[:, None]) @ axes  # z: cosine of the angle to the view axis
        turn = across * np.sqrt(1.0 - np.minimum(d[:, 0] ** 2, 1.0)) + up * np.sqrt(1.0 - np.minimum(d[:, 1] ** 2, 1.0))
        width = 0.5 * turn * np.abs(d[:, 2]) * size
    return np.maximum(width, LEAST_SHIFT * np.abs(points.p).max(axis=1, initial=1e-3)).astype(np.float32)


class _Lookup:
    """Interpolates attributes of meshes at hits, mesh by mesh."""

    def __init__(self, scene: SceneData, flat: Flattened, prim: np.ndarray, weights, instance: np.ndarray) -> None:
        self.scene = scene
        self.n = len(prim)
        mesh = np.array([item.mesh for item in scene.instances], np.int32)
        self.weights = weights
        self.triangle = prim - flat.first_triangle[instance]
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

    def attribute(self, name: str) -> np.ndarray:
        """(n, 5) f32: an attribute's rgba and its value as a number; opaque black where a mesh does not have it.

        One number is repeated, two are x and y (the number is x), of three and four the number is the mean of rgb;
        what has no alpha is opaque.
        """
        out = np.zeros((self.n, 5), np.float32)
        out[:, 3] = self.weights.sum(axis=1)
        for m, index in self.groups:
            data = self.scene.meshes[m].attributes.get(name)
            if data is None:
                continue
            values = np.einsum("nc,ncd->nd", self.weights[index], data[self.triangle[index]])
            width = values.shape[1]
            rows = np.zeros((len(index), 5), np.float32)
            rows[:, : max(width, 3)] = values if width != 2 else np.column_stack([values, np.zeros(len(values))])
            rows[:, 3] = values[:, 3] if width == 4 else out[index, 3]
            rows[:, 4] = values[:, 0] if width < 3 else rows[:, :3].mean(axis=1)
            out[index] = rows
        return out

    def faces(self, get) -> np.ndarray:
        """(n,) f32 from per-triangle data get(mesh) (T,); zeros where a mesh has none."""
        out = np.zeros(self.n, np.float32)
        for m, index in self.groups:
            data = get(self.scene.meshes[m])
            if data is not None:
                out[index] = data[self.triangle[index]]
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
    """The points in the space of their objects."""
    table = points.objects
    local = points.p - (table.location - points.origin).astype(np.float32)[points.instance]
    return np.einsum("nij,nj->ni", table.inverse[points.instance], local).astype(np.float32)
