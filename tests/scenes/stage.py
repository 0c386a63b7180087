"""The stages on which lights and materials are tested: 64x64 pixels, diffuse surroundings."""

from __future__ import annotations

import bpy

from sample_blends.builders import common, materials

SIZE = 64


def empty(name: str):
    """An empty scene of the tests' size, black world."""
    scene = common.new_scene(name)
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    return scene


def corner(name: str):
    """A floor and two walls of different greys and reds, a block that throws a shadow, a camera that sees it all."""
    scene = empty(name)
    floor = materials.diffuse("Floor", (0.7, 0.7, 0.7))
    wall = materials.diffuse("Wall", (0.6, 0.25, 0.2))
    block = materials.diffuse("Block", (0.25, 0.4, 0.65))
    common.quad(scene, "Floor", [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], floor)
    common.quad(scene, "Back", [(-2, 2, 0), (2, 2, 0), (2, 2, 3), (-2, 2, 3)], floor)
    common.quad(scene, "Left", [(-2, -2, 0), (-2, 2, 0), (-2, 2, 3), (-2, -2, 3)], wall)
    common.box(scene, "Block", (0.7, 0.7, 0.9), (-0.5, 0.5, 0.0), block, 0.5)
    common.add_camera(scene, (1.6, -3.6, 2.2), (-0.2, 0.3, 0.7), 50.0)
    return scene


def pedestal(name: str, material=None, *, mesh=None, light_size: float = 1.4):
    """A ball (or another mesh, its last material replaced) on a diffuse floor before a wall, under a soft lamp.

    The ball has UVs and a turn, so that textures are seen from a general direction. The lamp is large, so that a path
    tracer finds the caustics.
    """
    scene = empty(name)
    common.set_world(scene, (0.7, 0.85, 1.0), 0.25)
    floor = materials.diffuse("Floor", (0.65, 0.6, 0.55))
    wall = materials.diffuse("Wall", (0.3, 0.5, 0.35))
    common.quad(scene, "Floor", [(-1.6, -1.6, 0), (1.6, -1.6, 0), (1.6, 1.6, 0), (-1.6, 1.6, 0)], floor)
    common.quad(scene, "Wall", [(-1.6, 1.2, 0), (1.6, 1.2, 0), (1.6, 1.2, 2.4), (-1.6, 1.2, 2.4)], wall)
    mesh = mesh or common.uv_ball("Ball", 96, 48)
    if material is not None:
        mesh.materials.clear()
        mesh.materials.append(material)
    item = common.link(scene, "Ball", mesh, (0.0, 0.0, 0.56))
    item.scale = (0.55,) * 3
    item.rotation_euler = (0.4, 0.3, 0.6)
    common.add_light(
        scene, "AREA", "Lamp", (-1.2, -1.0, 2.6), (0.0, 0.0, 0.4), 60.0, shape="SQUARE", size=light_size,
        color=(1.0, 0.95, 0.9),
    )
    common.add_camera(scene, (0.5, -3.2, 1.6), (0.0, 0.1, 0.6), 36.0)
    return scene


def current():
    """The scene being built."""
    return bpy.context.scene
