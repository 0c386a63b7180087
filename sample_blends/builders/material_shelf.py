"""Four boards of balls, one material each, under a big soft lamp."""

from __future__ import annotations

import numpy as np

from . import common, materials
from .materials import maker, mix

RADIUS = 0.21
SPACING = 0.52
COLUMNS = 4


def checks(n: int = 64, squares: int = 8) -> np.ndarray:
    """A checkerboard of two colours, (n, n, 3)."""
    square = np.arange(n) * squares // n
    dark = (square[:, None] + square[None, :]) % 2 == 0
    return np.where(dark[:, :, None], (0.85, 0.55, 0.20), (0.20, 0.32, 0.50)).astype(np.float32)


def dents(n: int = 64, count: int = 8) -> np.ndarray:
    """A tangent-space normal map of round bumps, (n, n, 3) as stored (0.5 + n / 2)."""
    t = (np.arange(n) + 0.5) / n * count % 1.0 * 2.0 - 1.0
    x, y = np.meshgrid(t, t)
    inside = np.maximum(1.0 - x**2 - y**2, 0.0)
    slope = np.where(inside > 0.0, 0.7, 0.0)
    normal = np.stack([x * slope, y * slope, np.ones_like(x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return (0.5 + 0.5 * normal).astype(np.float32)


def textured():
    """Principled coloured by a mapped image, with a normal map."""
    material, nodes, links, output = materials.new_material("Checks and Bumps")
    coordinate = nodes.new("ShaderNodeTexCoord")
    mapping = nodes.new("ShaderNodeMapping")
    mapping.inputs["Scale"].default_value = (2.0, 1.0, 1.0)
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.4)
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = materials.add_image("Checks", checks())
    bumps = nodes.new("ShaderNodeTexImage")
    bumps.image = materials.add_image("Bumps", dents(), is_data=True)
    normal_map = nodes.new("ShaderNodeNormalMap")
    normal_map.inputs["Strength"].default_value = 0.8
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    materials.set_inputs(surface, Roughness=0.45)
    links.new(coordinate.outputs["UV"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    links.new(bumps.outputs["Color"], normal_map.inputs["Color"])
    links.new(normal_map.outputs["Normal"], surface.inputs["Normal"])
    links.new(surface.outputs[0], output.inputs["Surface"])
    return material


def list_materials() -> list:
    """Sixteen materials, from the top left, row by row."""
    p = materials.principled
    diffuse, glossy, translucent = "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfTranslucent"
    return [
        p("Plastic", Base_Color=(0.70, 0.06, 0.05), Roughness=0.25),
        p("Matte", Base_Color=(0.75, 0.72, 0.66), Roughness=0.9, Specular_IOR_Level=0.2),
        p("Car Paint", Base_Color=(0.03, 0.10, 0.42), Roughness=0.4, Coat_Weight=1.0, Coat_Roughness=0.06),
        p("Rough Gold", Base_Color=(1.0, 0.72, 0.28), Metallic=1.0, Roughness=0.3),
        p("Steel", Base_Color=(0.62, 0.62, 0.64), Metallic=1.0, Roughness=0.12),
        materials.diffuse("Diffuse", (0.22, 0.50, 0.22)),
        materials.glossy("Satin", (0.85, 0.62, 0.50), 0.4),
        materials.glass("Glass"),
        p("Clear Principled", Base_Color=(0.75, 0.92, 0.86), Transmission_Weight=1.0, Roughness=0.0),
        p("Frosted", Base_Color=(0.95, 0.93, 0.98), Transmission_Weight=1.0, Roughness=0.3),
        mix("Leaf", 0.5, maker(diffuse, Color=(0.35, 0.55, 0.12)), maker(translucent, Color=(0.6, 0.7, 0.15))),
        mix("Veil", 0.45, maker("ShaderNodeBsdfTransparent"), maker(diffuse, Color=(0.75, 0.35, 0.55))),
        mix("Varnish", maker("ShaderNodeFresnel", IOR=1.5), maker(diffuse, Color=(0.36, 0.14, 0.05)),
            maker(glossy, Color=(1.0, 1.0, 1.0), Roughness=0.08)),
        mix("Pearl", maker("ShaderNodeLayerWeight", "Facing", Blend=0.35), maker(diffuse, Color=(0.75, 0.70, 0.72)),
            maker(glossy, Color=(0.55, 0.45, 0.85), Roughness=0.3)),
        textured(),
        materials.shader("Glow", "ShaderNodeEmission", Color=(1.0, 0.50, 0.16), Strength=2.5),
    ]


def add_shelf(scene, rows: int) -> None:
    """Boards and back; the lowest board's top is at height 0."""
    board = materials.diffuse("Board", (0.58, 0.55, 0.50))
    width, depth, thick = COLUMNS * SPACING + 0.12, 0.56, 0.04
    for row in range(rows):
        common.box(scene, f"Board {row}", (width, depth, thick), (0, 0, row * SPACING - thick), board)
    common.box(scene, "Back", (width + 2.0, 0.04, rows * SPACING + 3.0), (0, depth / 2 + 0.02, -1.0), board)


def build():
    """The shelf under a big soft lamp, the last ball glowing."""
    scene = common.new_scene("material_shelf")
    common.set_world(scene, (0.75, 0.85, 1.0), 0.25)
    surfaces = list_materials()
    rows = -(-len(surfaces) // COLUMNS)
    add_shelf(scene, rows)
    ball = common.uv_ball("Ball")
    ball.materials.append(None)
    for k, material in enumerate(surfaces):
        row, column = divmod(k, COLUMNS)
        place = ((column - (COLUMNS - 1) / 2) * SPACING, -0.02, (rows - 1 - row) * SPACING + RADIUS + 0.002)
        item = common.link(scene, material.name, ball, place)
        item.scale = (RADIUS,) * 3
        item.rotation_euler = (0.35, 0.0, 0.5)
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = material
    common.add_light(
        scene, "AREA", "Softbox", (-1.6, -2.8, 3.0), (0, 0, 0.9), 170.0, shape="RECTANGLE", size=1.8, size_y=1.2,
    )
    common.add_camera(scene, (0.0, -4.6, 1.25), (0.0, 0.0, 0.96), 29.0)
    return scene
