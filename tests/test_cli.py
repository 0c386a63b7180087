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

from .blender_process import ROOT, environment
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
    (["render", "scene.npz", "--set", "final_gather=some"], "'SOME' is not a choice (one of: AUTO, OFF, GLOSSY, ALL)"),
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
