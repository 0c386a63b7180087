"""Lamps whose nodes vary over the lamp, with direction or with distance, against Cycles: a floor, block by block."""

from __future__ import annotations

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from photon_engine.blender.extract import extract_scene  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402
from photon_engine.transport.renderer import Renderer  # noqa: E402
from tests.node_patch import feed, new, out  # noqa: E402
from tests.test_lights_cycles import SIZE, add_lamp, assert_blocks_agree, material, render, scene  # noqa: E402, F401

LIGHT = ("Direct", "Caustic", "Diffuse", "Emission", "Environment")
STRENGTH = 0.7  # of the nodes


def wire(lamp, build):
    """The lamp's emission shines with what build(tree) gives: a colour, or a strength."""
    lamp.data.use_nodes = True
    tree = lamp.data.node_tree
    emission = next(n for n in tree.nodes if n.type == "EMISSION")
    emission.inputs["Strength"].default_value = STRENGTH
    socket = build(tree)
    tree.links.new(socket, emission.inputs["Color" if socket.type in ("RGBA", "VECTOR") else "Strength"])


def ours(passes, **settings):
    """The sum of our light passes (SIZE, SIZE, 3), bottom row first, and the issues."""
    issues = IssueLog()
    data = extract_scene(bpy.context.evaluated_depsgraph_get(), issues)
    few = {"caustic_photons": 0, "diffuse_photons": 0, "light_samples": 8}
    renderer = Renderer(data, Settings(**{**few, **settings}), issues)
    renderer.prepare(lambda text: None)
    pictures = [renderer.render_pass(i, lambda: False) for i in range(passes)]
    renderer.close()
    sums = [sum(picture[name] for name in LIGHT if name in picture) for picture in pictures]
    return np.mean(sums, axis=0).reshape(SIZE, SIZE, 3), issues


def falloff(output, smooth=0.0):
    """Light Falloff."""
    return lambda tree: out(feed(tree, tree.nodes.new("ShaderNodeLightFalloff"), Strength=2.0, Smooth=smooth), output)


def picture(tree, vector=None):
    """A smooth picture of 32 x 32 pixels, Clip, looked up at a socket."""
    image = bpy.data.images.new("Gobo", 32, 32, float_buffer=True)
    y, x = np.mgrid[:32, :32] / 31.0
    rgba = np.stack([0.2 + 0.8 * x, 0.3 + 0.6 * y, 0.6 + 0.4 * np.sin(6.0 * x) * np.cos(5.0 * y), np.ones_like(x)], -1)
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    image.pack()
    node = new(tree, "ShaderNodeTexImage", image=image, extension="EXTEND")
    if vector is not None:
        tree.links.new(vector, node.inputs["Vector"])
    return node.outputs["Color"]


TEX_COORD = ("UV", "Normal", "Object", "Generated", "Reflection", "Camera", "Window")
GEOMETRY = ("Position", "Normal", "True Normal", "Incoming", "Parametric", "Backfacing", "Random Per Island",
            "Pointiness")
LIGHT_PATH = ("Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Ray Length")


def telling(*names, node="ShaderNodeTexCoord"):
    """What a node's outputs say, each by another amount, as a colour; nothing of ours shines negatively."""
    def build(tree):
        source, total = tree.nodes.new(node), (0.3, 0.4, 0.5)
        for k, name in enumerate(names):
            weights = [(0.3, -0.4, 0.5), (-0.6, 0.5, 0.2), (0.4, 0.3, -0.3), (0.2, 0.6, 0.4)][k % 4]
            add = new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD")
            total = feed(tree, add, Vector=out(source, name), Vector_001=weights, Vector_002=total).outputs[0]
        return feed(tree, new(tree, "ShaderNodeVectorMath", operation="ABSOLUTE"), Vector=total).outputs[0]

    return build


def glowing(tree):
    """Black bodies, hotter from one side to the other."""
    uv = out(tree.nodes.new("ShaderNodeTexCoord"), "UV")
    heat = feed(tree, new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD"), Vector=uv,
                Vector_001=(4e3, 2e3, 0.0), Vector_002=(1e3,) * 3)
    return feed(tree, tree.nodes.new("ShaderNodeBlackbody"), Temperature=heat.outputs[0]).outputs[0]


def gradient(kind):
    """A Gradient Texture where it looks by itself."""
    return lambda tree: out(new(tree, "ShaderNodeTexGradient", gradient_type=kind), "Color")


def gobo(name, scale=(1.0, 1.0, 1.0), node="ShaderNodeTexCoord"):
    """A picture by some coordinates."""
    def build(tree):
        mad = new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD")
        feed(tree, mad, Vector=out(tree.nodes.new(node), name), Vector_001=scale,
             Vector_002=(0.0,) * 3 if name == "UV" else (0.5,) * 3)
        return picture(tree, mad.outputs[0])

    return build


