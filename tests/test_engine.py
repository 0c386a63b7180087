"""The engine inside Blender: results, layers, borders, cancelling, failing, panels; each group in one process."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio
import pytest

from photon_engine.driver.tests.fake import FakeRenderer, triangle_scene
from photon_engine.film.passes import PASSES, USUAL
from photon_engine.settings import FIELDS, Settings

from .blender_process import run_script

START = """
import bpy
import photon_engine
photon_engine.register()
photon_engine.register()
from photon_engine.blender import engine as module, result as results
def start(width=32, height=24, passes=2):
    bpy.ops.wm.read_factory_settings(use_empty=False)
    scene = bpy.context.scene
    scene.render.engine = "PHOTON_MAP"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.photon_map.passes = passes
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
        image.use_exr_interleave = True  # one part with all channels, as in Blender 4.5
    image.file_format, image.color_depth = "OPEN_EXR_MULTILAYER", "32"
    return scene
def render(scene, name, **options):
    scene.render.filepath = os.path.join(folder, name + ".exr")
    try:
        done = bpy.ops.render.render(write_still=True, **options)
        result[name] = "finished" if done == {"FINISHED"} else str(done)
    except RuntimeError as error:
        result[name] = str(error)
    result[name + " file"] = os.path.exists(scene.render.filepath)
"""

RENDERS = (
    START
    + """
scene = start()
render(scene, "plain")
scene.photon_map.seed = 3
scene.view_layers.new("Second")
for item in scene.view_layers[1].photon_map.bl_rna.properties:
    if item.identifier.startswith("use_") and item.identifier != "use_caustic":
        setattr(scene.view_layers[1].photon_map, item.identifier, False)
render(scene, "layers")
scene = start()
scene.photon_map.denoise = "FINAL"
scene.view_layers[0].photon_map.use_noisy_combined = scene.view_layers[0].photon_map.use_noisy_direct = True
render(scene, "denoised")
scene = start()
scene.render.use_border = True
border = scene.render
border.border_min_x, border.border_max_x, border.border_min_y, border.border_max_y = 0.3, 0.7, 0.1, 0.77
render(scene, "border")
scene.render.use_crop_to_border = True
render(scene, "crop")
scene = start()
scene.frame_end = 2
scene.render.filepath = os.path.join(folder, "frame")
bpy.ops.render.render(animation=True)
scene = start()
scene.render.use_persistent_data = True
render(scene, "persistent 1")
scene.photon_map.passes = 3
render(scene, "persistent 2")
scene = start()
scene.render.use_multiview = True
render(scene, "stereo")
result["notes"] = [str(issue) for issue in results.last_issues()]
scene = start()
if hasattr(scene, "compositing_node_group"):
    tree = scene.compositing_node_group = bpy.data.node_groups.new("Comp", "CompositorNodeTree")
else:
    scene.use_nodes = True
    tree = scene.node_tree
