"""Where our camera rays go, against Cycles: a plane that shines with its own position, seen by both.

The first sample of a pixel in Cycles goes through the pixel's centre, so one sample suffices where lens and filter are
not in question.
"""

import math
import os

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest

from photon_engine.blender.cameras import extract_camera, extract_frame
from photon_engine.blender.places import Places
from photon_engine.camera.rays import build_camera, generate_ray
from photon_engine.issues import IssueLog, RenderError

OFFSET = 40.0  # keeps the shining position positive: Cycles drops negative light
SIZE = 60.0


@pytest.fixture
def scene():
    """An empty scene with a camera above a plane that emits its position plus OFFSET."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.seed = 11
    # the middle of Cycles' filter table lies 5e-4 px (1.5 px wide) to the right of the pixel's centre
    scene.cycles.filter_width = 0.01
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    mesh = bpy.data.meshes.new("Plane")
    s = SIZE
    mesh.from_pydata([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [], [(0, 1, 2, 3)])
    plane = bpy.data.objects.new("Plane", mesh)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0.3, -0.2, 5.0)
    camera.rotation_euler = (0.3, 0.1, 0.4)
    camera.scale = (2.0, 0.5, 3.0)  # must not matter
    for ob in (plane, camera):
        scene.collection.objects.link(ob)
    scene.camera = camera
    mesh.materials.append(position_material())
    return scene


def position_material(power=1):
    """Emission of ((position + OFFSET) / OFFSET) ** power."""
    material = bpy.data.materials.new("Position")
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    value = tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
    first = tree.nodes.new("ShaderNodeVectorMath")
    first.operation = "MULTIPLY_ADD"
    first.inputs[1].default_value = [1.0 / OFFSET] * 3
    first.inputs[2].default_value = [1.0] * 3
    tree.links.new(value, first.inputs[0])
    value = first.outputs[0]
    for _ in range(power - 1):
        product = tree.nodes.new("ShaderNodeVectorMath")
        product.operation = "MULTIPLY"
        tree.links.new(value, product.inputs[0])
        tree.links.new(first.outputs[0], product.inputs[1])
        value = product.outputs[0]
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(value, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def render(scene, folder):
    """Cycles' picture, (h, w, 3), bottom row first."""
    scene.render.filepath = os.path.join(str(folder), "picture.exr")
    bpy.ops.render.render(write_still=True)
    source = oiio.ImageInput.open(scene.render.filepath)
    pixels = source.read_image(0, 0, 0, 3, oiio.FLOAT)
    source.close()
    return np.asarray(pixels)[::-1]


