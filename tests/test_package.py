"""The extension as a user gets it: built, installed by Blender's own operator, enabled, rendered with, removed."""

from __future__ import annotations

import importlib.metadata
import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
PLATFORM = "linux-x64"
WHEELS = {"numba", "llvmlite", "scipy", "embreex"}

pytestmark = pytest.mark.skipif(
    not (sys.platform == "linux" and os.uname().machine == "x86_64"), reason="the zip built here is for Linux on x86-64"
)


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """The zip that 'make package' builds; wheels that wheels/ lacks are downloaded."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, str(ROOT / "scripts" / "package.py"), "--platform", PLATFORM, "--output", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return next(folder.glob("*.zip"))


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """A site-packages folder with bpy and what bpy itself needs, as in Blender: the rest must come from the zip."""
    folder = tmp_path_factory.mktemp("blender") / "site-packages"
    folder.mkdir()
    todo, seen = ["bpy"], set()
    while todo:
        distribution = importlib.metadata.distribution(todo.pop())
        key = distribution.metadata["Name"].lower().replace("_", "-")
        if key in seen:
            continue
        seen.add(key)
        assert key not in WHEELS
        for item in distribution.files or ():
            top = folder / item.parts[0]
            if item.parts[0] not in ("..", "__pycache__") and not top.is_symlink():
                top.symlink_to(distribution.locate_file(item.parts[0]))
        for line in distribution.requires or ():
            requirement = Requirement(line)
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                todo.append(requirement.name)
    return folder


def run_blender(site: Path, profile: Path, script: str, **values) -> dict:
    """Run a script in a fresh Blender process with its own profile; returns the dictionary that it prints last."""
    foreign = ("PYTHON", "BLENDER", "PHOTON")
    environment = {key: value for key, value in os.environ.items() if not key.startswith(foreign)}
    environment["BLENDER_USER_RESOURCES"] = str(profile)
    environment["PHOTON_MAP_CACHE"] = str(profile / "kernels")
    code = f"import os, sys, json\nsys.path.append({str(site)!r})\nvalues = {values!r}\n{script}"
    code += "\nprint(json.dumps(result))\nsys.stdout.flush()\nos._exit(0)\n"
    # -S: no site-packages but ours; -I: nor anything from the environment or the current folder
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code],
        capture_output=True, text=True, env=environment, cwd=profile, check=False, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1]) | {"stderr": done.stderr}


INSTALL = """
import importlib.util
names = ["numba", "scipy", "embreex", "OpenImageIO"]
missing_before = [name for name in names if importlib.util.find_spec(name) is None]
import bpy
# the operator says FINISHED even when nothing could be installed
bpy.ops.extensions.package_install_files(
    filepath=values["package"], repo="user_default", enable_on_install=True, overwrite=True)