bpy.context.view_layer.update_render_passes()
node = tree.nodes.new("CompositorNodeRLayers")
node.scene = scene
sockets = lambda: [s.name for s in node.outputs if s.enabled and not getattr(s, "is_inactive", False)]
result["sockets"] = sockets()
bpy.context.view_layer.photon_map.use_albedo = False
result["sockets without albedo"] = sockets()
from photon_engine.film.exr import write_exr
from photon_engine.film.passes import PASSES
import numpy as np
pictures = {p.name: np.ones((4, 6, p.channels), np.float32) for p in PASSES}
write_exr(os.path.join(folder, "ours.exr"), pictures, "ViewLayer")
image = bpy.data.images.load(os.path.join(folder, "ours.exr"))
len(image.pixels)  # makes Blender read it
node = tree.nodes.new("CompositorNodeImage")
node.image = image
result["image"] = [image.type, sockets()]
"""
)


def read(path):
    """Channels of a multilayer EXR by name: (h, w) f32, bottom row first."""
    buffer = oiio.ImageBuf(str(path))
    pixels = buffer.get_pixels(oiio.FLOAT)[::-1]
    return {name: pixels[..., i] for i, name in enumerate(buffer.spec().channelnames)}


def expected(name, passes=2, width=32, height=24, seed=0):
    """The mean of the renderer without physics."""
    fake = FakeRenderer(triangle_scene(width, height), Settings(seed=seed), None)
    return np.mean([fake.render_pass(i, lambda: False)[name] for i in range(passes)], axis=0, dtype=np.float64)


@pytest.fixture(scope="module")
def renders(tmp_path_factory):
    """Pictures that Blender wrote."""
    folder = tmp_path_factory.mktemp("renders")
    return run_script(folder, RENDERS) | {"folder": folder}


def test_every_pass_is_in_blenders_file(renders):
    assert renders["plain"] == "finished"
    channels = read(renders["folder"] / "plain.exr")
    assert set(channels) == {f"ViewLayer.{p.name}.{letter}" for p in USUAL for letter in p.ids}
    for name, letter, index in (("Caustic", "G", 1), ("Normal", "Z", 2), ("Albedo", "R", 0)):
        # 1e-6: float32; the rows are the right way up
        np.testing.assert_allclose(channels[f"ViewLayer.{name}.{letter}"], expected(name)[..., index], rtol=1e-6)
    np.testing.assert_array_equal(channels["ViewLayer.Depth.Z"], expected("Depth", passes=1)[..., 0].astype(np.float32))
    light = sum(channels[f"ViewLayer.{p.name}.B"].astype(np.float64) for p in PASSES[1:6])
    np.testing.assert_allclose(channels["ViewLayer.Combined.B"], light, rtol=1e-6)


def test_layers_have_the_passes_they_ask_for(renders):
    assert renders["layers"] == "finished"
    channels = read(renders["folder"] / "layers.exr")
    second = {name.removeprefix("Second.") for name in channels if name.startswith("Second.")}
    assert second == {*(f"Combined.{c}" for c in "RGBA"), *(f"Caustic.{c}" for c in "RGB")}
    for layer in ("ViewLayer", "Second"):
        np.testing.assert_allclose(channels[f"{layer}.Caustic.R"], expected("Caustic", seed=3)[..., 0], rtol=1e-6)


def test_denoised_passes_and_the_noisy_ones_beside_them(renders):
    assert renders["denoised"] == "finished"
    channels = read(renders["folder"] / "denoised.exr")
    for name in ("Noisy Direct", "Noisy Combined", "Direct", "Combined"):
        raw = expected("Direct")[..., 1]
        if "Combined" in name:
            raw = sum(expected(p.name)[..., 1] for p in PASSES[1:6])
        same = np.allclose(channels[f"ViewLayer.{name}.G"], raw, rtol=1e-6)
        assert same == name.startswith("Noisy")
    assert channels["ViewLayer.Direct.G"].std() < 0.5 * channels["ViewLayer.Noisy Direct.G"].std()


def test_border_with_and_without_crop(renders):
    # single precision, towards zero: 0.3 * 32 = 9, 0.7 * 32 = 22, 0.1 * 24 = 2, 0.77 * 24 = 18
    part = expected("Direct", width=22 - 9, height=18 - 2)[..., 0]
    crop = read(renders["folder"] / "crop.exr")["ViewLayer.Direct.R"]
    np.testing.assert_allclose(crop, part, rtol=1e-6)
    full = read(renders["folder"] / "border.exr")["ViewLayer.Direct.R"]
    assert full.shape == (24, 32)
    np.testing.assert_allclose(full[2:18, 9:22], part, rtol=1e-6)
    assert np.count_nonzero(full) == np.count_nonzero(part)


def test_animation_and_persistent_data(renders):
    names = {path.name for path in renders["folder"].glob("frame*.exr")}
    assert names == {"frame0001.exr", "frame0002.exr"}
    for name, passes in (("persistent 1", 2), ("persistent 2", 3)):
        channel = read(renders["folder"] / f"{name}.exr")["ViewLayer.Direct.R"]
        np.testing.assert_allclose(channel, expected("Direct", passes)[..., 0], rtol=1e-6)


def test_stereo_says_that_it_is_not_supported(renders):
    assert renders["stereo"] == "finished" and any("stereoscopy" in note for note in renders["notes"])


def test_compositor_has_a_socket_for_each_pass(renders):
    assert {p.name for p in USUAL if p.name != "Combined"} <= set(renders["sockets"])
    assert "Image" in renders["sockets"] and "Albedo" not in renders["sockets without albedo"]


def test_blender_opens_the_command_lines_file_as_multilayer(renders):
    kind, names = renders["image"]
    assert kind == "MULTILAYER" and {p.name for p in PASSES} <= set(names)


FAILURES = (
    START
    + """
