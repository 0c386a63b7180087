"""What the sample scenes share: an empty file, meshes from arrays, materials, lamps, a camera."""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix, Vector

SIZE = 256  # pixels a side


def new_scene(name: str):
    """An empty file with one scene of 256x256 pixels and a black world."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.name = name
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.cycles.samples = 256
    scene.cycles.max_bounces = 32
    scene.cycles.blur_glossy = 0.0
    scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.use_denoising = False
    set_world(scene, (0.0, 0.0, 0.0), 0.0)
    return scene


def set_world(scene, color: Sequence[float], strength: float) -> None:
    """A world of one colour."""
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    scene.world = world


def link(scene, name: str, data, location: Sequence[float] = (0.0, 0.0, 0.0)):
    """An object of the data in the scene's collection."""
    item = bpy.data.objects.new(name, data)
    item.location = location
    scene.collection.objects.link(item)
    return item


def mesh_data(name: str, positions, faces, smooth: bool | Sequence[bool] = False, uvs=None):
    """A mesh from positions (V, 3), faces (lists of indices) and, per corner in face order, uvs (L, 2)."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, p)) for p in positions], [], [tuple(map(int, f)) for f in faces])
    flags = [smooth] * len(faces) if isinstance(smooth, bool) else list(smooth)
    mesh.polygons.foreach_set("use_smooth", flags)
    if uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", np.asarray(uvs, np.float32).ravel())
    mesh.update()
    return mesh


def quad(scene, name: str, corners: Sequence[Sequence[float]], material, tiles: tuple[float, float] = (1.0, 1.0)):
    """A four-cornered face, counter-clockwise seen from its front, UV from (0, 0) to `tiles`."""
    u, v = tiles
    mesh = mesh_data(name, corners, [(0, 1, 2, 3)], uvs=[(0, 0), (u, 0), (u, v), (0, v)])
    mesh.materials.append(material)
    return link(scene, name, mesh)


def box(scene, name: str, size: Sequence[float], location: Sequence[float], material, turn: float = 0.0):
    """A box standing on `location` (the middle of its bottom), turned about Z by `turn` [rad]."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    corners = [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0), (-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    mesh = mesh_data(name, corners, faces, uvs=[(0, 0), (1, 0), (1, 1), (0, 1)] * 6)
    mesh.materials.append(material)
    item = link(scene, name, mesh, location)
    item.rotation_euler = (0.0, 0.0, turn)
    return item


def unit_ball(name: str, subdivisions: int = 6):
    """A smooth icosphere of radius 1 as mesh data (subdivisions 6: 20480 triangles)."""
    import bmesh

    mesh = bpy.data.meshes.new(name)
    work = bmesh.new()
    bmesh.ops.create_icosphere(work, subdivisions=subdivisions, radius=1.0)
    work.to_mesh(mesh)
    work.free()
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def uv_ball(name: str, segments: int = 64, rings: int = 32):
    """A smooth sphere of radius 1 with a UV layer, as mesh data."""
    import bmesh

    mesh = bpy.data.meshes.new(name)
    work = bmesh.new()
    work.loops.layers.uv.new("UVMap")  # calc_uvs fills a layer, it makes none
    bmesh.ops.create_uvsphere(work, u_segments=segments, v_segments=rings, radius=1.0, calc_uvs=True)
    work.to_mesh(mesh)
    work.free()
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def lathe(profile, segments: int, closed: bool = False):
    """Surface of revolution about Z: profile (n, 2) of (radius, z) -> positions, quads (or triangles at the axis).

    Faces look to the right of the profile's direction (outward for a profile that goes up at positive radius).
    Returns positions, faces and for each face the index of its profile segment.
    """
    profile = np.asarray(profile, float)
    angles = np.linspace(0.0, 2.0 * math.pi, segments, endpoint=False)
    positions, rings = [], []
    for radius, z in profile:
        if radius < 1e-9:
            rings.append([len(positions)] * segments)
            positions.append((0.0, 0.0, z))
        else:
            rings.append(list(range(len(positions), len(positions) + segments)))
            positions += [(radius * math.cos(a), radius * math.sin(a), z) for a in angles]
    faces, owner = [], []
    count = len(profile) if closed else len(profile) - 1
    for k in range(count):
        low, high = rings[k], rings[(k + 1) % len(profile)]
        for i in range(segments):
            j = (i + 1) % segments
            face = list(dict.fromkeys((low[i], low[j], high[j], high[i])))
            if len(face) >= 3:
                faces.append(face)
                owner.append(k)
    return positions, faces, owner


def look_at(item, eye: Sequence[float], target: Sequence[float]) -> None:
    """Place an object at `eye` with its -Z axis toward `target` and its Y axis as far up as possible."""
    z = (Vector(eye) - Vector(target)).normalized()
    x = Vector((0.0, 0.0, 1.0)).cross(z)
    x = x.normalized() if x.length > 1e-6 else Vector((1.0, 0.0, 0.0))
    item.matrix_world = Matrix.Translation(Vector(eye)) @ Matrix((x, z.cross(x), z)).transposed().to_4x4()


def add_camera(scene, eye: Sequence[float], target: Sequence[float], angle: float):
    """The scene's camera with a full field of view of `angle` [degrees]."""
    data = bpy.data.cameras.new("Camera")
    data.angle = math.radians(angle)
    camera = link(scene, "Camera", data)
    look_at(camera, eye, target)
    scene.camera = camera
    return camera


def add_light(scene, kind: str, name: str, eye: Sequence[float], target: Sequence[float], energy: float, **values):
    """A lamp at `eye` that shines toward `target`; further properties of the light by name."""
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in values.items():
        setattr(data, key, value)
    item = link(scene, name, data)
    look_at(item, eye, target)
    return item


def save(path: str) -> None:
    """Write the current file, compressed, with Photon Map as its engine when that is registered."""
    scene = bpy.context.scene
    engines = {getattr(cls, "bl_idname", "") for cls in bpy.types.RenderEngine.__subclasses__()}
    if "PHOTON_MAP" in engines:
        scene.render.engine = "PHOTON_MAP"
    bpy.data.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=True, relative_remap=False)
