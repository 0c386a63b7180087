"""What can be said of a scene before rendering: errors that stop it, and warnings of a black picture."""

from __future__ import annotations

import numpy as np

from ..issues import IssueLog, RenderError
from ..scene.archive import physical_memory
from ..scene.data import Graph, Material, SceneData

BYTES_PER_PIXEL = 450  # of the film's sums, one pass, and the finished pictures

# nodes that give light -> inputs of which none may be zero
EMITTERS = {
    "ShaderNodeEmission": ("Strength", "Color"),
    "ShaderNodeBackground": ("Strength", "Color"),
    "ShaderNodeBsdfPrincipled": ("Emission Strength", "Emission Color"),
}


def check_scene(scene: SceneData, issues: IssueLog) -> None:
    """Raise a RenderError when there is no picture to make; warn when it will be black."""
    frame = scene.frame
    if frame.width < 1 or frame.height < 1:
        size = f"{frame.width} x {frame.height}"
        raise RenderError(scene.name, f"the resolution is {size}", "set both above 0, and the percentage too")
    if frame.x1 <= frame.x0 or frame.y1 <= frame.y0:
        raise RenderError(scene.name, "the render border is empty", "draw it inside the camera's frame, or clear it")
    needed, there = BYTES_PER_PIXEL * (frame.x1 - frame.x0) * (frame.y1 - frame.y0), physical_memory()
    if needed > there:
        size = f"{frame.x1 - frame.x0} x {frame.y1 - frame.y0} pixels need {needed / 2**30:.0f} GB of memory"
        raise RenderError(scene.name, f"{size}, there are {there / 2**30:.0f}", "render fewer pixels, or parts of them")
    lit = is_lit(scene)
    if not scene.instances and not has_world(scene):
        raise RenderError(scene.name, "there is nothing to render", "add objects, or enable them for rendering")
    if not lit:
        issues.warn(scene.name, "there is no light: the picture will be black", "add a lamp or light the world")


def check_picture(scene: SceneData, combined: np.ndarray, issues: IssueLog) -> None:
    """Warn of a finished picture (h, w, c) that is black all over though the scene has light."""
    if not np.any(combined[:, :, :3]) and is_lit(scene):
        message = "no light reaches anything that the camera sees: the picture is black"
        issues.warn(scene.camera.name, message, "see whether the camera is inside an object, or behind a wall")


def is_lit(scene: SceneData) -> bool:
    """Whether a lamp, the world or an emissive material may give light (an upper bound)."""
    if any(any(light.strength) for light in scene.lights) or has_world(scene):
        return True
    used = {slot for instance in scene.instances for slot in instance.materials if slot >= 0}
    return any(emits(scene.materials[i]) for i in used)


def has_world(scene: SceneData) -> bool:
    """Whether the world may give light."""
    return any(scene.world.color) or (scene.world.graph is not None and graph_emits(scene.world.graph))


def emits(material: Material) -> bool:
    """Whether a material may give light."""
    return graph_emits(material.graph)


def graph_emits(graph: Graph) -> bool:
    """Whether a node may emit: its strength is linked or above 0, and its colour is not black."""
    sources = (node for node in graph.nodes if node.type in EMITTERS)
    return any(all(_nonzero(node, name) for name in EMITTERS[node.type]) for node in sources)


def _nonzero(node, name: str) -> bool:
    """Whether an input is linked or not zero."""
    socket = node.inputs.get(name)
    if socket is None:
        return False
    if socket.node >= 0 or socket.value is None:
        return True
    value = socket.value
    return any(list(value)[:3]) if hasattr(value, "__iter__") else bool(value)
