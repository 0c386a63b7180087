"""Meshes of the evaluated scene as arrays.

Blender's element-wise accessors cost 100 ms and more for a million triangles; attributes and one look at the memory
behind ``loop_triangles`` cost a few milliseconds. Each fast path is guarded and has a slow twin.
"""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np

from ..geometry.islands import island_roots
from ..geometry.pointiness import NAME as POINTINESS
from ..geometry.pointiness import pointiness
from ..issues import IssueLog
from ..scene.data import Mesh
from ..shading.procedural.white import hash_words
from ..shading.textures import linear_to_srgb, srgb_to_linear
from .tangents import corner_tangents


class MeshNeeds(NamedTuple):
    """What the materials on a mesh read beyond positions and normals."""

    generated: bool = False
    attributes: frozenset[str] = frozenset()  # "" is the active colour attribute
    tangents: frozenset[str] = frozenset()  # UV layers; "" is the one active for render
    uvs: frozenset[str] = frozenset()  # as above; tangents need theirs too
    islands: bool = False  # Random Per Island


def extract_mesh(me: Any, owner: str, needs: MeshNeeds, issues: IssueLog) -> Mesh | None:
    """Arrays of an evaluated ``bpy.types.Mesh``; None (and an issue) when no triangle is left.

    ``owner`` is the object named in issues.
    """
    n_tris = len(me.loop_triangles)
    if n_tris == 0:
        issues.info(owner, "has no faces and is not rendered")
        return None
    positions = read_positions(me)
    loops = triangle_loops(me)
    triangles = corner_vertices(me)[loops]
    keep = finite_triangles(positions, triangles)
    if keep is not None:
        count = int(n_tris - keep.sum())
        issues.warn(owner, f"{count} faces with infinite or undefined vertices are left out", "repair the mesh")
        if count == n_tris:
            return None
        loops, triangles = loops[keep], triangles[keep]
        positions = np.where(np.isfinite(positions), positions, np.float32(0.0))
    faces = triangle_faces(me) if _needs_faces(me) else None
    if keep is not None and faces is not None:
        faces = faces[keep]
    mesh = Mesh(
        name=me.name,
        positions=positions,
        triangles=triangles,
        normals=corner_normals(me, positions, triangles, loops, faces),
        material_index=material_indices(me, faces),
        generated=generated_coordinates(me) if needs.generated else None,
    )
    if needs.islands:
        mesh.island_random = island_random(me, triangles)
    _add_uvs(mesh, me, (loops, needs.uvs | needs.tangents), owner, issues)
    for name in needs.attributes:
        _add_attribute(mesh, me, name, (loops, triangles, keep), owner, issues)
    for layer in needs.tangents:
        uv = mesh.uvs.get(layer or mesh.active_uv)
        if uv is not None:
            mesh.tangents[layer or mesh.active_uv] = corner_tangents(positions, triangles, mesh.normals, uv)
    return mesh


def read_positions(me: Any) -> np.ndarray:
    """Vertex positions, (V, 3) f32, local."""
    out = np.empty(len(me.vertices) * 3, np.float32)
    attribute = me.attributes.get("position")
    if attribute is not None and len(attribute.data) * 3 == len(out):
        attribute.data.foreach_get("vector", out)
    else:
        me.vertices.foreach_get("co", out)
    return out.reshape(-1, 3)


def corner_vertices(me: Any) -> np.ndarray:
    """Vertex of each face corner, (L,) i32."""
    out = np.empty(len(me.loops), np.int32)
    attribute = me.attributes.get(".corner_vert")
    if attribute is not None and len(attribute.data) == len(out):
        attribute.data.foreach_get("value", out)
    else:
        me.loops.foreach_get("vertex_index", out)
    return out


