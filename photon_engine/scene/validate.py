"""Whether a scene is consistent: shapes, types and indices that kernels rely on without looking."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..issues import RenderError
from .data import BEAM, Graph, Image, Instance, Light, Mesh, SceneData
from .typed import is_number

FLOAT = (np.float32,)  # what kernels are compiled for
WHOLE = (np.int32, np.uint32, np.int64)
ANY = (np.float64, *FLOAT, *WHOLE)
SHAPES = ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE")
DISPLACEMENTS = ("BUMP", "DISPLACEMENT", "BOTH")
MOST_PIXELS = 1 << 20  # along one side


def check_scene(scene: SceneData) -> None:
    """Raise a RenderError naming the first record whose arrays or indices do not fit."""
    for mesh in scene.meshes:
        check_mesh(mesh)
    for instance in scene.instances:
        _check_instance(instance, scene)
    for light in scene.lights:
        _check_light(light, len(scene.images))
    for material in scene.materials:
        _check_graph(material.name, material.graph, len(scene.images))
        _require(material.displacement in DISPLACEMENTS, material.name, "its displacement is of no known kind")
    if scene.world.graph is not None:
        _check_graph(scene.world.name, scene.world.graph, len(scene.images))
    for image in scene.images:
        _check_image(image, len(scene.images))
    _check_view(scene)


def _check_view(scene: SceneData) -> None:
    """Camera and frame."""
    frame, camera = scene.frame, scene.camera
    inside = 0 <= frame.x0 < frame.x1 <= frame.width and 0 <= frame.y0 < frame.y1 <= frame.height
    _require(inside, scene.name, "the render border lies outside the frame or is empty")
    _require(max(frame.width, frame.height) <= MOST_PIXELS, scene.name, f"the frame is wider than {MOST_PIXELS} pixels")
    _require(frame.filter_width >= 0.0, scene.name, "the pixel filter's width is negative")
    _require(_fits(camera.matrix, (4, 4)), camera.name, "its matrix is not 4 by 4 finite numbers")
    _require(camera.kind in ("PERSP", "ORTHO"), camera.name, f"'{camera.kind}' is no kind of camera")
    left, right, bottom, top = camera.window
    _require(left < right and bottom < top, camera.name, "its window is empty")
    _require(camera.clip_start < camera.clip_end, camera.name, "it clips everything")
    _require(camera.aperture_radius >= 0.0 and camera.aperture_ratio > 0.0, camera.name, "its aperture is negative")


def _check_image(image: Image, n_images: int) -> None:
    """Shape and type of the pixels; infinite ones are legal in high dynamic range files. Tiles name images."""
    pixels = image.pixels
    good = pixels is None or (pixels.ndim == 3 and pixels.shape[2] == 4 and pixels.dtype in (np.float32, np.uint8))
    _require(good, image.name, "pixels are not (H, W, 4) of single precision or bytes")
    good = all(0 <= index < n_images for index in image.tiles.values())
    _require(good, image.name, "a tile names an image that is not there")


def check_mesh(mesh: Mesh) -> None:
    """Raise a RenderError when a mesh's arrays do not fit together."""
    name = mesh.name
    _require(_fits(mesh.positions, (None, 3), FLOAT), name, "positions are not (V, 3) finite single numbers")
    _require(_fits(mesh.triangles, (None, 3), WHOLE), name, "triangles are not (T, 3) indices")
    n_verts, n_tris = len(mesh.positions), len(mesh.triangles)
    if n_tris:
        low, high = int(mesh.triangles.min()), int(mesh.triangles.max())
        _require(0 <= low and high < n_verts, name, f"a triangle names vertex {low if low < 0 else high} of {n_verts}")
    optional = (
        ("normals", mesh.normals, (n_tris, 3, 3), FLOAT),
        ("material_index", mesh.material_index, (n_tris,), WHOLE),
        ("generated", mesh.generated, (n_verts, 3), FLOAT),
        ("island_random", mesh.island_random, (n_tris,), FLOAT),
    )
    for label, array, shape, types in optional:
        good = array is None or _fits(array, shape, types)
        _require(good, name, f"{label} do not have the shape {shape} and type {types[0].__name__}")
    slots = mesh.material_index
    _require(slots is None or not len(slots) or slots.min() >= 0, name, "a triangle names a material slot below 0")
    for table, width in ((mesh.uvs, 2), (mesh.attributes, None), (mesh.tangents, 4)):
        for label, array in table.items():
            good = _fits(array, (n_tris, 3, width), FLOAT) and 0 < array.shape[2] <= 4
            _require(good, name, f"'{label}' is not finite in single precision for each triangle corner")


