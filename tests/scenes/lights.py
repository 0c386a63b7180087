"""Each kind of light with each of its options, in the diffuse corner."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from sample_blends.builders import common, materials

from . import stage

ABOVE = (0.5, -0.7, 1.9)  # where lamps stand
TARGET = (-0.3, 0.4, 0.2)
WARM = (1.0, 0.8, 0.55)


def lamp(name: str, kind: str, energy: float, scale: tuple | None = None, **values) -> None:
    """One lamp above the corner, with options by property name and the object's scale."""
    scene = stage.corner(name)
    item = common.add_light(scene, kind, "Lamp", ABOVE, TARGET, energy, **values)
    if scale:
        item.scale = scale


def lamp_in_view(name: str, kind: str, energy: float, **values) -> None:
    """A lamp that the camera sees, in front of the back wall."""
    scene = stage.corner(name)
    common.add_light(scene, kind, "Lamp", (0.6, 0.9, 1.3), (0.2, -1.2, 0.4), energy, **values)


def world(name: str, color: tuple, strength: float) -> None:
    """Only the sky."""
    common.set_world(stage.corner(name), color, strength)


def emissive_panel(name: str) -> None:
    """A face that glows, both sides."""
    scene = stage.corner(name)
    glow = materials.shader("Glow", "ShaderNodeEmission", Color=WARM, Strength=12.0)
    common.quad(scene, "Panel", [(0.2, -0.9, 1.6), (0.9, -0.7, 1.9), (0.8, 0.1, 2.0), (0.1, -0.1, 1.7)], glow)


def emissive_ball(name: str) -> None:
    """A ball that glows, in view, of an instanced and scaled mesh."""
    scene = stage.corner(name)
    glow = materials.shader("Glow", "ShaderNodeEmission", Color=WARM, Strength=3.0)
    ball = common.unit_ball("Ball", 4)
    ball.materials.append(glow)
    common.link(scene, "Ball A", ball, (0.6, 0.3, 0.5)).scale = (0.35,) * 3
    common.link(scene, "Ball B", ball, (-1.2, -0.2, 1.4)).scale = (0.2, 0.2, 0.4)


def many(name: str) -> None:
    """Lamps of every kind at once, strong and weak."""
    scene = stage.corner(name)
    common.set_world(scene, (0.3, 0.5, 0.8), 0.15)
    common.add_light(scene, "POINT", "Point", (1.2, 0.9, 0.8), TARGET, 12.0, shadow_soft_size=0.08, color=WARM)
    common.add_light(scene, "SPOT", "Spot", (0.9, -1.5, 2.4), TARGET, 90.0, spot_size=0.7, spot_blend=0.4)
    common.add_light(scene, "SUN", "Sun", (2.0, -1.5, 2.5), (0, 0, 0), 0.7, angle=0.2)
    common.add_light(scene, "AREA", "Area", (-0.4, -0.6, 2.7), (0, 0.4, 0), 20.0, size=0.6, color=(0.6, 0.7, 1.0))


def shadowless(name: str) -> None:
    """A lamp that casts no shadow beside one that does."""
    scene = stage.corner(name)
    item = common.add_light(scene, "POINT", "Lamp", ABOVE, TARGET, 45.0, shadow_soft_size=0.1)
    item.data.use_shadow = False
    common.add_light(scene, "POINT", "Other", (1.4, 0.8, 1.2), TARGET, 20.0, shadow_soft_size=0.1, color=WARM)


def through_veil(name: str) -> None:
    """A lamp behind a half-transparent, coloured sheet: a transparent shadow."""
    scene = stage.corner(name)
    veil = materials.mix(
        "Veil", 0.4, materials.maker("ShaderNodeBsdfTransparent", Color=(0.9, 0.5, 0.2)),
        materials.maker("ShaderNodeBsdfDiffuse", Color=(0.3, 0.3, 0.8)),
    )
    common.quad(scene, "Veil", [(-0.6, -0.6, 1.2), (0.5, -0.7, 1.25), (0.5, 0.3, 1.2), (-0.6, 0.4, 1.15)], veil)
    common.add_light(scene, "AREA", "Lamp", ABOVE, TARGET, 50.0, shape="DISK", size=0.3)