def triangle_loops(me: Any) -> np.ndarray:
    """Face corners of each triangle, (T, 3) i32."""
    tris = me.loop_triangles
    n = len(tris)
    size = 3 * ctypes.sizeof(ctypes.c_int32)
    first, last = tris[0].as_pointer(), tris[n - 1].as_pointer()
    if first and last - first == size * (n - 1):
        view = np.ctypeslib.as_array((ctypes.c_int32 * (3 * n)).from_address(first)).reshape(n, 3)
        # the memory is what it should be only if Blender's own accessor agrees
        if all(tuple(view[i]) == tuple(tris[i].loops) for i in {0, n // 3, n // 2, n - 1}):
            return view.copy()
    return triangle_loops_slow(me)


def triangle_loops_slow(me: Any) -> np.ndarray:
    """Twin of ``triangle_loops`` through Blender's element-wise accessor."""
    out = np.empty(len(me.loop_triangles) * 3, np.int32)
    me.loop_triangles.foreach_get("loops", out)
    return out.reshape(-1, 3)


def triangle_faces(me: Any) -> np.ndarray:
    """Face of each triangle, (T,) i32."""
    out = np.empty(len(me.loop_triangles), np.int32)
    if len(me.loop_triangle_polygons) == len(out):
        me.loop_triangle_polygons.foreach_get("value", out)
    else:
        me.loop_triangles.foreach_get("polygon_index", out)
    return out


def finite_triangles(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
    """None when every vertex is finite, else (T,) bool: triangles whose three vertices are."""
    # one sum finds any NaN or infinity without a boolean array of the same size
    if np.isfinite(positions.sum(dtype=np.float64)):
        return None
    good = np.isfinite(positions).all(axis=1)
    return good[triangles].all(axis=1)


def triangle_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit geometric normals, (T, 3) f32; a degenerate triangle gets (0, 0, 1)."""
    a, b, c = (positions[triangles[:, i]].astype(np.float64) for i in range(3))
    n = np.cross(b - a, c - a)
    length = np.linalg.norm(n, axis=1, keepdims=True)
    return np.where(length > 0.0, n / np.where(length > 0.0, length, 1.0), (0.0, 0.0, 1.0)).astype(np.float32)


def corner_normals(
    me: Any, positions: np.ndarray, triangles: np.ndarray, loops: np.ndarray, faces: np.ndarray | None
) -> np.ndarray | None:
    """Shading normals per triangle corner, (T, 3, 3) f32; None when all faces are flat.

    Faces marked sharp are flat whatever their corner normals say, as in Cycles.
    """
    if me.normals_domain == "FACE":
        return None
    out = np.empty(len(me.loops) * 3, np.float32)
    me.corner_normals.foreach_get("vector", out)
    normals = np.take(out.reshape(-1, 3), loops, axis=0)
    flat = _sharp_triangles(me, faces)
    # squared lengths in one pass; Blender gives zero normals around degenerate faces
    bad = ~(np.einsum("tcx,tcx->tc", normals, normals) > 0.25)
    if flat is not None:
        bad |= flat[:, None]
    if bad.any():
        rows = np.flatnonzero(bad.any(axis=1))
        geometric = np.broadcast_to(triangle_normals(positions, triangles[rows])[:, None, :], (len(rows), 3, 3))
        normals[rows] = np.where(bad[rows, :, None], geometric, normals[rows])
    return normals


def material_indices(me: Any, faces: np.ndarray | None) -> np.ndarray | None:
    """Slot of each triangle, (T,) i32; None: all slot 0."""
    attribute = _face_attribute(me, "material_index", "INT")
    if attribute is None or faces is None:
        return None
    slots = np.empty(len(attribute.data), np.int32)
    attribute.data.foreach_get("value", slots)
    if not slots.any():
        return None
    return np.maximum(slots, 0)[faces]


def worn_slots(me: Any) -> frozenset[int]:
    """The slots that faces name; none of a mesh without faces."""
    attribute = _face_attribute(me, "material_index", "INT")
    if attribute is None or not len(attribute.data):
        return frozenset({0} if len(me.polygons) else ())
    slots = np.empty(len(attribute.data), np.int32)
    attribute.data.foreach_get("value", slots)
    return frozenset(np.unique(np.maximum(slots, 0)).tolist())


def generated_coordinates(me: Any) -> np.ndarray:
    """Generated texture coordinates, (V, 3) f32: the undeformed position in the mesh's texture space.

    The texture space (a box, centre ``texspace_location``, half size ``texspace_size``) maps to [0, 1]^3.
    """
    out = np.empty(len(me.vertices) * 3, np.float32)
    me.vertices.foreach_get("undeformed_co", out)
    centre = np.array(me.texspace_location, np.float64)
    half = np.array(me.texspace_size, np.float64)
    scale = np.where(half != 0.0, 0.5 / np.where(half != 0.0, half, 1.0), 0.0)
    return (out.reshape(-1, 3) * scale - (centre * scale - 0.5)).astype(np.float32)


def island_random(me: Any, triangles: np.ndarray) -> np.ndarray:
    """A number in [0, 1] for each connected part, (T,) f32: the hash of the vertex that Cycles lets stand for it."""
    edges = np.empty(len(me.edges) * 2, np.int32)
    me.edges.foreach_get("vertices", edges)
    roots = island_roots(len(me.vertices), edges.reshape(-1, 2))[triangles[:, 0]]
    return hash_words(roots)


def vertex_pointiness(me: Any, positions: np.ndarray) -> np.ndarray:
    """Geometry > Pointiness of each vertex, (V,) f32; positions (V, 3)."""
    normals, edges = np.empty(len(me.vertices) * 3, np.float32), np.empty(len(me.edges) * 2, np.int32)
    me.vertex_normals.foreach_get("vector", normals)
    me.edges.foreach_get("vertices", edges)
    return pointiness(positions, normals.reshape(-1, 3), edges.reshape(-1, 2))


def _needs_faces(me: Any) -> bool:
    """Whether some face attribute must be spread over triangles."""
    return any(_face_attribute(me, name, kind) is not None for name, kind in FACE_ATTRIBUTES)


FACE_ATTRIBUTES = (("material_index", "INT"), ("sharp_face", "BOOLEAN"))


def _face_attribute(me: Any, name: str, kind: str) -> Any | None:
    """A face attribute of that name and type."""
    attribute = me.attributes.get(name)
    if attribute is None or attribute.domain != "FACE" or attribute.data_type != kind:
        return None
    return attribute


def _sharp_triangles(me: Any, faces: np.ndarray | None) -> np.ndarray | None:
    """(T,) bool: triangles of faces that are shaded flat; None: none is."""
    attribute = _face_attribute(me, "sharp_face", "BOOLEAN")
    if attribute is None or faces is None:
        return None
    sharp = np.empty(len(attribute.data), bool)
    attribute.data.foreach_get("value", sharp)
    return sharp[faces] if sharp.any() else None


def _add_uvs(mesh: Mesh, me: Any, wanted: tuple[np.ndarray, frozenset[str]], owner: str, issues: IssueLog) -> None:
    """The UV layers that are wanted, and which one is active for render. wanted : loops (T, 3), names."""
    loops, names = wanted
    mesh.active_uv = next((layer.name for layer in me.uv_layers if layer.active_render), "")
    for layer in me.uv_layers:
        if layer.name not in names and not (layer.name == mesh.active_uv and "" in names):
            continue
        flat = np.empty(len(me.loops) * 2, np.float32)
        layer.uv.foreach_get("vector", flat)
        if not np.isfinite(flat.sum(dtype=np.float64)):
            issues.warn(owner, f"UV map '{layer.name}' holds undefined coordinates, 0 is used", "unwrap again")
            flat = np.where(np.isfinite(flat), flat, np.float32(0.0))
        # a complex number is a pair that numpy gathers in one go
        mesh.uvs[layer.name] = np.take(flat.view(np.complex64), loops).view(np.float32).reshape(*loops.shape, 2)


COMPONENTS = {
    "FLOAT": ("value", 1), "INT": ("value", 1), "INT8": ("value", 1), "BOOLEAN": ("value", 1),
    "FLOAT2": ("vector", 2), "FLOAT_VECTOR": ("vector", 3), "FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4),
    "QUATERNION": ("value", 4), "INT16_2D": ("value", 2), "INT32_2D": ("value", 2),
}  # fmt: skip
READ_TYPES = {"INT": np.int32, "INT8": np.int32, "BOOLEAN": bool, "INT16_2D": np.int32, "INT32_2D": np.int32}


def _add_attribute(mesh: Mesh, me: Any, name: str, corners: tuple, owner: str, issues: IssueLog) -> None:
    """A named attribute (or the active colour) per triangle corner; UV layers are already there."""
    if name == POINTINESS:
        mesh.attributes[name] = vertex_pointiness(me, mesh.positions)[corners[1]][:, :, None]
        return
    source = name
    if not name:
        source = me.color_attributes[me.color_attributes.render_color_index].name if me.color_attributes else ""
    attribute = me.attributes.get(source) if source else None
    if attribute is None:
        return
    if attribute.data_type not in COMPONENTS:
        issues.warn(owner, f"attribute '{source}' has the type {attribute.data_type}, which is not supported")
        return
    key, width = COMPONENTS[attribute.data_type]
    values = np.empty(len(attribute.data) * width, READ_TYPES.get(attribute.data_type, np.float32))
    attribute.data.foreach_get(key, values)
    values = values.reshape(-1, width).astype(np.float32)
    if attribute.domain == "EDGE":
        mesh.attributes[name] = edges_to_points(values, attribute.data_type, me)[corners[1]]
        return
    mesh.attributes[name] = _to_corners(values, attribute.domain, me, corners)


def edges_to_points(values: np.ndarray, kind: str, me: Any) -> np.ndarray:
    """Values of edges (E, C) at the points, (V, C) f32, as Blender does it: the mean over a point's edges.

    Whole numbers are rounded, booleans are true when any edge is, byte colours are mixed under
    their sRGB curve and cut to bytes.
    """
    if kind == "BYTE_COLOR":
        values = np.column_stack([linear_to_srgb(values[:, :3]), values[:, 3]])
    ends = np.empty(len(me.edges) * 2, np.int32)
    me.edges.foreach_get("vertices", ends)
    total = np.zeros((len(me.vertices), values.shape[1]))
    np.add.at(total, ends, np.repeat(values, 2, axis=0))
    mean = total / np.maximum(np.bincount(ends, minlength=len(me.vertices))[:, None], 1)
    if kind == "BOOLEAN":
        mean = np.ceil(mean)
    elif kind.startswith("INT"):
        mean = np.copysign(np.floor(np.abs(mean) + 0.5), mean)
    elif kind == "BYTE_COLOR":
        mean = np.floor(mean * 255.0 + 1e-3) / 255.0
        mean = np.column_stack([srgb_to_linear(mean[:, :3]), mean[:, 3]])
    return mean.astype(np.float32)


def _to_corners(values: np.ndarray, domain: str, me: Any, corners: tuple) -> np.ndarray:
    """Values of a domain spread over triangle corners, (T, 3, C)."""
    loops, triangles, keep = corners
    if domain == "CORNER":
        return values[loops]
    if domain == "POINT":
        return values[triangles]
    faces = triangle_faces(me)
    faces = faces if keep is None else faces[keep]
    return np.repeat(values[faces][:, None, :], 3, axis=1)