def _check_instance(instance: Instance, scene: SceneData) -> None:
    """Indices and matrices of an instance."""
    _require(0 <= instance.mesh < len(scene.meshes), instance.name, f"mesh {instance.mesh} is not there")
    good = all(-1 <= m < len(scene.materials) for m in instance.materials)
    _require(good, instance.name, "it names a material that is not there")
    _require(len(instance.materials) > 0, instance.name, "it has no material slot")
    particle = instance.particle
    _require(particle is None or len(particle) == 13, instance.name, "a particle is not 13 numbers")
    for matrix in (instance.matrix, instance.object_matrix):
        _require(matrix is None or _fits(matrix, (4, 4)), instance.name, "a matrix is not 4 by 4 finite numbers")


def _check_light(light: Light, n_images: int) -> None:
    """Kind, matrix and nodes of a lamp."""
    _require(light.kind in ("POINT", "SPOT", "SUN", "AREA"), light.name, f"'{light.kind}' is no kind of light")
    _require(light.shape in SHAPES, light.name, f"'{light.shape}' is no shape of an area lamp")
    _require(_fits(light.matrix, (4, 4)), light.name, "its matrix is not 4 by 4 finite numbers")
    good = min(light.radius, *light.size, light.angle, light.spread, light.spot_size) >= 0.0
    _require(good, light.name, "a length or an angle of it is negative")
    beam = light.beam
    good = beam is None or (_fits(beam, BEAM, FLOAT) and beam.min() >= 0.0 and beam.max() <= 1.0)
    _require(good, light.name, f"its map of directions is not {BEAM} shares in single precision")
    if light.graph is not None:
        _check_graph(light.name, light.graph, n_images)


def _check_graph(name: str, graph: Graph, n_images: int) -> None:
    """Sockets name earlier nodes only: that is what makes one pass over the nodes enough."""
    for i, node in enumerate(graph.nodes):
        image = node.props.get("image")
        good = image is None or (type(image) is int and 0 <= image < n_images)
        _require(good, name, f"node '{node.name}' names an image that is not there")
        for label, socket in node.inputs.items():
            where = f"node '{node.name}', input '{label}'"
            _require(-1 <= socket.node < i, name, f"{where} is linked out of order")
            _require(_is_socket_value(socket.value), name, f"{where} holds neither a number nor a vector")
    for socket in (graph.surface, graph.volume, graph.displacement):
        _require(socket is None or -1 <= socket.node < len(graph.nodes), name, "its output is linked to no node")


def _is_socket_value(value: Any) -> bool:
    """Whether it is what an unlinked input can hold: nothing, one number, or three to four."""
    if value is None:
        return True
    parts = value if isinstance(value, list | tuple) else np.atleast_1d(value)
    return len(parts) in (1, 3, 4) and all(isinstance(part, bool | np.bool_) or is_number(part) for part in parts)


def _fits(array: Any, shape: tuple[int | None, ...], types: tuple = ANY) -> bool:
    """Whether it is a finite numeric array of that shape, None standing for any length, and of one of the types."""
    if not isinstance(array, np.ndarray) or array.dtype not in types or array.ndim != len(shape):
        return False
    if any(want is not None and have != want for have, want in zip(array.shape, shape, strict=True)):
        return False
    return array.dtype.kind != "f" or bool(np.isfinite(array.sum(dtype=np.float64)) or np.isfinite(array).all())


def _require(good: bool, name: str, message: str) -> None:
    """A RenderError unless good."""
    if not good:
        raise RenderError(name or "scene", message, "extract or save the scene again")