POINT = {"shadow_soft_size": 0.0}
SOFT = {"shadow_soft_size": 0.4, "location": (0.3, 0.1, 0.9)}
BALL = {**SOFT, "use_soft_falloff": False}
SPOT = {"shadow_soft_size": 0.0, "spot_size": 1.3, "spot_blend": 0.3, "scale": (1.3, 1.0, 0.8)}
PANEL = {"shape": "RECTANGLE", "size": 1.6, "size_y": 0.9, "location": (0.2, 0.1, 0.8), "rotation": (0.1, -0.2, 0.5),
         "scale": (1.0, 1.2, 1.0)}
DISK = {"shape": "DISK", "size": 1.2, "spread": 2.0}
SUN = {"angle": 0.6}
LAMPS = {"point": ("POINT", POINT), "soft point": ("POINT", SOFT), "ball": ("POINT", BALL), "spot": ("SPOT", SPOT),
         "panel": ("AREA", PANEL), "disk": ("AREA", DISK), "sun": ("SUN", SUN)}
CASES = {
    **{f"coordinates of a {name}": (name, telling(*TEX_COORD)) for name in LAMPS},
    **{f"geometry of a {name}": (name, telling(*GEOMETRY, node="ShaderNodeNewGeometry"))
       for name in ("ball", "spot", "panel", "sun")},
    "linear": ("point", falloff("Linear")),
    "constant": ("ball", falloff("Constant")),
    "smooth": ("soft point", falloff("Quadratic", 2.0)),
    "smooth constant": ("panel", falloff("Constant", 3.0)),
    "smooth linear": ("spot", falloff("Linear", 1.0)),
    "linear sun": ("sun", falloff("Linear", 1.0)),
    "path": ("point", telling(*LIGHT_PATH, node="ShaderNodeLightPath")),
    "gobo": ("spot", gobo("UV")),
    "gobo by normals": ("spot", gobo("Normal")),
    "picture": ("panel", gobo("UV")),
    "picture as it comes": ("disk", picture),
    "black bodies": ("panel", glowing),
    "gradient": ("panel", gradient("LINEAR")),
    "spherical gradient": ("soft point", gradient("SPHERICAL")),
}


@pytest.mark.parametrize("name", CASES)
def test_floor(name, scene, tmp_path):  # noqa: F811
    """Direct light; 16 x 16 pixels a block, the dim ones off by up to 0.5% by noise."""
    lamp, build = CASES[name]
    kind, options = LAMPS[lamp]
    wire(add_lamp(scene, kind, **options), build)
    found, issues = ours(16, max_bounces=1)
    assert not list(issues)
    scene.cycles.samples = 128
    assert_blocks_agree(found, render(scene, tmp_path))


def test_a_tangent_makes_a_lamp_black(scene, tmp_path):  # noqa: F811
    """It is no number in Cycles."""
    wire(add_lamp(scene, "AREA", **PANEL), telling("Tangent", node="ShaderNodeNewGeometry"))
    assert ours(1)[0].max() == render(scene, tmp_path).max() == 0.0