bpy.ops.wm.save_userpref()
result = {
    "missing_before": missing_before,
    "addons": list(bpy.context.preferences.addons.keys()),
    "engines": [getattr(cls, "bl_idname", "") for cls in bpy.types.RenderEngine.__subclasses__()],
}
"""

RENDER = """
import bpy, addon_utils
module = addon_utils.enable("bl_ext.user_default.photon_engine", default_set=True)
scene = bpy.context.scene  # Blender's own cube, lamp and camera in a grey world
scene.render.engine = "PHOTON_MAP"
scene.render.resolution_x = scene.render.resolution_y = 24
scene.render.resolution_percentage = 100
scene.photon_map.passes = 2
scene.photon_map.final_gather = "OFF"  # fewer kernels to compile: the profile's cache is empty
scene.photon_map.caustic_photons = scene.photon_map.diffuse_photons = 2000
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = values["picture"]
bpy.ops.render.render(write_still=True)
import numba, scipy, embreex
result = {
    "origins": [numba.__file__, scipy.__file__, embreex.__file__, module.__file__],
    "world": list(scene.world.color),
    "cache": os.environ["PHOTON_MAP_CACHE"],
}
"""

REMOVE = """
import bpy, addon_utils
NAME = "bl_ext.user_default.photon_engine"
addon_utils.enable(NAME)
known = hasattr(bpy.types.Scene, "photon_map")
addon_utils.disable(NAME)
gone = not hasattr(bpy.types.Scene, "photon_map")
addon_utils.enable(NAME)
again = hasattr(bpy.types.Scene, "photon_map")
repositories = [item.module for item in bpy.context.preferences.extensions.repos]
bpy.ops.extensions.package_uninstall(repo_index=repositories.index("user_default"), pkg_id="photon_engine")
result = {"known": known, "gone": gone, "again": again, "addons": list(bpy.context.preferences.addons.keys())}
"""


@pytest.fixture(scope="module")
def installed(package, site, tmp_path_factory):
    """A profile into which the zip was installed, and what Blender said of it."""
    profile = tmp_path_factory.mktemp("profile")
    return profile, run_blender(site, profile, INSTALL, package=str(package))


def test_zip_holds_the_product_and_nothing_else(package):
    with zipfile.ZipFile(package) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert {item.partition("/")[0] for item in names} == {
        "__init__.py", "blender_manifest.toml", "photon_engine", "wheels", "README.md", "CHANGELOG.md", "LICENSE",
    }  # fmt: skip
    assert not [item for item in names if "/tests/" in item or item.endswith((".pyc", ".blend"))]
    source = {path.relative_to(ROOT).as_posix() for path in (ROOT / "photon_engine").rglob("*.py")}
    assert {item for item in source if "/tests/" not in item} <= set(names)
    assert manifest["platforms"] == [PLATFORM]
    assert sorted(manifest["wheels"]) == sorted(f"./{item}" for item in names if item.endswith(".whl"))
    carried = {tuple(Path(item).name.split("-")[i] for i in (0, 2)) for item in manifest["wheels"]}
    assert carried == {(name, python) for name in WHEELS for python in ("cp311", "cp313")}


def pinned(python: str) -> dict[str, str]:
    """Version of each wheel in requirements.txt for a Python version."""
    lines = (ROOT / "requirements.txt").read_text().splitlines()
    pins = [Requirement(line) for line in lines if not line.startswith("#")]
    chosen = [pin for pin in pins if pin.marker is None or pin.marker.evaluate({"python_version": python})]
    return {pin.name: str(pin.specifier).removeprefix("==") for pin in chosen if pin.name in WHEELS}


def test_manifest_lists_every_platform_and_python_at_the_pinned_versions():
    """What 'make package ARGS=--pin' writes, without asking a registry."""
    found = []
    for item in tomllib.loads((ROOT / "blender_manifest.toml").read_text())["wheels"]:
        name, version, python, _, tag = Path(item).stem.split("-")
        found.append((name, version, python, tag.partition("_")[0]))
    expected = [
        (name, version, f"cp{python.replace('.', '')}", system)
        for python in ("3.11", "3.13")
        for name, version in pinned(python).items()
        for system in ("manylinux", "macosx", "win")
    ]
    assert sorted(found) == sorted(expected)


def test_installs_through_blenders_operator(installed):
    profile, answer = installed
    assert len(answer["missing_before"]) == 4, "what the render imports must come from the zip"
    assert "bl_ext.user_default.photon_engine" in answer["addons"]
    assert "PHOTON_MAP" in answer["engines"]
    local = list((profile / "extensions" / ".local" / "lib").glob("python*/site-packages"))
    assert [path.parent.name for path in local] == [f"python3.{sys.version_info.minor}"]
    assert {path.name for path in local[0].iterdir()} >= WHEELS


def files(folder: Path) -> list[Path]:
    """All files below a folder but Python's own caches."""
    return sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")


def test_renders_when_installed(installed, site):
    import OpenImageIO as oiio

    profile, _ = installed
    picture = profile / "picture.exr"
    extension = profile / "extensions" / "user_default" / "photon_engine"
    before = files(extension)
    answer = run_blender(site, profile, RENDER, picture=str(picture))
    assert all(origin.startswith(str(profile / "extensions")) for origin in answer["origins"])

    pixels = oiio.ImageBuf(str(picture)).get_pixels(oiio.FLOAT)[..., :3]
    assert pixels.shape == (24, 24, 3)
    # the world behind the cube is the same in every pass: exact but for single precision
    assert pixels[0, 0] == pytest.approx(answer["world"], rel=1e-5)
    lit = pixels[12, 12]  # the lamp stands to the upper right: the cube's top is brighter than the grey world
    assert (lit > 2 * pixels[0, 0]).all()
    assert (pixels >= 0).all() and (pixels < 1e3).all()

    assert files(extension) == before, "an extension must not write into its own folder"
    assert list(Path(answer["cache"]).rglob("*.nbc")), "the compiled kernels were not kept"


def test_disables_enables_again_and_uninstalls(installed, site):
    profile, _ = installed
    answer = run_blender(site, profile, REMOVE)
    assert (answer["known"], answer["gone"], answer["again"]) == (True, True, True)
    assert "bl_ext.user_default.photon_engine" not in answer["addons"]
    assert not (profile / "extensions" / "user_default" / "photon_engine").exists()
