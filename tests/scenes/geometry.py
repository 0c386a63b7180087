"""What can stand in a scene: instances, mirrored objects, curves, text, modifiers, several materials."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import bpy

from sample_blends.builders import common, materials

from . import stage

ORANGE, TEAL = (0.8, 0.4, 0.1), (0.1, 0.5, 0.5)


def lit(name: str):
    """Floor and wall, a soft lamp, a little sky, a camera; the middle is free."""
    scene = stage.pedestal(name, light_size=0.8)
    bpy.data.objects.remove(bpy.data.objects["Ball"])
    return scene


def wedge(material, other):
    """A mesh without symmetry: a box with one corner pulled out, two materials, flat."""
    p = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1.6, -1.3, 1.2), (1, 1, 1), (-1, 1, 1)]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    mesh = common.mesh_data("Wedge", p, faces)
    mesh.materials.append(material)
    mesh.materials.append(other)
    mesh.polygons.foreach_set("material_index", [0, 0, 1, 0, 1, 0])
    return mesh


def mirrored(name: str) -> None:
    """One mesh twice: as it is, and with a negative scale; the second with a material of the object."""
    scene = lit(name)
    orange, teal = materials.diffuse("Orange", ORANGE), materials.glossy("Satin", (0.6, 0.8, 0.9), 0.3)
    mesh = wedge(orange, teal)
    common.link(scene, "Right", mesh, (0.55, 0.0, 0.36)).scale = (0.3,) * 3
    item = common.link(scene, "Left", mesh, (-0.55, 0.0, 0.36))
    item.scale = (-0.3, 0.3, 0.3)
    item.rotation_euler = (0.0, 0.0, 0.3)
    item.material_slots[1].link = "OBJECT"
    item.material_slots[1].material = materials.diffuse("Teal", TEAL)


def mirrored_glass(name: str) -> None:
    """A ball of glass with a negative scale: inside must stay inside."""
    scene = lit(name)
    ball = common.unit_ball("Ball", 5)
    ball.materials.append(materials.glass("Glass"))
    common.link(scene, "Glass", ball, (0.0, 0.0, 0.5)).scale = (0.45, -0.45, 0.45)


def collection_instances(name: str) -> None:
    """A collection instanced by empties with turns and scales."""
    scene = lit(name)
    group = bpy.data.collections.new("Group")
    mesh = wedge(materials.diffuse("Orange", ORANGE), materials.diffuse("Teal", TEAL))
    item = bpy.data.objects.new("Wedge", mesh)
    item.scale = (0.16,) * 3
    group.objects.link(item)
    for k in range(5):
        empty = common.link(scene, f"Empty {k}", None, (-0.9 + 0.45 * k, 0.2 * math.sin(k), 0.2 + 0.1 * k))
        empty.instance_type = "COLLECTION"
        empty.instance_collection = group
        empty.rotation_euler = (0.3 * k, 0.2, 0.7 * k)
        empty.scale = (1.0 + 0.1 * k, 1.0, 1.0)


def smooth_and_flat(name: str) -> None:
    """A coarse ball, smooth: its shading normals lean far from its faces; beside it a flat one, and half of each."""
    scene = lit(name)
    paints = materials.diffuse("Orange", ORANGE), materials.glossy("Satin", (0.6, 0.8, 0.9), 0.4)
    for k in range(3):
        ball = common.uv_ball(f"Ball {k}", 12, 7)
        # by place, not by index: Blender makes the faces of a sphere in another order each time
        ball.polygons.foreach_set("use_smooth", [k == 0 or (k == 2 and face.center.z > 0.1) for face in ball.polygons])
        ball.materials.append(paints[0])
        ball.materials.append(paints[1])
        ball.polygons.foreach_set("material_index", [int(face.center.x > 0.0) for face in ball.polygons])
        common.link(scene, f"Ball {k}", ball, (-0.8 + 0.8 * k, 0.0, 0.37)).scale = (0.36,) * 3


def curve_and_text(name: str) -> None:
    """A curve with thickness, and a text."""
    scene = lit(name)
    data = bpy.data.curves.new("Curve", "CURVE")
    data.dimensions = "3D"
    data.bevel_depth = 0.06
    spline = data.splines.new("BEZIER")
    spline.bezier_points.add(2)
    for k, point in enumerate(spline.bezier_points):
        point.co = (-0.8 + 0.8 * k, 0.3, 0.35 + 0.5 * (k % 2))
        point.handle_left_type = point.handle_right_type = "AUTO"
    data.materials.append(materials.diffuse("Orange", ORANGE))
    common.link(scene, "Curve", data)
    text = bpy.data.curves.new("Text", "FONT")
    text.body = "Light"
    text.size, text.extrude, text.align_x = 0.6, 0.05, "CENTER"
    text.materials.append(materials.diffuse("Teal", TEAL))
    item = common.link(scene, "Text", text, (0.0, -0.3, 0.08))
    item.rotation_euler = (math.pi / 2, 0.0, 0.0)


def modifiers(name: str) -> None:
    """Subdivision and array, as modifiers."""
    scene = lit(name)
    mesh = wedge(materials.diffuse("Orange", ORANGE), materials.diffuse("Teal", TEAL))
    item = common.link(scene, "Wedge", mesh, (-0.7, 0.0, 0.35))
    item.scale = (0.25,) * 3
    item.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    array = item.modifiers.new("Array", "ARRAY")
    array.count = 3
    array.relative_offset_displace = (1.15, 0.0, 0.0)


def hidden_and_holdout(name: str) -> None:
    """An object that is not rendered, one hidden from the camera, one that is a hole."""
    scene = lit(name)
    for x, label in ((-0.8, "Hidden"), (0.0, "Unseen"), (0.8, "Hole")):
        common.box(scene, label, (0.5, 0.5, 0.5), (x, 0.1, 0.02), materials.diffuse(label, ORANGE), 0.4)
    bpy.data.objects["Hidden"].hide_render = True
    bpy.data.objects["Unseen"].visible_camera = False
    bpy.data.objects["Hole"].is_holdout = True


BUILDERS = (
    mirrored, mirrored_glass, smooth_and_flat, collection_instances, curve_and_text, modifiers, hidden_and_holdout,
)  # fmt: skip
SCENES: dict[str, Callable[[], None]] = {builder.__name__: partial(builder, builder.__name__) for builder in BUILDERS}
