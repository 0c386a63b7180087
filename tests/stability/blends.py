"""Place, in Blender itself: a .blend far from the origin, its objects, parents and instances, through extraction."""

from __future__ import annotations

import numpy as np

from photon_engine.geometry.flatten import flatten
from photon_engine.issues import IssueLog

from .lab import SIZE, Finding, case, same_randoms, shoot

FAR = np.array([70_000.0, -100_000.0, 30_000.0])  # single precision has steps of 2^-7 m there
HALF_STEP = 2.0**-8
ROUNDED = 1e-5  # of the picture's mean: where things are the same, float32 rounds the last digits of some paths
DARK = (0.2, 0.2, 0.2, 1.0)


def link(ob, parent=None):
    """An object into the scene, with a parent whose transform it takes on."""
    import bpy

    bpy.context.scene.collection.objects.link(ob)
    ob.parent = parent
    return ob


def painted(kind: str, other):
    """A Lambert material whose colour or normal follows one kind of coordinates."""
    import bpy

    material = bpy.data.materials.new(kind)
    if material.node_tree is None:  # Blender 4.5
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    out, lambert = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(lambert.outputs[0], out.inputs[0])
    color = lambert.inputs["Color"]
    if kind == "near by":
        tree.links.new(tree.nodes.new("ShaderNodeAmbientOcclusion").outputs["Color"], color)
        return material
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    coordinates.object = other if kind == "another object's" else None
    noise = tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = 8.0
    name = {"camera's": "Camera", "window's": "Window"}.get(kind, "Object")
    tree.links.new(coordinates.outputs[name], noise.inputs["Vector"])
    if kind == "bumps":
        bump = tree.nodes.new("ShaderNodeBump")
        tree.links.new(noise.outputs[0], bump.inputs["Height"])
        tree.links.new(bump.outputs[0], lambert.inputs["Normal"])
        color.default_value = DARK
    else:
        tree.links.new(noise.outputs["Color"], color)
    return material


def ball(name: str):
    """A smooth ball of 0.4 m."""
    import bmesh
    import bpy

    data = bpy.data.meshes.new(name)
    build = bmesh.new()
    bmesh.ops.create_uvsphere(build, u_segments=16, v_segments=8, radius=0.4)
    build.to_mesh(data)
    build.free()
    data.shade_smooth()
    return bpy.data.objects.new(name, data)


def studio(step: float, offset=(0.0, 0.0, 0.0), rig: bool = False, coordinates: str = "object's"):
    """A floor, balls, an instanced collection, a lamp and a camera; returns SceneData.

    step : of all places [m];  offset : all things are moved by it: as objects of their own, or with `rig` as children
    of one empty
    """
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    root = link(bpy.data.objects.new("Rig", None)) if rig else None
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [], [(0, 1, 2, 3)])
    other = bpy.data.objects.new("Other", None)
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 60.0, 1.0
    pile = bpy.data.collections.new("Pile")
    pile.instance_offset = (0.5, 0.25, 0.0)
    member = ball("Member")
    member.location = (0.75, 0.5, 0.5)
    pile.objects.link(member)
    instancer = bpy.data.objects.new("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", pile
    camera = scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    balls = [ball("A"), ball("B")]
    for item in (*balls, member):
        item.data.materials.append(painted(coordinates, other))
    floor.materials.append(painted(coordinates, other))
    places = {
        bpy.data.objects.new("Floor", floor): (0.0, 0.0, 0.0), balls[0]: (-0.71, 0.33, 0.4),
        balls[1]: (0.37, 1.13, 0.4), other: (0.53, -0.21, 1.0), instancer: (0.91, -0.57, 0.1),
        bpy.data.objects.new("Lamp", lamp): (1.03, -0.77, 3.01), camera: (0.47, -3.93, 2.51),
    }  # fmt: skip
    for item, place in places.items():
        link(item, root)
        item.location = np.round(np.array(place) / step) * step + (0.0 if rig else np.array(offset))
    if rig:
        root.location = offset
    balls[1].rotation_euler = instancer.rotation_euler = (0.3, 0.5, 0.7)
    camera.rotation_euler = (1.1, 0.0, 0.1)
    return extracted()


def extracted():
    """The scene as it is, as SceneData."""
    import bpy

    from photon_engine.blender.extract import extract_scene

    bpy.context.view_layer.update()
    return extract_scene(bpy.context.evaluated_depsgraph_get(), IssueLog())


def corners(scene) -> np.ndarray:
    """Of all triangles in the world, (n, 3) f64."""
    flat = flatten(scene, IssueLog())
    return flat.geometry.positions.astype(np.float64) + flat.origin


COORDINATES = "object's", "another object's", "camera's", "window's", "near by", "bumps"


def _moved(name: str, rig: bool, step: float, coordinates: str, short: bool) -> None:
    @case("place", name, "same picture", short)
    def check() -> Finding:
        here, there = (shoot(studio(step, offset, rig, coordinates)) for offset in ((0.0, 0.0, 0.0), FAR))
        # random numbers of Ambient Occlusion are a hash of the point: other ones where its last digit is another
        return same_randoms(here, there, allowed=0.01 if coordinates == "near by" else ROUNDED)


for coordinates in COORDINATES:
    name = f".blend moved by 1e5 m, places of 1/64 m, {coordinates}" + " coordinates" * coordinates.endswith("'s")
    _moved(name, False, 1 / 64, coordinates, short=coordinates in ("near by", "bumps"))
_moved(".blend whose only parent is moved by 1e5 m", True, 1e-3, "object's", short=True)


@case("place", ".blend moved by 1e5 m, places of 1 mm", "corners moved by half a step of single precision", short=True)
def rounded_by_blender() -> Finding:
    """Locations of objects are single in Blender: 3.9 mm off at most; the instanced one by those of its instancer."""
    scenes = [studio(1e-3, offset) for offset in ((0.0, 0.0, 0.0), FAR)]
    gap = float(np.abs(corners(scenes[1]) - FAR - corners(scenes[0])).max())
    shot = shoot(scenes[1])
    found = same_randoms(shoot(scenes[0]), shot, allowed=0.05)  # half a step is 1% of a ball
    # what is rounded besides: the scene's own 4 m, in single
    good = found.good and gap <= HALF_STEP + 1e-5
    return found._replace(good=bool(good), figure=f"corners off by {gap:.4f} m; {found.figure}", used=gap / HALF_STEP)


@case("place", "another object of a .blend 1e6 m away", "same picture", short=True)
def one_far() -> Finding:
    import bpy

    here = shoot(studio(1e-3))
    studio(1e-3)
    link(ball("Far")).location = (3e5, 9e5, -4e5)
    bpy.data.objects["Far"].data.materials.append(bpy.data.materials.new("Far"))
    there = shoot(extracted())
    return same_randoms(here, there)  # photons of a wider scene have other random numbers
