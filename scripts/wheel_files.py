"""Which wheels the extension carries for each platform and Python, and how they are fetched."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "wheels"

# Blender has its own numpy, and writes pictures itself: bpy, numpy and OpenImageIO are for running without Blender
PACKAGES = ("numba", "llvmlite", "scipy", "embreex")
PYTHONS = ("3.11", "3.13")  # Blender 4.5 LTS to 5.0, Blender 5.1 and later

# Blender's name of a platform -> the wheel tags that run wherever that Blender runs
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_13_0_arm64",),
}


def pinned(python: str) -> list[str]:
    """``name==version`` of each package, for a Python version (pip takes markers from the running Python instead)."""
    found = {}
    for line in (ROOT / "requirements.txt").read_text().splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        requirement = Requirement(line)
        if requirement.marker is None or requirement.marker.evaluate({"python_version": python}):
            found[requirement.name] = f"{requirement.name}{requirement.specifier}"
    return [found[name] for name in PACKAGES]


def _pip(*arguments: str) -> str:
    command = [sys.executable, "-m", "pip", *arguments, "--disable-pip-version-check", "--quiet"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(f"pip could not find the extension's wheels (see above): pip {' '.join(arguments)}")
    return done.stdout


def _target(platform: str, python: str) -> list[str]:
    tags = [argument for tag in PLATFORMS[platform] for argument in ("--platform", tag)]
    return ["--no-deps", "--only-binary=:all:", "--python-version", python, "--implementation", "cp", *tags]


def file_names(platform: str, python: str) -> list[str]:
    """File names of the wheels that pip would choose, without downloading them."""
    report = _pip(
        "install", "--dry-run", "--ignore-installed", "--target", str(ROOT / "build" / "nowhere"), "--report", "-",
        *_target(platform, python), *pinned(python),
    )  # fmt: skip
    return [item["download_info"]["url"].rpartition("/")[2] for item in json.loads(report)["install"]]


def fetch(platform: str, names: list[str]) -> list[Path]:
    """Paths of the named wheels in wheels/; those that are missing there are downloaded."""
    FOLDER.mkdir(exist_ok=True)
    for python in PYTHONS:
        tag = f"-cp{python.replace('.', '')}-"
        if any(tag in name and not (FOLDER / name).exists() for name in names):
            _pip("download", "--dest", str(FOLDER), *_target(platform, python), *pinned(python))
    missing = [name for name in names if not (FOLDER / name).exists()]
    if missing:
        sys.exit(f"the manifest names wheels that requirements.txt does not give: {', '.join(missing)}\n"
                 "run: make package ARGS=--pin")  # fmt: skip
    return [FOLDER / name for name in names]
