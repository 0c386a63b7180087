"""The command line given .blend files: their settings, what they lack, and what is no .blend at all."""

from __future__ import annotations

import json

import numpy as np
import pytest

from photon_engine import cli
from photon_engine.film.exr import read_exr

from .blender_process import run_script

BLENDS = """
import bpy
def fresh(name, **_):
    bpy.ops.wm.read_factory_settings(use_empty=False)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    return scene
def save(name):
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, name + ".blend"))
from photon_engine.blender import properties
properties.register()

scene = fresh("good")
scene.photon_map.passes = 2
scene.photon_map.seed = 11
hidden = bpy.data.objects.new("Hidden", bpy.data.meshes["Cube"]); scene.collection.objects.link(hidden)
hidden.hide_render = True
other = bpy.data.objects.new("Second", bpy.data.cameras.new("Second")); scene.collection.objects.link(other)
other.data.type = "ORTHO"
layer = scene.view_layers.new("Other Layer")
bpy.data.objects["Cube"].modifiers.new("S", "SUBSURF").render_levels = 2
bpy.data.objects["Cube"].modifiers["S"].levels = 0
save("good")

fresh("x"); bpy.data.objects.remove(bpy.data.objects["Camera"]); save("no_camera")
fresh("x"); bpy.data.objects.remove(bpy.data.objects["Light"])
bpy.context.scene.world = None; save("no_light")
fresh("x")
for name in ("Cube", "Light"): bpy.data.objects.remove(bpy.data.objects[name])
bpy.context.scene.world = None; save("empty")
fresh("x").render.resolution_percentage = 1; save("one_percent")

def cube_node(kind):
    fresh("x")
    material = bpy.data.materials["Material"]
    material.use_nodes = True
    tree = material.node_tree
    shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    node = tree.nodes.new(kind)
    tree.links.new(node.outputs[0], shader.inputs["Base Color"])
    return node
node = cube_node("ShaderNodeTexImage")
node.image = bpy.data.images.new("wood.png", 4, 4)
node.image.source = "FILE"; node.image.filepath = "//missing/wood.png"
save("missing_texture")
cube_node("ShaderNodeShaderToRGB").name = "My Shade"  # of EEVEE alone
save("unknown_node")

fresh("x"); save("library")
fresh("x")
with bpy.data.libraries.load(os.path.join(folder, "library.blend"), link=True) as (source, target):
    target.objects = ["Cube"]
bpy.context.scene.collection.objects.link(target.objects[0])
save("broken_link")
os.unlink(os.path.join(folder, "library.blend"))
good = open(os.path.join(folder, "good.blend"), "rb").read()
broken = {
    "not": b"hello", "nothing": b"", "half": good[: len(good) // 2], "end_gone": good[:-100],
    "zeroed": bytes(64) + good[64:], "other_version": good[:7] + b"99-99v9999" + good[17:],
    "backwards": good[:64] + good[64:][::-1], "zipped": bytes.fromhex("1f8b0800") + good[4:],
    "png": bytes.fromhex("89504e47"),
}
for name, content in broken.items():
    with open(os.path.join(folder, name + ".blend"), "wb") as file: file.write(content)
"""

RUN_ALL = """
import contextlib, io
from photon_engine import arguments, cli
os.chdir(folder)
for name, arguments in values["cases"].items():
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = cli.main(arguments)
        except SystemExit as stop:
            code = stop.code
    result[name] = {"code": code, "out": out.getvalue(), "err": err.getvalue()}
"""


BROKEN = ("not", "nothing", "half", "end_gone", "zeroed", "other_version", "backwards", "zipped", "png")


