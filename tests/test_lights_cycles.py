"""Every kind of lamp against Cycles: a white diffuse floor seen straight down, direct light only, block by block.

Ours is the floor's irradiance by light sampling at random points of each pixel; extraction of the lamp is part of the
test. Rays that meet lamps are checked by mirrors and by looking at the lamp.
"""

import math

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from scipy.stats import qmc

from photon_engine.blender.extract import extract_scene
from photon_engine.issues import IssueLog
from photon_engine.jit import kernel
from photon_engine.lights.sample import lamps_along_ray, sample_light, suns_along_ray
from photon_engine.lights.table import Emitters, build_lights
from photon_engine.vec import add
from tests.oracle.cycles import write_float_exr

SIZE = 64  # pixels a side
EXTENT = 4.0  # of the floor in the picture [m]
BLOCKS = 4  # a side: 16 x 16 pixels each
NO_EMITTERS = Emitters(np.zeros(0, np.int32), *(np.zeros((0, 3), np.float32) for _ in range(4)))


@kernel
def floor_irradiance(lights, samples, numbers, out):
    """Irradiance of the floor (n, n, 3), bottom row first: mean over samples random points a pixel; numbers (k, 5)."""
    n = out.shape[0]
    row = 0
    for j in range(n):
        for i in range(n):
            for _ in range(samples):
                x = ((i + numbers[row, 3]) / n - 0.5) * EXTENT
                y = ((j + numbers[row, 4]) / n - 0.5) * EXTENT
                u = (numbers[row, 0], numbers[row, 1], numbers[row, 2])
                wi, _, le, pdf_w, _, _ = sample_light(lights, (x, y, 0.0), (0.0, 0.0, 1.0), u[0], u[1], u[2])
                for k in range(3):
                    out[j, i, k] += le[k] * max(0.0, wi[2]) / (pdf_w * samples)
                row += 1


