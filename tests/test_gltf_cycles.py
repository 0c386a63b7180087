"""Materials as a glTF file brings them: exported and imported by Blender's own add-on, they look as in Cycles."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
oiio = pytest.importorskip("OpenImageIO")

from photon_engine.blender.extract import extract_scene  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402
from photon_engine.transport.renderer import Renderer  # noqa: E402
from tests.node_patch import feed, new, out  # noqa: E402
from tests.oracle.cycles import write_float_exr  # noqa: E402

WIDTH, HEIGHT, BLOCK = 96, 48, 8
LIGHT = ("Direct", "Caustic", "Diffuse", "Emission", "Environment")


def image(name: str, rgba: np.ndarray, data: bool):
    """A packed image of bytes; rgba (h, w, 4)."""
    picture = bpy.data.images.new(name, rgba.shape[1], rgba.shape[0], alpha=True, is_data=data)
    picture.pixels = rgba.astype(np.float32).ravel()
    picture.pack()
    return picture


def pictures() -> dict:
    """Colour with alpha; roughness (g) and metal (b) of tiles; normals of a wave."""
    rng = np.random.default_rng(11)
    color = np.kron(rng.random((8, 16, 4)) * 0.8 + 0.1, np.ones((8, 8, 1)))
    mixed = np.ones((8, 16, 4))
    mixed[..., 1] = rng.random((8, 16)) * 0.6 + 0.3
    mixed[..., 2] = rng.integers(0, 2, (8, 16))
    x = np.arange(128) / 128.0 * 16.0 * np.pi
    normal = np.stack([0.4 * np.sin(x), np.zeros(128), np.sqrt(1.0 - 0.16 * np.sin(x) ** 2), np.ones(128)], axis=1)
    normal[:, :3] = normal[:, :3] * 0.5 + 0.5
    return {"color": image("Color", color, False), "mixed": image("Mixed", np.kron(mixed, np.ones((8, 8, 1))), True),
            "normal": image("Normal", np.tile(normal, (64, 1, 1)), True)}  # fmt: skip


def texture(tree, picture):
    """An Image Texture."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = picture
    return node


def textured(tree, shader, found):
    """Colour, metal, roughness and normals from images."""
    tree.links.new(out(texture(tree, found["color"]), "Color"), shader.inputs["Base Color"])
    parts = feed(tree, tree.nodes.new("ShaderNodeSeparateColor"), Color=out(texture(tree, found["mixed"]), "Color"))
    tree.links.new(out(parts, "Green"), shader.inputs["Roughness"])
    tree.links.new(out(parts, "Blue"), shader.inputs["Metallic"])
    bumps = feed(tree, new(tree, "ShaderNodeNormalMap"), Color=out(texture(tree, found["normal"]), "Color"))
    tree.links.new(out(bumps, "Normal"), shader.inputs["Normal"])


def faded(tree, shader, found):
    """Colour and alpha from an image."""
    picture = texture(tree, found["color"])
    tree.links.new(out(picture, "Color"), shader.inputs["Base Color"])
    tree.links.new(out(picture, "Alpha"), shader.inputs["Alpha"])


def constants(**values):
    """Sockets of a Principled BSDF by name with underscores."""
    def build(tree, shader, found):
        for name, value in values.items():
            shader.inputs[name.replace("_", " ")].default_value = value

    return build


MATERIALS = {
    "Textured": textured,
    "Faded": faded,
    "Coated": constants(Base_Color=(0.1, 0.3, 0.6, 1.0), Coat_Weight=1.0, Coat_Roughness=0.1, Sheen_Weight=0.4,
                        Sheen_Tint=(0.9, 0.8, 0.7, 1.0), Emission_Color=(1.0, 0.4, 0.1, 1.0), Emission_Strength=0.2),
    "Frosted": constants(Base_Color=(0.9, 0.95, 0.8, 1.0), Transmission_Weight=1.0, Roughness=0.3, IOR=1.4),
}  # fmt: skip


def make_scene() -> None:
    """A row of balls with a material each, and a plate under them."""
    found = pictures()
    for k, (name, build) in enumerate(MATERIALS.items()):
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        build(material.node_tree, material.node_tree.nodes["Principled BSDF"], found)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.45, location=(k - 1.5, 0.0, 0.5))
        bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(material)
    bpy.ops.mesh.primitive_plane_add(size=8.0)
    floor = bpy.data.materials.new("Floor")
    floor.use_nodes = True
    floor.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.7
    bpy.context.object.data.materials.append(floor)


def light_up(scene) -> None:
    """Camera, sky and a large lamp, as no file brings them."""
    camera = bpy.data.cameras.new("Camera")
    camera.angle = 0.65
    eye = bpy.data.objects.new("Camera", camera)
    eye.location, eye.rotation_euler = (0.0, -6.5, 2.2), (math.radians(76.0), 0.0, 0.0)
    scene.camera = eye
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 150.0, 3.0
    above = bpy.data.objects.new("Lamp", lamp)
    above.location = (0.0, -1.0, 4.0)
    for thing in (eye, above):
        scene.collection.objects.link(thing)
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.3, 0.35, 0.4, 1.0)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.cycles.samples = 1024  # with 256 the ball of rough glass came out 7% too dark in a block
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0.0
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 1.0
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    write_float_exr(scene.render.image_settings)


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of blocks of pixels."""
    return picture.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 3).mean(axis=(1, 3))


def test_exported_and_imported(tmp_path: Path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    make_scene()
    target = str(tmp_path / "scene.glb")
    bpy.ops.export_scene.gltf(filepath=target, export_format="GLB")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    bpy.ops.import_scene.gltf(filepath=target)
    scene = bpy.context.scene
    light_up(scene)
    scene.render.filepath = str(tmp_path / "gltf.exr")
    bpy.ops.render.render(write_still=True)
    theirs = oiio.ImageBuf(scene.render.filepath).get_pixels(oiio.FLOAT)[::-1, :, :3]
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    issues = IssueLog()
    data = extract_scene(graph, issues)
    assert {"Textured", "Faded", "Coated", "Frosted"} <= {material.name for material in data.materials}
    renderer = Renderer(data, Settings(caustic_photons=30_000, diffuse_photons=60_000), issues)
    renderer.prepare(lambda text: None)
    passes = [renderer.render_pass(i, lambda: False) for i in range(24)]
    renderer.close()
    names = [name for name in LIGHT if name in passes[0]]
    each = np.array([blocks(sum(p[name].reshape(HEIGHT, WIDTH, 3) for name in names)) for p in passes])
    ours, noise = each.mean(axis=0), each.std(axis=0, ddof=1) / len(each) ** 0.5
    assert not list(issues), list(issues)
    error = np.abs(ours - blocks(theirs)) / (blocks(theirs) + 0.05)
    allowed = 0.03 + 3.5 * noise / (blocks(theirs) + 0.05)  # Cycles has noise too, about 1%
    assert error.mean() < 0.01 and (error < allowed).all(), (error.mean(), (error / allowed).max())
