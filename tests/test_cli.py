"""The command line: exit codes and messages for good and bad input, and what it writes."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import numpy as np
import pytest

from photon_engine import arguments, cli
from photon_engine.driver import session
from photon_engine.driver.tests.fake import FakeRenderer, triangle_scene
from photon_engine.film.exr import read_exr
from photon_engine.film.passes import ALL_NAMES, LIGHT_NAMES, NOISY, USUAL
from photon_engine.scene.data import SceneData
from photon_engine.scene.io import save_scene
from photon_engine.settings import Settings

from .blender_process import ROOT, environment, run_script
from .brute import scenes as s

FAKE_CLI = """
import sys
from photon_engine.driver import session
from photon_engine.driver.tests.fake import FakeRenderer
session.default_renderer = FakeRenderer
import runpy
runpy.run_module("photon_engine", run_name="__main__", alter_sys=False)
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a saved scene, and the renderer without physics."""
    monkeypatch.setattr(session, "default_renderer", FakeRenderer)
    monkeypatch.chdir(tmp_path)
    save_scene(triangle_scene(), "scene.npz")
    return tmp_path


def run(capsys, *words):
    """Exit code and what was said."""
    try:
        code = cli.main([str(word) for word in words])
    except SystemExit as stop:  # argparse
        code = stop.code
    return code, capsys.readouterr().err


def test_render_writes_exr_sheet_and_log(place, capsys):
    code, said = run(capsys, "render", "scene.npz", "-o", "out.exr", "--passes", 3, "--seed", 5, "--log", "run.json")
    assert code == cli.OK and "out.exr: 3 passes" in said and "Pass 3/3" in said
    pictures, meta = read_exr("out.exr")
    assert set(pictures) == {p.name for p in USUAL} and (place / "out.png").stat().st_size > 0
    fake = FakeRenderer(triangle_scene(), Settings(seed=5), None)
    expected = np.mean([fake.render_pass(i, lambda: False)["Caustic"] for i in range(3)], axis=0, dtype=np.float64)
    np.testing.assert_allclose(pictures["Caustic"], expected, rtol=1e-6)  # float32
    assert meta["passes"] == "3" and meta["seed"] == "5"
    record = json.loads((place / "run.json").read_text())
    assert record["passes"] == 3 and record["settings"]["seed"] == 5


def test_defaults_of_output(place, capsys):
    assert run(capsys, "render", "scene.npz", "--passes", 1, "--no-sheet", "-q") == (
        0, "scene.exr: 1 passes in 0.0s, the requested passes are done\n",
    )  # fmt: skip
    assert sorted(p.name for p in place.iterdir()) == ["scene.exr", "scene.npz"]


def test_settings_by_name(place, capsys):
    code, _ = run(capsys, "render", "scene.npz", "--set", "passes=2", "--set", "final_gather=all", "--log", "r.json")
    assert code == cli.OK
    settings = json.loads((place / "r.json").read_text())["settings"]
    assert settings["passes"] == 2 and settings["final_gather"] == "ALL"


def test_seconds_alone_lift_the_limit_of_passes(place, capsys, monkeypatch):
    monkeypatch.setenv("PHOTON_MAP_FAKE_SECONDS", "0.005")
    assert run(capsys, "render", "scene.npz", "--seconds", "1", "--log", "r.json")[0] == cli.OK
    record = json.loads((place / "r.json").read_text())
    assert record["passes"] > Settings().passes and record["stop"] == "the time budget is spent"


USAGE = [
    (["render"], "required"),
    (["nonsense"], "invalid choice"),
    (["render", "scene.npz", "--resolution", "0x10"], "has no pixels"),
    (["render", "scene.npz", "--resolution", "ten"], "not WIDTHxHEIGHT"),
    (["render", "scene.npz", "--set", "photons=3"], "there is no setting of that name (one of: passes,"),
    (["render", "scene.npz", "--set", "passes"], "there is no '='"),
    (["render", "scene.npz", "--set", "alpha=7"], "alpha: 7.0 is outside [0.01, 1.0]"),
    (["render", "scene.npz", "--set", "final_gather=some"], "'SOME' is not a choice (one of: OFF, GLOSSY, ALL)"),
    (["render", "scene.npz", "--passes", "many"], "'many' is not a int"),
    (["render", "scene.npz", "--passes", "-1"], "passes: -1 is outside"),
    (["render", "scene.npz", "--camera", "Cam"], "--camera: a saved scene holds one picture only"),
    (["render", "scene.npz", "-o", "out.jpg"], "use the ending .exr"),
    (["merge", "a.npz", "-o", "out.png"], "use the ending .exr or .npz"),
]


@pytest.mark.parametrize("arguments, text", USAGE, ids=lambda v: " ".join(v) if isinstance(v, list) else "")
def test_wrong_usage_is_2_and_names_it(place, capsys, arguments, text):
    code, said = run(capsys, *arguments)
    assert code == cli.USAGE and text in said and "Traceback" not in said
    assert sorted(p.name for p in place.iterdir()) == ["scene.npz"]


def test_bad_input_is_3_and_names_it(place, capsys):
    save_scene(SceneData(name="Void"), "empty.npz")
    (place / "text.npz").write_text("hello")
    (place / "folder.blend").mkdir()
    cases = {
        "none.blend": "no such file",
        "none.npz": "no such file",
        "folder.blend": "is a folder",
        "text.npz": "not a scene file",
        "empty.npz": "Void: there is nothing to render (add objects",
    }
    for name, text in cases.items():
        code, said = run(capsys, "render", name, "--passes", 1)
        assert code == cli.BAD_INPUT and text in said and "Traceback" not in said, name
    code, said = run(capsys, "render", "scene.npz", "--set", "passes=0", "--set", "seconds=0")
    assert code == cli.BAD_INPUT and "neither passes nor seconds nor an error limit" in said
    assert run(capsys, "merge", "scene.npz", "-o", "a.exr")[1].startswith("error: scene.npz: is not a saved film")
    assert not list(place.glob("*.exr"))


def test_zero_resolution_is_3(place, capsys):
    scene = triangle_scene()
    scene.frame.width = scene.frame.x1 = 0
    save_scene(scene, "zero.npz")
    code, said = run(capsys, "render", "zero.npz", "--passes", 1)
    assert code == cli.BAD_INPUT and "frame" in said and "empty" in said and not list(place.glob("*.exr"))


def test_no_light_is_a_warning_and_a_black_picture_is_written(place, capsys):
    scene = triangle_scene()
    scene.lights = []
    save_scene(scene, "dark.npz")
    code, said = run(capsys, "render", "dark.npz", "--passes", 1)
    assert code == cli.OK and "warning: Test: there is no light: the picture will be black" in said
    assert (place / "dark.exr").exists()


def test_a_camera_inside_a_wall_is_a_warning_that_says_where_to_look(tmp_path, monkeypatch, capsys):
    """By the real renderer: it is the finished picture that is black."""
    monkeypatch.chdir(tmp_path)
    wall = s.box((-1, -0.5, -1), (1, 0.5, 1), name="wall")
    scene = s.build([(wall, s.diffuse(0.8))], [s.point_lamp((0, -3, 0), 0.1, 50.0)], s.camera((0, 0, 0), (0, 1, 0)),
                    picture=s.frame(8))  # fmt: skip
    scene.camera.name = "Eye"
    save_scene(scene, "wall.npz")
    few = ("--set", "caustic_photons=100", "--set", "diffuse_photons=100", "--passes", 1)
    code, said = run(capsys, "render", "wall.npz", *few)
    assert code == cli.OK and "warning: Eye: no light reaches anything that the camera sees" in said
    assert "inside an object" in said and not read_exr("wall.exr")[0]["Combined"][..., :3].any()


@pytest.mark.parametrize("flag", ["-o", "--log", "--state"])
@pytest.mark.parametrize("target", ["none/x", "scene.npz/x", "/proc/x", "taken"])
def test_unwritable_output_is_4_before_rendering(place, capsys, monkeypatch, flag, target):
    monkeypatch.setattr(session, "default_renderer", None)  # would fail if it came to that
    (place / "taken.exr").mkdir()
    suffix = ".exr" if flag == "-o" or target == "taken" else ".out"
    code, said = run(capsys, "render", "scene.npz", flag, f"{target}{suffix}")
    assert code == cli.BAD_OUTPUT and target in said and "Traceback" not in said


def test_a_bug_is_1_with_a_message_and_keeps_the_passes(place, capsys, monkeypatch):
    monkeypatch.setenv("PHOTON_MAP_FAKE_FAIL", "2")
    code, said = run(capsys, "render", "scene.npz", "--passes", 5, "--log", "run.json")
    assert code == cli.UNEXPECTED
    assert said.rstrip().splitlines()[-1] == (
        "error: unexpected ValueError: a bug on purpose, while rendering pass 2 of seed 0 (a bug: please report it)"
    )
    assert read_exr("scene.exr")[1]["passes"] == "2"
    assert json.loads((place / "run.json").read_text())["stop"] == "an error"


def test_denoised_render_keeps_the_noisy_pictures_and_names_the_denoiser(place, capsys):
    assert run(capsys, "render", "scene.npz", "-o", "raw.exr", "--passes", 4, "--state", "raw.npz")[0] == cli.OK
    flags = ("--passes", 4, "--set", "denoise=final", "--log", "run.json")
    assert run(capsys, "render", "scene.npz", "-o", "clean.exr", *flags)[0] == cli.OK
    raw, clean, (_, meta) = read_exr("raw.exr")[0], read_exr("clean.exr")[0], read_exr("clean.exr")
    assert set(clean) == ALL_NAMES
    for name in ("Combined", *LIGHT_NAMES):
        np.testing.assert_array_equal(clean[NOISY + name], raw[name])
        assert not np.array_equal(clean[name], raw[name])
    assert meta["denoiser"].startswith("Open Image Denoise 2.")
    record = json.loads((place / "run.json").read_text())
    assert record["stage_seconds"]["Denoising"] > 0.0 and record["denoised_error"][0]["noise"] > 0.0
    assert run(capsys, "merge", "raw.npz", "--denoise", "-o", "merged.exr")[0] == cli.OK
    np.testing.assert_array_equal(read_exr("merged.exr")[0]["Combined"], clean["Combined"])


def test_merged_and_resumed_renders_equal_one(place, capsys):
    def render(*more):
        assert run(capsys, "render", "scene.npz", *more)[0] == cli.OK

    render("-o", "whole.exr", "--passes", 8)
    render("-o", "a.exr", "--passes", 4, "--state", "a.npz")
    render("-o", "b.exr", "--passes", 4, "--first", 4, "--state", "b.npz")
    render("-o", "resumed.exr", "--passes", 4, "--resume", "a.npz")
    assert run(capsys, "merge", "b.npz", "a.npz", "-o", "merged.exr")[0] == cli.OK
    assert run(capsys, "merge", "a.npz", "b.npz", "-o", "both.npz")[0] == cli.OK
    assert run(capsys, "merge", "both.npz", "-o", "again.exr")[0] == cli.OK
    whole = read_exr("whole.exr")[0]
    for name in ("merged.exr", "resumed.exr", "again.exr"):
        for key, picture in read_exr(name)[0].items():
            np.testing.assert_array_equal(picture, whole[key])
    code, said = run(capsys, "merge", "a.npz", "a.npz", "-o", "twice.exr")
    assert code == cli.BAD_INPUT and "pass 0 of seed 0 is in twice" in said


def test_ctrl_c_keeps_what_is_rendered(place):
    command = [sys.executable, "-c", FAKE_CLI, "render", "scene.npz", "--passes", "1000"]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, cwd=place, env=environment(PHOTON_MAP_FAKE_SECONDS="0.2")
    )
    while "Pass 1/" not in (line := process.stderr.readline()):
        assert line, "ended before the first pass"
    process.send_signal(signal.SIGINT)
    said = process.stderr.read()
    assert process.wait(timeout=20) == cli.CANCELLED
    assert "cancelled by the user" in said and "Traceback" not in said
    assert int(read_exr(place / "scene.exr")[1]["passes"]) >= 1


def test_help_names_exit_codes_and_settings(capsys):
    assert run(capsys, "--help")[0] == 0
    assert "130 cancelled" in cli.parser().format_help()
    assert "caustic_photons=100000" in arguments.settings_help()


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
cube_node("ShaderNodeAmbientOcclusion").name = "My Shade"
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


@pytest.mark.slow
def test_sample_by_the_real_renderer_leaves_at_once(tmp_path):
    """End to end, as a user types it; also that bpy does not hang the exit."""
    command = [sys.executable, "-m", "photon_engine", "render", str(ROOT / "sample_blends" / "cornell_caustics.blend"),
               "--passes", "2", "--resolution", "32x32", "-o", str(tmp_path / "out.exr")]  # fmt: skip
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), cwd=tmp_path, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    pictures, meta = read_exr(tmp_path / "out.exr")
    light = sum(pictures[name].astype(np.float64) for name in LIGHT_NAMES)
    np.testing.assert_allclose(pictures["Combined"][..., :3], light, rtol=1e-6, atol=1e-9)  # float32 rounding
    assert all(pictures[name].max() > 0.0 for name in ("Direct", "Caustic", "Diffuse", "Albedo"))
    assert meta["passes"] == "2"