@kernel
def look_up(lights, mirrored, out):
    """What a pinhole with a window of (-1/2, 1/2)^2 at distance 1 sees above it, 4 x 4 rays a pixel -> out (n, n, 3).

    mirrored : it hovers 0.5 m above a mirror at z = 0 and looks down; else it is at the origin, turned over about x.
    """
    n = 4 * out.shape[0]
    for j in range(n):
        for i in range(n):
            x = (i + 0.5) / n - 0.5
            y = ((j + 0.5) / n - 0.5) * (1.0 if mirrored else -1.0)
            scale = 1.0 / math.sqrt(x * x + y * y + 1.0)
            d = (x * scale, y * scale, scale)
            o = (0.5 * x, 0.5 * y, 0.0) if mirrored else (0.0, 0.0, 0.0)
            le = lamps_along_ray(lights, o, d, math.inf, o, 0.0, 0, not mirrored)
            le = add(le, suns_along_ray(lights, d, o, 0.0, 0, not mirrored))
            for k in range(3):
                out[j // 4, i // 4, k] += le[k] / 16.0


@pytest.fixture
def scene():
    """A floor of 40 m and an orthographic camera above it, set up for direct light without bias."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    for name, value in {
        "samples": 64,
        "use_adaptive_sampling": False,
        "use_denoising": False,
        "sample_clamp_direct": 0.0,
        "sample_clamp_indirect": 0.0,
        "blur_glossy": 0.0,
        "light_sampling_threshold": 0.0,
        "max_bounces": 0,
        "seed": 3,
        "pixel_filter_type": "BOX",
    }.items():
        setattr(scene.cycles, name, value)
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    write_float_exr(scene.render.image_settings)
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(material("ShaderNodeBsdfDiffuse"))
    floor = bpy.data.objects.new("Floor", mesh)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = EXTENT
    camera.location = (0.0, 0.0, 9.0)
    for ob in (floor, camera):
        scene.collection.objects.link(ob)
    scene.camera = camera
    return scene


def material(node, **inputs):
    """A material of one white BSDF."""
    material = bpy.data.materials.new(node)
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    bsdf = tree.nodes.new(node)
    for name, value in {"Color": (1.0, 1.0, 1.0, 1.0), "Roughness": 0.0, **inputs}.items():
        bsdf.inputs[name].default_value = value
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(bsdf.outputs[0], output.inputs["Surface"])
    return material


def add_lamp(scene, kind, location=(0.7, -0.5, 2.0), rotation=(0.3, 0.2, 0.5), scale=(1.0, 1.0, 1.0), **options):
    """A coloured lamp, tilted and off centre unless told otherwise."""
    data = bpy.data.lights.new("Lamp", kind)
    data.energy = 3.0 if kind == "SUN" else 100.0
    data.color = (1.0, 0.7, 0.3)
    visible = options.pop("visible_camera", False)
    for name, value in options.items():
        setattr(data, name, value)
    ob = bpy.data.objects.new("Lamp", data)
    ob.location, ob.rotation_euler, ob.scale = location, rotation, scale
    ob.visible_camera = visible
    scene.collection.objects.link(ob)
    return ob


def render(scene, folder):
    """Cycles' picture (n, n, 3), bottom row first."""
    scene.render.filepath = str(folder / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    return oiio.ImageBuf(scene.render.filepath).get_pixels(oiio.FLOAT)[::-1, :, :3].astype(np.float64)


def our_lights(scene):
    """The light table of the Blender scene."""
    issues = IssueLog()
    data = extract_scene(bpy.context.evaluated_depsgraph_get(), issues)
    lights = build_lights(data, NO_EMITTERS, 2, np.zeros(3), 30.0, np.zeros(3), issues)
    assert not list(issues)
    return lights


def ours(scene, samples=64):
    """Radiance of the white floor (n, n, 3) by light sampling."""
    out = np.zeros((SIZE, SIZE, 3))
    # one Sobol set, shifted anew for each pixel [Cranley, Patterson 1976]: less noise than independent numbers
    shifts = np.random.default_rng(5).random((SIZE * SIZE, 1, 5))
    numbers = (qmc.Sobol(5, scramble=False).random(samples) + shifts) % 1.0
    floor_irradiance(our_lights(scene), samples, numbers.reshape(-1, 5), out)
    return out / math.pi


def blocks(picture):
    """Means of blocks (BLOCKS, BLOCKS, 3)."""
    side = SIZE // BLOCKS
    return picture.reshape(BLOCKS, side, BLOCKS, side, 3).mean((1, 3))


def assert_blocks_agree(found, expected):
    """Within 1%, or within 1% of a tenth of the brightest block where it is darker than that."""
    found, expected = blocks(found), blocks(expected)
    floor = 0.1 * expected.max((0, 1))
    error = np.abs(found - expected) / np.maximum(expected, floor)
    assert error.max() < 0.01, f"worst block {error.max():.4f}, mean ratio {found.mean() / expected.mean():.5f}"


NEAR = {"location": (0.2, 0.1, 0.5), "rotation": (0.1, -0.2, 0.3)}
LAMPS = {
    "point": ("POINT", {"shadow_soft_size": 0.0}),
    "point not normalised": ("POINT", {"shadow_soft_size": 0.0, "normalize": False}),
    "soft point": ("POINT", {"shadow_soft_size": 0.4, "location": (0.3, 0.1, 0.6)}),
    "sphere": ("POINT", {"shadow_soft_size": 0.4, "use_soft_falloff": False, "location": (0.3, 0.1, 0.6)}),
    "sphere not normalised": ("POINT", {"shadow_soft_size": 0.4, "use_soft_falloff": False, "normalize": False}),
    "sphere through the floor": (
        "POINT",
        {"shadow_soft_size": 0.8, "use_soft_falloff": False, "location": (0, 0, 0.3)},
    ),
    "scaled point": ("POINT", {"shadow_soft_size": 0.4, "scale": (3.0, 2.0, 0.5), "location": (0.3, 0.1, 0.6)}),
    "exposure and temperature": (
        "POINT",
        {"shadow_soft_size": 0.1, "exposure": 1.5, "use_temperature": True, "temperature": 3000.0},
    ),
    "spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.0, "spot_blend": 0.4}),
    "spot without blend": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.2, "spot_blend": 0.0}),
    "soft spot": ("SPOT", {"shadow_soft_size": 0.5, "spot_size": 1.3, "spot_blend": 0.5}),
    "sphere spot": ("SPOT", {"shadow_soft_size": 0.4, "spot_size": 1.3, "spot_blend": 1.0, "use_soft_falloff": False}),
    "scaled spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": 1.0, "spot_blend": 0.5, "scale": (2.0, 0.6, 1.5)}),
    "half-space spot": ("SPOT", {"shadow_soft_size": 0.0, "spot_size": math.pi, "spot_blend": 0.5}),
    "sun": ("SUN", {"angle": 0.0}),
    "sun disk": ("SUN", {"angle": 0.6}),
    "sun not normalised": ("SUN", {"angle": 0.6, "normalize": False}),
    "square": ("AREA", {"size": 1.0}),
    "near square": ("AREA", {"size": 1.0, **NEAR}),
    "rectangle": ("AREA", {"shape": "RECTANGLE", "size": 2.0, "size_y": 0.4}),
    "scaled rectangle": ("AREA", {"shape": "RECTANGLE", "size": 1.0, "size_y": 0.4, "scale": (0.5, 3.0, 2.0)}),
    "not normalised": ("AREA", {"shape": "RECTANGLE", "size": 2.0, "size_y": 0.4, "normalize": False}),
    "disk": ("AREA", {"shape": "DISK", "size": 1.5, **NEAR}),
    "ellipse": ("AREA", {"shape": "ELLIPSE", "size": 1.5, "size_y": 0.5, "scale": (1.0, 2.0, 1.0)}),
    "mirrored area": ("AREA", {"size": 1.0, "scale": (1.0, 1.0, -1.0), "rotation": (math.pi - 0.3, 0.2, 0.5)}),
    "spread": ("AREA", {"size": 1.5, "spread": 1.0}),
    "wide spread": ("AREA", {"size": 1.0, "spread": 2.8}),
    "narrow spread": ("AREA", {"shape": "DISK", "size": 1.5, "spread": 0.2, "rotation": (0.1, 0.1, 0.0)}),
    "spread ellipse": ("AREA", {"shape": "ELLIPSE", "size": 1.5, "size_y": 0.8, "spread": 1.5, **NEAR}),
    "beam": ("AREA", {"shape": "RECTANGLE", "size": 1.5, "size_y": 2.0, "spread": 0.0}),
}


