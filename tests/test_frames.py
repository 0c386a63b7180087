"""`render --frames`: one process, a file for each frame, and what stands still is read and built once."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from photon_engine import cli
from photon_engine.blender import keep
from photon_engine.driver.frames import frame_path, parse_frames
from photon_engine.film.exr import read_exr
from photon_engine.geometry import kept

FEW = ("--passes", "1", "--threads", "1", "--no-sheet", "--quiet", "--set", "caustic_photons=500")


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A .blend of a lit cube, before it a camera that moves over three frames."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.light_add(type="POINT", location=(0.0, 0.0, 4.0))
    bpy.ops.object.camera_add(location=(0.0, 0.0, 6.0))
    scene.camera = bpy.context.object
    for frame in (1, 3):
        scene.camera.location.x = 0.4 * frame
        scene.camera.keyframe_insert("location", frame=frame)
    scene.render.resolution_x = scene.render.resolution_y = 12
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "moving.blend"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def done(monkeypatch):
    """How many meshes were read, how often triangles were made and a tree was built."""
    counts = {"read": 0, "flattened": 0, "built": 0}
    from photon_engine.blender import meshes

    def counted(name, function):
        def call(*arguments, **named):
            counts[name] += 1
            return function(*arguments, **named)

        return call

    monkeypatch.setattr(meshes, "extract_mesh", counted("read", meshes.extract_mesh))
    monkeypatch.setattr(kept, "flatten", counted("flattened", kept.flatten))
    monkeypatch.setattr(kept, "Intersector", counted("built", kept.Intersector))
    return counts


def test_a_moving_camera_costs_no_reading_and_no_tree(place, done):
    assert cli.main(["render", "moving.blend", "--frames", "1-3", *FEW]) == cli.OK
    assert done == {"read": 1, "flattened": 1, "built": 1}
    pictures = [read_exr(f"moving_{frame:04d}.exr")[0]["Combined"] for frame in (1, 2, 3)]
    assert not np.array_equal(pictures[0], pictures[1])
    # and each is the picture of that frame alone
    assert cli.main(["render", "moving.blend", "--frame", "3", "-o", "alone.exr", *FEW]) == cli.OK
    np.testing.assert_array_equal(read_exr("alone.exr")[0]["Combined"], pictures[2])
    assert keep._keep is None  # nothing is left for a render in Blender's window


def test_files_are_named_by_frame(place):
    flags = ("-o", "shot_##_a.exr", "--log", "run.json")
    assert cli.main(["render", "moving.blend", "--frames", "1-3:2", *flags, *FEW]) == cli.OK
    assert sorted(path.name for path in place.glob("shot_*")) == ["shot_01_a.exr", "shot_03_a.exr"]
    assert sorted(path.name for path in place.glob("*.json")) == ["run_0001.json", "run_0003.json"]
    assert "frame 3" in read_exr("shot_03_a.exr")[1]["scene"]


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("1-3", [1, 2, 3]), ("1..3", [1, 2, 3]), ("1-8:3", [1, 4, 7]), ("-2..1", [-2, -1, 0, 1]), ("3-1", [3, 2, 1]),
        ("7", [7]), ("1-3,2,9", [1, 2, 3, 9]),
    ],
)  # fmt: skip
def test_frames_of_a_text(text, frames):
    assert parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "1-4:0", "1-4:x", "1.5"])
def test_what_is_no_range_is_refused(text, capsys):
    with pytest.raises(ValueError, match=r"frame|step"):
        parse_frames(text)
    with pytest.raises(SystemExit):
        cli.main(["render", "x.blend", f"--frames={text}"])
    assert "--frames" in capsys.readouterr().err


def test_names_of_frames():
    assert frame_path(Path("a/b.exr"), 7) == Path("a/b_0007.exr")
    assert frame_path(Path("a/b_######.exr"), 7) == Path("a/b_000007.exr")
    assert frame_path(Path("b#c##.exr"), -7) == Path("b#c-07.exr")
    assert frame_path(Path("b.exr"), 12345) == Path("b_12345.exr")


def test_one_picture_and_several_do_not_go_together(place, capsys):
    for flags in (("--frame", "2"), ("--resume", "x.npz")):
        assert cli.main(["render", "moving.blend", "--frames", "1-2", *flags]) == cli.USAGE
        assert "--frames" in capsys.readouterr().err