SPOT = {"spot_size": math.radians(55.0), "spot_blend": 0.3}
OPTIONS: dict[str, tuple] = {
    "point_delta": (lamp, "POINT", 60.0, {"shadow_soft_size": 0.0}),
    "point_soft": (lamp, "POINT", 60.0, {"shadow_soft_size": 0.25, "use_soft_falloff": True}),
    "point_sphere": (lamp, "POINT", 60.0, {"shadow_soft_size": 0.25, "use_soft_falloff": False, "color": WARM}),
    "point_not_normalized": (lamp, "POINT", 30.0, {"shadow_soft_size": 0.25, "normalize": False}),
    "point_temperature": (
        lamp, "POINT", 30.0, {"shadow_soft_size": 0.1, "exposure": 1.2, "use_temperature": True, "temperature": 3000.0},
    ),
    "point_in_view": (lamp_in_view, "POINT", 30.0, {"shadow_soft_size": 0.2}),
    "sphere_in_view": (lamp_in_view, "POINT", 30.0, {"shadow_soft_size": 0.2, "use_soft_falloff": False}),
    "spot_delta": (lamp, "SPOT", 120.0, {"shadow_soft_size": 0.0, **SPOT}),
    "spot_soft": (lamp, "SPOT", 120.0, {"shadow_soft_size": 0.2, **SPOT}),
    "spot_sphere": (lamp, "SPOT", 120.0, {"shadow_soft_size": 0.2, "use_soft_falloff": False, **SPOT}),
    "spot_hard_edge": (lamp, "SPOT", 120.0, {"shadow_soft_size": 0.05, "spot_size": 0.8, "spot_blend": 0.0}),
    "spot_ellipse": (lamp, "SPOT", 120.0, {"shadow_soft_size": 0.0, "scale": (1.6, 0.8, 1.0), **SPOT}),
    "spot_in_view": (lamp_in_view, "SPOT", 40.0, {"shadow_soft_size": 0.2, **SPOT}),
    "area_square": (lamp, "AREA", 50.0, {"shape": "SQUARE", "size": 0.7}),
    "area_rectangle": (lamp, "AREA", 50.0, {"shape": "RECTANGLE", "size": 1.1, "size_y": 0.3, "color": WARM}),
    "area_disk": (lamp, "AREA", 50.0, {"shape": "DISK", "size": 0.8}),
    "area_ellipse_scaled": (
        lamp, "AREA", 50.0, {"shape": "ELLIPSE", "size": 1.0, "size_y": 0.3, "scale": (0.8, 1.7, 1.0)}
    ),
    "area_spread": (lamp, "AREA", 30.0, {"shape": "SQUARE", "size": 0.5, "spread": math.radians(70.0)}),
    "area_not_normalized": (lamp, "AREA", 15.0, {"shape": "SQUARE", "size": 0.8, "normalize": False}),
    "area_in_view": (lamp_in_view, "AREA", 20.0, {"shape": "RECTANGLE", "size": 0.6, "size_y": 0.4}),
    "sun_delta": (lamp, "SUN", 2.0, {"angle": 0.0}),
    "sun_wide": (lamp, "SUN", 2.0, {"angle": math.radians(35.0), "color": WARM}),
    "sun_not_normalized": (lamp, "SUN", 3.0, {"angle": math.radians(40.0), "normalize": False}),
}


def _scenes() -> dict[str, Callable[[], None]]:
    """The table above and the scenes that need a function of their own."""
    scenes: dict[str, Callable[[], None]] = {}
    for name, (builder, kind, energy, values) in OPTIONS.items():
        scenes[name] = partial(builder, name, kind, energy, **values)
    scenes["world_sky"] = partial(world, "world_sky", (0.4, 0.65, 1.0), 1.2)
    for function in (emissive_panel, emissive_ball, many, shadowless, through_veil):
        scenes[function.__name__] = partial(function, function.__name__)
    return scenes


SCENES = _scenes()
