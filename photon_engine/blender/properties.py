"""Blender properties made from settings.FIELDS, stored in the scene as ``scene.photon_map``."""

from __future__ import annotations

from typing import Any

import bpy

from ..film.passes import PASSES
from ..settings import FIELDS, Settings

UNITS = {"TIME": "TIME_ABSOLUTE"}  # ours -> Blender's unit
SUBTYPES = {"PIXEL": "PIXEL"}


def _property(item) -> Any:
    """The Blender property of one setting."""
    meta = item.metadata
    shared = {"name": meta["label"], "description": meta["text"], "default": item.default}
    if "items" in meta:
        return bpy.props.EnumProperty(items=list(meta["items"]), **shared)
    unit = meta.get("unit", "NONE")
    if isinstance(item.default, bool):
        return bpy.props.BoolProperty(**shared)
    limits = {"min": meta["min"], "max": meta["max"]}
    if isinstance(item.default, int):
        return bpy.props.IntProperty(**shared, **limits)
    return bpy.props.FloatProperty(
        unit=UNITS.get(unit, "NONE"), subtype=SUBTYPES.get(unit, "NONE"), precision=3, **shared, **limits
    )


class PhotonMapSettings(bpy.types.PropertyGroup):
    """How Photon Map renders this scene."""

    __annotations__ = {name: _property(item) for name, item in FIELDS.items()}


def pass_property(name: str) -> str:
    """The view-layer property that switches a pass on."""
    return f"use_{name.lower().replace(' ', '_')}"


class PhotonMapLayer(bpy.types.PropertyGroup):
    """Which pictures a view layer makes besides Combined."""

    __annotations__ = {
        pass_property(item.name): bpy.props.BoolProperty(
            name=item.name, description=item.text, default=item.usual, update=lambda self, context: _update_passes(self)
        )
        for item in PASSES
        if item.name != "Combined"
    }


def _update_passes(group: PhotonMapLayer) -> None:
    """Let the compositor's sockets follow."""
    scene = group.id_data
    for layer in scene.view_layers:
        layer.update_render_passes()


CLASSES = (PhotonMapSettings, PhotonMapLayer)


def settings_from(scene: bpy.types.Scene) -> Settings:
    """The settings stored in a scene."""
    group = scene.photon_map
    return Settings(**{name: _value(item, getattr(group, name)) for name, item in FIELDS.items()})


def _value(item, value: Any) -> Any:
    """A property's value as the setting's: Blender keeps floats in single precision, so that 2/3 is not our 2/3."""
    if not isinstance(item.default, float):
        return value
    for exact in (item.default, item.metadata["min"], item.metadata["max"]):
        if abs(value - exact) <= 1e-6 * max(abs(exact), 1e-6):
            return exact
    return float(f"{value:.7g}")


def register() -> None:
    """Add the properties; again is no harm."""
    if hasattr(bpy.types.Scene, "photon_map"):
        return
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.photon_map = bpy.props.PointerProperty(type=PhotonMapSettings)
    bpy.types.ViewLayer.photon_map = bpy.props.PointerProperty(type=PhotonMapLayer)


def unregister() -> None:
    """Remove them."""
    if not hasattr(bpy.types.Scene, "photon_map"):
        return
    del bpy.types.Scene.photon_map
    del bpy.types.ViewLayer.photon_map
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