os.environ["PHOTON_MAP_FAKE_FAIL"] = "1"
render(start(), "bug")
result["bug size"] = list(bpy.data.images["Render Result"].size) if "Render Result" in bpy.data.images else []
os.environ["PHOTON_MAP_FAKE_FAIL"] = "-1"
scene = start()
bpy.data.objects.remove(bpy.data.objects["Cube"]); bpy.data.objects.remove(bpy.data.objects["Light"])
scene.world = None
render(scene, "empty")
scene = start()
bpy.data.objects.remove(bpy.data.objects["Camera"])
render(scene, "no camera")
scene = start()
scene.photon_map.passes = 0
render(scene, "no budget")
scene = start()
scene.render.use_border = True
scene.render.border_min_x = scene.render.border_max_x = 0.5
render(scene, "thin border")
scene = start(16, 16)
scene.render.resolution_percentage = 1
render(scene, "one percent")
scene = start()
bpy.data.objects.remove(bpy.data.objects["Light"])
scene.world = None
render(scene, "no light")
result["notes"] = [str(issue) for issue in results.last_issues()]
scene = start()
bpy.data.cameras["Camera"].type = "PANO"
render(scene, "panorama")

listener = results.EngineListener
for name, after in (("cancel at once", 0), ("cancel later", 2)):
    asked = {"n": 0}
    def cancelled(self):
        asked["n"] += 1
        return asked["n"] > after * 2 + 1
    original, listener.cancelled = listener.cancelled, cancelled
    render(start(passes=50), name)
    listener.cancelled = original
from photon_engine.blender import extract
def broken(*_, **__): raise ZeroDivisionError("in extraction")
extract.extract_scene, original = broken, extract.extract_scene
render(start(), "broken extraction")
extract.extract_scene = original
render(start(), "well again")
"""
)


@pytest.fixture(scope="module")
def failures(tmp_path_factory):
    """What Blender's operator says when things go wrong, saving multilayer EXR (which crashes without a result)."""
    folder = tmp_path_factory.mktemp("failures")
    return run_script(folder, FAILURES) | {"folder": folder}


@pytest.mark.parametrize(
    "case, text",
    [
        ("bug", "unexpected ValueError: a bug on purpose, while rendering pass 1 of seed 0"),
        ("empty", "there is nothing to render (add objects"),
        ("no camera", "no camera"),
        ("no budget", "neither passes nor seconds nor an error limit the render"),
        ("thin border", "too small"),
        ("one percent", "too small"),
        ("panorama", "Camera: "),
        ("broken extraction", "unexpected ZeroDivisionError: in extraction"),
    ],
)
def test_failure_is_an_error_of_the_operator_and_no_file(failures, case, text):
    assert text in failures[case], failures[case]
    assert not failures[f"{case} file"]


def test_no_light_is_told_but_rendered(failures):
    assert failures["no light"] == "finished" and failures["no light file"]
    assert any("there is no light" in note for note in failures["notes"])


def test_cancelling_keeps_what_is_rendered(failures):
    black = read(failures["folder"] / "cancel at once.exr")["ViewLayer.Combined.R"]
    assert not black.any()
    kept = read(failures["folder"] / "cancel later.exr")["ViewLayer.Direct.R"]
    matches = [np.allclose(kept, expected("Direct", passes)[..., 0], rtol=1e-6) for passes in (1, 2, 3)]
    assert sum(matches) == 1


def test_renders_again_after_failures(failures):
    assert failures["well again"] == "finished" and failures["well again file"]


