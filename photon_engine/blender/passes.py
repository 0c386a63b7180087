"""The passes of a view layer: which are asked for, and their registration with Blender."""

from __future__ import annotations

import bpy

from ..film.passes import PASSES, RenderPass
from .properties import pass_property


def wanted_passes(layer: bpy.types.ViewLayer) -> list[RenderPass]:
    """The passes that a view layer asks for; Combined always."""
    group = layer.photon_map
    return [item for item in PASSES if item.name == "Combined" or getattr(group, pass_property(item.name))]


def wanted_outputs(layer: bpy.types.ViewLayer) -> frozenset[str]:
    """Names of the pictures to compute: Combined only when it is switched on, though Blender always has it."""
    wanted = {item.name for item in wanted_passes(layer)}
    return frozenset(wanted if layer.use_pass_combined else wanted - {"Combined"})


def register_passes(engine: bpy.types.RenderEngine, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> None:
    """Tell Blender of them, for the result's channels and the compositor's sockets."""
    for item in wanted_passes(layer):
        engine.register_pass(scene, layer, item.name, item.channels, item.ids, item.kind)