@pytest.fixture(scope="module")
def blends(tmp_path_factory):
    """What the command line says to many .blend files: case -> {code, out, err}, and the folder."""
    folder = tmp_path_factory.mktemp("blends")
    cases = {
        "good": ["render", "good.blend", "--log", "good.json"],
        "flags": ["render", "good.blend", "-o", "flags.exr", "--passes", "1", "--seed", "3", "--camera", "Second",
                  "--view-layer", "Other Layer", "--frame", "7", "--resolution", "20x10", "--log", "flags.json"],
        "no camera": ["render", "no_camera.blend"],
        "no light": ["render", "no_light.blend", "--passes", "1"],
        "empty": ["render", "empty.blend"],
        "one percent": ["render", "one_percent.blend"],
        "missing texture": ["render", "missing_texture.blend", "--passes", "1"],
        "unknown node": ["info", "unknown_node.blend"],
        "broken link": ["render", "broken_link.blend", "--passes", "1"],
        **{name: ["render", name + ".blend", "--passes", "1"] for name in BROKEN},
        "other camera": ["render", "good.blend", "--camera", "Cube"],
        "other layer": ["render", "good.blend", "--view-layer", "Nope"],
        "tiny": ["render", "good.blend", "--resolution", "1x1", "--passes", "1"],
        "info": ["info", "good.blend"],
        "json": ["info", "good.blend", "--json"],
        "extract": ["extract", "good.blend", "-o", "extracted.npz"],
        "extracted": ["render", "extracted.npz", "-o", "extracted.exr", "--passes", "2", "--seed", "11"],
    }  # fmt: skip
    run_script(folder, BLENDS)
    return run_script(folder, RUN_ALL, cases=cases) | {"folder": folder}


def test_blend_with_its_own_settings(blends):
    assert blends["good"]["code"] == cli.OK, blends["good"]["err"]
    record = json.loads((blends["folder"] / "good.json").read_text())
    assert (record["passes"], record["seed"], record["resolution"]) == (2, 11, [32, 24])
    assert record["frame"] == 1 and record["camera"] == "Camera"


def test_flags_override_the_blend(blends):
    assert blends["flags"]["code"] == cli.OK, blends["flags"]["err"]
    record = json.loads((blends["folder"] / "flags.json").read_text())
    assert (record["passes"], record["seed"], record["resolution"]) == (1, 3, [20, 10])
    assert record["frame"] == 7 and record["camera"] == "Second"
    pictures, _ = read_exr(blends["folder"] / "flags.exr")
    assert pictures["Combined"].shape == (10, 20, 4)


@pytest.mark.parametrize(
    "case, code, text",
    [
        ("no camera", cli.BAD_INPUT, "the scene has no camera (add one, or name one with --camera)"),
        ("no light", cli.OK, "there is no light: the picture will be black"),
        ("empty", cli.BAD_INPUT, "there is nothing to render"),
        ("one percent", cli.BAD_INPUT, "Blender cannot render it: Error: Image too small"),
        ("missing texture", cli.OK, "wood.png"),
        ("broken link", cli.OK, "library.blend"),
        *((name, cli.BAD_INPUT, f"{name}.blend: Blender cannot open it") for name in BROKEN),
        ("other camera", cli.BAD_INPUT, "Cube: there is no camera of that name (the file has: Camera, Second)"),
        ("other layer", cli.BAD_INPUT, "Nope: there is no view layer of that name (the file has: ViewLayer, Other"),
        ("tiny", cli.BAD_INPUT, "Blender refuses"),
    ],
)
def test_bad_blends_have_a_code_and_a_message(blends, case, code, text):
    told = blends[case]
    assert told["code"] == code and text in told["err"] and "Traceback" not in told["err"], told
    if code == cli.OK:
        assert "warning: " in told["err"]


def test_info_tells_what_a_render_would_see(blends):
    assert blends["info"]["code"] == cli.OK, blends["info"]["err"]
    lines = dict(line.split(":", 1) for line in blends["info"]["out"].splitlines() if ":" in line)
    # a cube subdivided twice (render level; the viewport's is 0): 6 * 4^2 quads; the hidden copy is left out
    assert lines["objects"].strip() == "1 of 1 meshes, 192 triangles"
    assert lines["budget"].strip() == "2 passes" and lines["picture"].strip() == "32 x 24"
    record = json.loads(blends["json"]["out"])
    assert record["triangles"] == 192 and record["settings"]["seed"] == 11 and record["issues"] == []


def test_info_names_an_unknown_node(blends):
    told = blends["unknown node"]
    assert told["code"] == cli.OK and "My Shade" in told["out"] and "Material" in told["out"], told


def test_extracted_scene_renders_without_blender(blends):
    assert blends["extract"]["code"] == cli.OK and blends["extracted"]["code"] == cli.OK, blends["extract"]
    a, b = (read_exr(blends["folder"] / name)[0] for name in ("good.exr", "extracted.exr"))
    np.testing.assert_array_equal(a["Combined"], b["Combined"])