def assert_quarters_agree(found, expected):
    """Means of the picture's quarters within 1%."""
    quarters = [picture.reshape(2, SIZE // 2, 2, SIZE // 2, 3).mean((1, 3)) for picture in (found, expected)]
    np.testing.assert_allclose(*quarters, rtol=0.01)


def ceiling(height, surface):
    """A wide sheet across the z axis."""
    mesh = bpy.data.meshes.new("Sheet")
    mesh.from_pydata([(-20, -20, height), (20, -20, height), (20, 20, height), (-20, 20, height)], [], [(0, 1, 2, 3)])
    mesh.materials.append(surface)
    thing = bpy.data.objects.new("Sheet", mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def half_clear():
    """A sheet that lets half of the light straight through and scatters the rest."""
    made = material("ShaderNodeBsdfDiffuse", Color=(0.7, 0.6, 0.8, 1.0))
    tree = made.node_tree
    mix = feed(tree, tree.nodes.new("ShaderNodeMixShader"), Fac=0.5, Shader=tree.nodes["Diffuse BSDF"].outputs[0],
               Shader_001=tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0])
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return made


BETWEEN = {"location": (0.1, -0.2, 1.2), "rotation": (math.pi - 0.2, 0.1, 0.0)}
BOUNCES = {
    "linear soft point": ("soft point", (falloff("Linear"),), {}),
    "linear picture": ("panel", (gobo("UV"), falloff("Linear")), BETWEEN),
    "constant gobo without shadows": ("spot", (gobo("UV"), falloff("Constant")), {**BETWEEN, "use_shadow": False}),
}


@pytest.mark.parametrize("name", BOUNCES)
def test_light_between_sheets(name, scene, tmp_path):  # noqa: F811
    """Photons: a lamp between the floor and a ceiling that lets half through to another; quarters of the picture.

    Noise of a quarter: 0.3% of ours, 0.2% of Cycles'.
    """
    lamp, builds, more = BOUNCES[name]
    kind, options = LAMPS[lamp]
    thing = add_lamp(scene, kind, **{**options, **more})
    for build in builds:
        wire(thing, build)
    bpy.data.objects["Floor"].data.materials[0] = material("ShaderNodeBsdfDiffuse", Color=(0.8, 0.6, 0.5, 1.0))
    ceiling(1.6, half_clear())
    ceiling(2.4, material("ShaderNodeBsdfDiffuse", Color=(0.5, 0.7, 0.6, 1.0)))
    scene.camera.location = (0.0, 0.0, 0.1)
    scene.camera.data.clip_start = 0.01
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.diffuse_bounces = 256, 4, 4
    found, issues = ours(12, diffuse_photons=100_000, max_bounces=40, diffuse_bounces=4, light_samples=2)
    assert not list(issues)
    assert_quarters_agree(found, render(scene, tmp_path))


def look_at_lamp(way):
    """The camera looks up at the lamp, or down at a mirror or a polished floor that shows it."""
    camera, floor = bpy.context.scene.camera, bpy.data.objects["Floor"]
    camera.data.type, camera.data.sensor_fit = "PERSP", "HORIZONTAL"
    camera.data.angle = 2.0 * math.atan(0.6)
    if way == "camera":
        floor.hide_render = True
        camera.location, camera.rotation_euler = (0.0, 0.0, 0.0), (math.pi, 0.0, 0.0)
        return
    roughness = 0.0 if way == "mirror" else 0.3
    floor.data.materials[0] = material("ShaderNodeBsdfAnisotropic", Roughness=roughness)
    camera.location, camera.rotation_euler = (0.0, 0.0, 0.5), (0.0, 0.0, 0.0)


SEEN = {
    "picture": ("AREA", {"shape": "RECTANGLE", "size": 1.6, "size_y": 0.9}, (gobo("UV"), falloff("Linear"))),
    "ball": ("POINT", {"shadow_soft_size": 0.5, "use_soft_falloff": False}, (telling("UV", "Normal", "Object"),)),
    "disk": ("POINT", {"shadow_soft_size": 0.5}, (telling("Incoming", "Position", node="ShaderNodeNewGeometry"),)),
}


@pytest.mark.parametrize(("name", "way"), [("picture", "camera"), ("picture", "mirror"), ("picture", "polished"),
                                           ("ball", "mirror"), ("disk", "camera")])  # fmt: skip
def test_lamps_are_seen(name, way, scene, tmp_path):  # noqa: F811
    """By the camera, in a mirror, and by rays from rough lobes: light sampling's partners."""
    kind, options, builds = SEEN[name]
    thing = add_lamp(scene, kind, (0.2, 0.1, 3.0 if way == "camera" else 1.5), (0.1, 0.15, 0.2), visible_camera=True,
                     **options)  # fmt: skip
    for build in builds:
        wire(thing, build)
    look_at_lamp(way)
    scene.cycles.samples, scene.cycles.max_bounces = 256, 1
    found, issues = ours(64, max_bounces=8, light_samples=2)
    assert not list(issues) and found.max() > 0.0
    theirs = render(scene, tmp_path)
    if way == "polished":  # noise of a block 0.6%, of a quarter 0.2%
        assert_quarters_agree(found, theirs)
    else:
        assert_blocks_agree(found, theirs)


def test_caustic_of_a_lamp_with_nodes(scene, tmp_path):  # noqa: F811
    """Photons land on the mirror first: light is as strong as at the distance to there, as Cycles' rays from it see."""
    thing = add_lamp(scene, "AREA", (0.6, 0.0, 1.0), (0.0, 1.2, 0.0), size=0.8)
    for build in (gobo("UV"), falloff("Constant")):
        wire(thing, build)
    mirror = ceiling(0.0, material("ShaderNodeBsdfAnisotropic", Roughness=0.0))
    mirror.rotation_euler, mirror.location, mirror.scale = (0.0, math.pi / 2.0, 0.0), (-1.5, 0.0, 0.0), (0.1, 0.1, 1.0)
    scene.camera.data.ortho_scale = 2.0
    scene.camera.location = (-0.4, 0.0, 9.0)
    scene.cycles.samples, scene.cycles.max_bounces = 256, 2
    found, issues = ours(12, caustic_photons=200_000, max_bounces=8, diffuse_bounces=0, light_samples=4)
    assert not list(issues)
    assert_quarters_agree(found, render(scene, tmp_path))
