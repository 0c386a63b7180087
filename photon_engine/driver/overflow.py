"""Whose numbers are so large that single precision may overflow: named when it did."""

from __future__ import annotations

import numpy as np

from ..issues import RenderError
from ..scene.data import Material, SceneData

LARGE = 1e20  # of light: a square of it is no number any more in single precision
SOURCES = ("ShaderNodeEmission", "ShaderNodeBackground")


def overflow_error(scene: SceneData, error: FloatingPointError) -> RenderError | None:
    """The user's problem behind values that are not finite; None when the scene gives no reason: it is a bug."""
    found = suspects(scene)
    if not found:
        return None
    names = ", ".join(f"'{name}' ({value:.3g})" for name, value in found[:5])
    remedy = f"lower what is largest: {names}"
    return RenderError(scene.name, f"light grew beyond what single precision holds: {error}", remedy)


def suspects(scene: SceneData) -> list[tuple[str, float]]:
    """(name, largest value) of lamps and images beyond LARGE, and of materials that give back more than arrives."""
    found = [(light.name, float(np.max(np.abs(light.strength)))) for light in scene.lights]
    found += [(image.name, _largest(image.pixels)) for image in scene.images]
    found = [(name, value) for name, value in found if value > LARGE]
    found += [(item.name, value) for item in scene.materials if (value := _gain(item)) > 1.0]
    return sorted(found, key=lambda pair: -pair[1])


def _largest(pixels: np.ndarray | None) -> float:
    """The largest finite value of an image in size."""
    if pixels is None or pixels.dtype.kind != "f" or not pixels.size:
        return 0.0
    finite = pixels[np.isfinite(pixels)]
    return float(np.abs(finite).max()) if len(finite) else 0.0


def _gain(material: Material) -> float:
    """The largest constant colour or strength that a node multiplies light with."""
    sockets = [
        socket
        for node in material.graph.nodes
        for name, socket in node.inputs.items()
        if socket.node < 0 and socket.value is not None and ("Color" in name or "Strength" in name)
        and (node.type not in SOURCES or np.max(np.abs(socket.value)) > LARGE)
    ]  # fmt: skip
    return max((float(np.max(socket.value)) for socket in sockets), default=0.0)