@pytest.mark.parametrize("name", LAMPS)
def test_floor_under_a_lamp(name, scene, tmp_path):
    kind, options = LAMPS[name]
    add_lamp(scene, kind, **options)
    assert_blocks_agree(ours(scene), render(scene, tmp_path))


def test_floor_under_many_lamps(scene, tmp_path):
    """Selection among lamps of all kinds, some of them below the floor or turned away.

    No two lamps share a plane: of those a ray meets but one in Cycles, and its MIS loses light.
    """
    for i, name in enumerate(("soft point", "sphere spot", "sun disk", "near square", "rectangle", "spread")):
        kind, options = LAMPS[name]
        add_lamp(scene, kind, **(options | {"location": (0.5 * i - 1.2, 0.2 * i - 0.5, 1.0 + 0.3 * i)}))
    add_lamp(scene, "AREA", (-0.8, 0.6, 1.0), (0.2, 0.4, 0.1), shape="DISK", size=0.8)
    add_lamp(scene, "AREA", rotation=(math.pi, 0.0, 0.0))
    add_lamp(scene, "POINT", location=(0.0, 0.0, -1.0))
    assert_blocks_agree(ours(scene, 128), render(scene, tmp_path))


SEEN = {
    "soft point": ("POINT", {"shadow_soft_size": 0.5}),
    "sphere": ("POINT", {"shadow_soft_size": 0.5, "use_soft_falloff": False}),
    "soft spot": ("SPOT", {"shadow_soft_size": 0.5, "spot_size": 2.5, "spot_blend": 0.3}),
    "sphere spot": ("SPOT", {"shadow_soft_size": 0.5, "spot_size": 2.5, "spot_blend": 0.3, "use_soft_falloff": False}),
    "square": ("AREA", {"size": 1.0}),
    "spread disk": ("AREA", {"shape": "DISK", "size": 1.0, "spread": 2.0}),
    "sun": ("SUN", {"angle": 0.5}),
}


@pytest.mark.parametrize(("way", "visible"), [("camera", True), ("camera", False), ("mirror", False)])
@pytest.mark.parametrize("name", SEEN)
def test_lamps_are_seen_as_in_cycles(name, visible, way, scene, tmp_path):
    """A pinhole looks at the lamp, directly or by a flat mirror; visible_camera off hides it from the first only."""
    kind, options = SEEN[name]
    add_lamp(scene, kind, (0.2, 0.1, 3.0), (0.1, 0.15, 0.2), visible_camera=visible, **options)
    scene.cycles.samples = 32
    scene.cycles.max_bounces = 1
    camera, floor = scene.camera, bpy.data.objects["Floor"]
    camera.data.type = "PERSP"
    camera.data.sensor_fit = "HORIZONTAL"
    camera.data.angle = 2.0 * math.atan(0.5)
    if way == "mirror":
        floor.data.materials[0] = material("ShaderNodeBsdfAnisotropic")
        camera.location = (0.0, 0.0, 0.5)
        camera.rotation_euler = (0.0, 0.0, 0.0)
    else:
        floor.hide_render = True
        camera.location = (0.0, 0.0, 0.0)
        camera.rotation_euler = (math.pi, 0.0, 0.0)
    picture = render(scene, tmp_path)
    lights = our_lights(scene)
    expected = np.zeros((SIZE, SIZE, 3))
    look_up(lights, way == "mirror", expected)
    if way == "camera" and not visible:
        assert picture.max() == 0.0 and expected.max() == 0.0
        return
    assert expected.max() > 0.0
    assert_blocks_agree(expected, picture)