def our_table(scene):
    """Camera and frame as extracted, and the table for kernels."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    frame = extract_frame(scene)
    return build_camera(extract_camera(scene, depsgraph, Places(), IssueLog()), frame), frame


def hit(table, px, py, u=(0.5, 0.5, 0.5, 0.5)):
    """Where our ray meets the plane z = 0, or None when that is clipped away."""
    o, d, near, far, *_ = generate_ray(table, px, py, *u)
    t = -o[2] / d[2] if d[2] != 0.0 else math.inf
    return np.array(o) + t * np.array(d) if near <= t <= far else None


def our_picture(scene):
    """What the picture of positions must be."""
    table, frame = our_table(scene)
    out = np.zeros((frame.y1 - frame.y0, frame.x1 - frame.x0, 3))
    for row in range(out.shape[0]):
        for column in range(out.shape[1]):
            p = hit(table, frame.x0 + column, frame.y0 + row)
            if p is not None:
                out[row, column] = p / OFFSET + 1.0
    return out


def assert_agree(scene, folder):
    ours, theirs = our_picture(scene), render(scene, folder)
    assert theirs.shape == ours.shape
    assert (theirs > 0.0).any()
    # Cycles computes in single precision: 40 m keep 5e-6 m at most; measured 1e-6 of OFFSET
    np.testing.assert_allclose(ours, theirs, atol=5e-6, rtol=5e-6)


@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", [(20, 12), (11, 23)])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_sensor_fit_shift_and_aspect(scene, tmp_path, kind, size, fit):
    data = scene.camera.data
    data.type, data.sensor_fit = kind, fit
    data.lens, data.sensor_width, data.sensor_height, data.ortho_scale = 42.0, 31.0, 17.0, 3.7
    data.shift_x, data.shift_y = 0.13, -0.21
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = (1.0, 1.4) if fit == "AUTO" else (1.3, 1.0)
    assert_agree(scene, tmp_path)


def test_resolution_percentage_rounds_down(scene, tmp_path):
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 31, 17, 67
    assert_agree(scene, tmp_path)


@pytest.mark.parametrize("border", [(0.2, 0.7, 0.3, 0.9), (0.31, 0.52, 0.0, 1.0)])
def test_cropped_border(scene, tmp_path, border):
    render_settings = scene.render
    render_settings.use_border = render_settings.use_crop_to_border = True
    (render_settings.border_min_x, render_settings.border_max_x,
     render_settings.border_min_y, render_settings.border_max_y) = border  # fmt: skip
    assert_agree(scene, tmp_path)


def test_border_without_crop_keeps_the_frame(scene, tmp_path):
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.2, 0.7
    scene.render.border_min_y, scene.render.border_max_y = 0.3, 0.9
    theirs = render(scene, tmp_path)
    _, frame = our_table(scene)
    inside = theirs[frame.y0 : frame.y1, frame.x0 : frame.x1]
    np.testing.assert_allclose(our_picture(scene), inside, atol=5e-6, rtol=5e-6)
    assert np.count_nonzero(theirs.any(axis=2)) == inside.shape[0] * inside.shape[1]


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_clipping(scene, tmp_path, kind):
    data = scene.camera.data
    scene.camera.rotation_euler = (0.9, 0.0, 0.0)
    data.type, data.lens, data.ortho_scale = kind, 20.0, 8.0
    data.clip_start, data.clip_end = 5.0, 9.0
    ours = our_picture(scene)
    assert 20 < np.count_nonzero(ours.any(axis=2)) < 230  # both planes cut
    assert_agree(scene, tmp_path)


LENSES = [
    ("PERSP", 0, 0.0, 1.0), ("PERSP", 0, 0.0, 2.0), ("PERSP", 3, 0.4, 1.0), ("PERSP", 5, 1.0, 0.5),
    ("ORTHO", 3, 0.9, 1.3),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "blades", "rotation", "ratio"), LENSES)
def test_lens(scene, tmp_path, kind, blades, rotation, ratio):
    """Third powers of position, averaged over the lens: size, squeeze, corners and rotation all show in them."""
    scene.camera.location = (2.0, 1.0, 10.0)
    scene.camera.rotation_euler = (0.0, 0.0, 0.25)
    scene.camera.data.type = kind
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.cycles.samples = 4096
    dof = scene.camera.data.dof
    dof.use_dof, dof.focus_distance = True, 0.5
    dof.aperture_fstop = 0.04 if kind == "PERSP" else 0.8
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = blades, rotation, ratio
    scene.objects["Plane"].data.materials[0] = position_material(3)
    theirs = render(scene, tmp_path)
    table, _ = our_table(scene)
    # 60 is a multiple of the numbers of blades, so that each wedge of the polygon has its own whole grid
    u = (np.stack(np.meshgrid(np.arange(60), np.arange(60)), -1).reshape(-1, 2) + 0.5) / 60
    for px, py in ((0, 0), (2, 3)):
        values = np.array([(hit(table, px, py, (0.5, 0.5, *v)) / OFFSET + 1.0) ** 3 for v in u])
        mean = values.mean(axis=0)
        # 4096 Sobol points against a grid of 3600: a fifth of the error of 4096 random points; measured 0.3 of it
        tolerance = values.std(axis=0) / math.sqrt(4096) / 5.0 + 2e-6
        assert values.std(axis=0)[0] > 0.05  # the lens matters
        assert (np.abs(theirs[py, px] - mean) <= tolerance).all(), (theirs[py, px] - mean, tolerance)


def test_focus_object_counts_along_the_view_axis(scene, tmp_path):
    focus = bpy.data.objects.new("Focus", None)
    focus.location = (3.0, 2.0, 1.0)
    scene.collection.objects.link(focus)
    dof = scene.camera.data.dof
    dof.use_dof, dof.focus_object = True, focus
    camera = extract_camera(scene, bpy.context.evaluated_depsgraph_get(), Places(), IssueLog())
    axis = -np.array(scene.camera.matrix_world.to_quaternion().to_matrix())[:, 2]
    expected = axis @ np.array(focus.location - scene.camera.location)
    assert camera.focus_distance == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("name", ["BOX", "GAUSSIAN", "BLACKMAN_HARRIS"])
def test_pixel_filter(scene, tmp_path, name):
    """Third powers of position again, now spread by the filter: pixels of 10 m make it visible."""
    scene.camera.rotation_euler = (0.0, 0.0, 0.0)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 40.0
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.cycles.samples = 4096
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = name, 1.1
    scene.objects["Plane"].data.materials[0] = position_material(3)
    theirs = render(scene, tmp_path)
    table, frame = our_table(scene)
    assert frame.filter == name
    u = (np.arange(4096) + 0.5) / 4096
    x = np.array([hit(table, 2, 1, (v, v, 0.5, 0.5))[:2] for v in u]) / OFFSET + 1.0
    mean = (x**3).mean(axis=0)
    # Cycles' table of 1024 linear steps widens the tails: its Gaussian has 2.8% more variance than the formula, its
    # Blackman-Harris window 0.5%; its mean lies 6e-4 px off the centre. Together 1.1e-3 and 3e-4 of this picture
    np.testing.assert_allclose(theirs[1, 2, :2], mean, rtol=1.5e-3)
    spread = (x**3).mean(axis=0) - x.mean(axis=0) ** 3
    assert (spread > 5e-3).all()  # twenty times the tolerance


def test_panoramas_are_refused_by_name(scene):
    scene.camera.data.type = "PANO"
    with pytest.raises(RenderError, match="Camera: pano cameras are not supported"):
        our_table(scene)


def test_a_scene_without_camera_is_refused(scene):
    scene.camera = None
    with pytest.raises(RenderError, match="no camera"):
        our_table(scene)


def test_rays_match_blenders_view_of_points(scene):
    """world_to_camera_view of random points of our rays is their pixel."""
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    rng = np.random.default_rng(4)
    scene.camera.data.shift_x = 0.3
    scene.render.resolution_x = 50
    scene.render.pixel_aspect_y = 1.2
    table, frame = our_table(scene)
    for _ in range(50):
        px, py = int(rng.integers(frame.width)), int(rng.integers(frame.height))
        o, d, *_ = generate_ray(table, px, py, 0.5, 0.5, 0.5, 0.5)
        t = rng.uniform(1.0, 20.0)
        view = world_to_camera_view(scene, scene.camera, Vector(np.array(o) + t * np.array(d)))
        # single precision in Blender
        assert view.x * frame.width == pytest.approx(px + 0.5, abs=1e-3)
        assert view.y * frame.height == pytest.approx(py + 0.5, abs=1e-3)