PANELS = (
    START
    + """
from photon_engine.blender import properties, ui
from photon_engine.settings import Settings
scene = start(passes=Settings().passes)
result["same"] = properties.settings_from(scene) == Settings()
scene.photon_map.alpha, scene.photon_map.final_gather, scene.photon_map.threads = 0.5, "ALL", 2
result["changed"] = properties.settings_from(scene).to_dict()
result["text"] = {p.identifier: [p.name, p.description] for p in scene.photon_map.bl_rna.properties}

class Layout:
    '''Records what a panel shows, and that each property exists.'''
    def __init__(self, shown): self.shown = shown
    def column(self, **_): return Layout(self.shown)
    row = column
    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties, (data, name)
        self.shown.append(name)
    def label(self, text="", **_): self.shown.append(text)
    def separator(self): pass

class Context:
    engine = "PHOTON_MAP"
    scene = bpy.context.scene
    view_layer = bpy.context.view_layer
    object = bpy.data.objects["Cube"]
    light = None

shown = []
class Shown: layout = Layout(shown)
lights = [bpy.data.lights.new(kind, kind) for kind in ("POINT", "SPOT", "SUN", "AREA")]
scene.render.film_transparent = True
for cls in ui.CLASSES:
    for light in lights:
        Context.light = light
        assert cls.poll(Context), cls
        cls.draw(Shown, Context)
result["shown"] = shown
Context.engine = "CYCLES"
result["elsewhere"] = [cls.__name__ for cls in ui.CLASSES if cls.poll(Context)]
Context.engine, Context.light = "PHOTON_MAP", None
result["light panel without lamp"] = ui.PHOTON_MAP_PT_light.poll(Context)
result["adopted"] = [panel.__name__ for panel in ui.adopted_panels()]
photon_engine.unregister()
photon_engine.unregister()
others = [p for p in bpy.types.Panel.__subclasses__() if not p.__name__.startswith("PHOTON_MAP")]
result["left"] = [p.__name__ for p in others if "PHOTON_MAP" in getattr(p, "COMPAT_ENGINES", ())]
result["properties left"] = hasattr(bpy.types.Scene, "photon_map") or hasattr(bpy.types.ViewLayer, "photon_map")
photon_engine.register()
render(start(), "registered again")
"""
)


@pytest.fixture(scope="module")
def panels(tmp_path_factory):
    """Properties and panels."""
    return run_script(tmp_path_factory.mktemp("panels"), PANELS)


def test_properties_are_the_settings(panels):
    assert panels["same"]
    changed = Settings(**panels["changed"])
    assert (changed.alpha, changed.final_gather, changed.threads) == (0.5, "ALL", 2)
    for name, item in FIELDS.items():
        assert panels["text"][name] == [item.metadata["label"], item.metadata["text"]]


def test_panels_show_every_setting_and_only_for_this_engine(panels):
    assert set(FIELDS) <= set(panels["shown"])
    assert {"use_caustic", "film_transparent", "energy", "spot_size", "spread", "angle"} <= set(panels["shown"])
    assert panels["elsewhere"] == [] and not panels["light panel without lamp"]


def test_blenders_panels_are_adopted_and_given_back(panels):
    wanted = {"RENDER_PT_format", "RENDER_PT_output", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface",
              "EEVEE_MATERIAL_PT_context_material", "DATA_PT_lens", "DATA_PT_camera_dof"}  # fmt: skip
    assert wanted <= set(panels["adopted"])
    assert not {"DATA_PT_light", "VIEWLAYER_PT_layer_passes"} & set(panels["adopted"])
    assert not [name for name in panels["adopted"] if "freestyle" in name.lower()]
    assert panels["left"] == [] and not panels["properties left"]
    assert panels["registered again"] == "finished"


VIEWPORT = (
    START
    + """
import gpu
if hasattr(gpu, "init"):
    gpu.init()
    screen = gpu.types.GPUOffScreen(400, 60)
    from mathutils import Matrix
    pixel_space = Matrix(((2 / 400, 0, 0, -1), (0, 2 / 60, 0, -1), (0, 0, 1, 0), (0, 0, 0, 1)))
    with screen.bind():
        gpu.matrix.load_matrix(Matrix.Identity(4))
        gpu.matrix.load_projection_matrix(pixel_space)  # as Blender sets it before view_draw
        module.draw_message(400, 60, module.VIEWPORT_TEXT)
        pixels = gpu.state.active_framebuffer_get().read_color(0, 0, 400, 60, 4, 0, "FLOAT")
    pixels.dimensions = 400 * 60 * 4
    values = list(pixels)
    result["drawn"] = [min(values[0::4]), max(values[0::4])]
"""
)


def test_viewport_message_is_drawn(tmp_path):
    result = run_script(tmp_path, VIEWPORT)
    if "drawn" not in result:
        pytest.skip("this Blender cannot draw without a window (gpu.init, from 5.2)")
    dark, bright = result["drawn"]
    assert dark < 0.1 and bright > 0.5
