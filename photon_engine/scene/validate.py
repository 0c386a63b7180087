"""Whether a scene is consistent: shapes, types and indices that kernels rely on without looking."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..issues import RenderError
from .data import Graph, Instance, Light, Mesh, SceneData


def check_scene(scene: SceneData) -> None:
    """Raise a RenderError naming the first record whose arrays or indices do not fit."""
    for mesh in scene.meshes:
        check_mesh(mesh)
    for instance in scene.instances:
        _check_instance(instance, scene)
    for light in scene.lights:
        _check_light(light)
    for material in scene.materials:
        _check_graph(material.name, material.graph)
    if scene.world.graph is not None:
        _check_graph(scene.world.name, scene.world.graph)
    for image in scene.images:
        # infinite pixels are legal in high dynamic range files
        shape = (0, 0, 4) if image.pixels is None else np.shape(image.pixels)
        _require(len(shape) == 3 and shape[2] == 4, image.name, "pixels are not (H, W, 4)")
    frame = scene.frame
    inside = 0 <= frame.x0 < frame.x1 <= frame.width and 0 <= frame.y0 < frame.y1 <= frame.height
    _require(inside, scene.name, "the render border lies outside the frame or is empty")
    _require(_fits(scene.camera.matrix, (4, 4)), scene.camera.name, "its matrix is not 4 by 4 finite numbers")


def check_mesh(mesh: Mesh) -> None:
    """Raise a RenderError when a mesh's arrays do not fit together."""
    name = mesh.name
    _require(_fits(mesh.positions, (None, 3)), name, "positions are not (V, 3) finite numbers")
    _require(_fits(mesh.triangles, (None, 3)) and mesh.triangles.dtype.kind in "iu", name, "triangles are not (T, 3)")
    n_verts, n_tris = len(mesh.positions), len(mesh.triangles)
    if n_tris:
        low, high = int(mesh.triangles.min()), int(mesh.triangles.max())
        _require(0 <= low and high < n_verts, name, f"a triangle names vertex {low if low < 0 else high} of {n_verts}")
    optional = (
        ("normals", mesh.normals, (n_tris, 3, 3)),
        ("material_index", mesh.material_index, (n_tris,)),
        ("generated", mesh.generated, (n_verts, 3)),
        ("island_random", mesh.island_random, (n_tris,)),
    )
    for label, array, shape in optional:
        _require(array is None or _fits(array, shape), name, f"{label} do not have the shape {shape}")
    for table, width in ((mesh.uvs, 2), (mesh.attributes, None), (mesh.tangents, 4)):
        for label, array in table.items():
            _require(_fits(array, (n_tris, 3, width)), name, f"'{label}' is not finite for each triangle corner")


def _check_instance(instance: Instance, scene: SceneData) -> None:
    """Indices and matrices of an instance."""
    _require(0 <= instance.mesh < len(scene.meshes), instance.name, f"mesh {instance.mesh} is not there")
    good = all(-1 <= m < len(scene.materials) for m in instance.materials)
    _require(good, instance.name, "it names a material that is not there")
    for matrix in (instance.matrix, instance.object_matrix):
        _require(matrix is None or _fits(matrix, (4, 4)), instance.name, "a matrix is not 4 by 4 finite numbers")


def _check_light(light: Light) -> None:
    """Kind and matrix of a lamp."""
    _require(light.kind in ("POINT", "SPOT", "SUN", "AREA"), light.name, f"'{light.kind}' is no kind of light")
    _require(_fits(light.matrix, (4, 4)), light.name, "its matrix is not 4 by 4 finite numbers")


def _check_graph(name: str, graph: Graph) -> None:
    """Sockets name earlier nodes only: that is what makes one pass over the nodes enough."""
    for i, node in enumerate(graph.nodes):
        for label, socket in node.inputs.items():
            _require(-1 <= socket.node < i, name, f"node '{node.name}', input '{label}' is linked out of order")
    for socket in (graph.surface, graph.volume, graph.displacement):
        _require(socket is None or -1 <= socket.node < len(graph.nodes), name, "its output is linked to no node")


def _fits(array: Any, shape: tuple[int | None, ...]) -> bool:
    """Whether it is a finite numeric array of that shape; None stands for any length."""
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "biuf" or array.ndim != len(shape):
        return False
    if any(want is not None and have != want for have, want in zip(array.shape, shape, strict=True)):
        return False
    return array.dtype.kind != "f" or bool(np.isfinite(array.sum(dtype=np.float64)) or np.isfinite(array).all())


def _require(good: bool, name: str, message: str) -> None:
    """A RenderError unless good."""
    if not good:
        raise RenderError(name or "scene", message, "extract or save the scene again")
