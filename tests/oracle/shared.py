"""Scenes by other people that lie beside the project (a plain clone lacks them), made fit to be compared."""

from __future__ import annotations

from pathlib import Path

from .cycles import ROOT

FOLDER = ROOT.parent / "shared" / "scenes"
SIZES = {"blenderdiplom_glass": (160, 90), "clevr_objects": (160, 120)}
# a path tracer meets the lamp of 0.1 m by chance only, and the caustic is most of the picture: both see a larger one
LAMP_RADIUS = {"blenderdiplom_glass": 1.5}


def path_of(name: str) -> Path:
    """Where the scene lies, if it does."""
    return FOLDER / f"{name}.blend"


def build(name: str) -> None:
    """Open the scene at the size of its reference."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(path_of(name)))
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = SIZES[name]
    render.resolution_percentage = 100
    for lamp in bpy.data.lights if name in LAMP_RADIUS else ():
        lamp.shadow_soft_size = LAMP_RADIUS[name]
