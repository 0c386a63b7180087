"""Builds the extension's zip for one platform with Blender's own builder.

python scripts/package.py [--platform linux-x64] [--output dist] [--pin]
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import wheel_files

ROOT = wheel_files.ROOT
MANIFEST = ROOT / "blender_manifest.toml"
WHEELS = re.compile(r"^wheels = \[\n.*?^\]\n", re.MULTILINE | re.DOTALL)
PLATFORMS = re.compile(r"^platforms = \[.*?\]\n", re.MULTILINE | re.DOTALL)


def toml_list(name: str, items: list[str]) -> str:
    """A TOML array, one item a line."""
    return f"{name} = [\n" + "".join(f'  "{item}",\n' for item in items) + "]\n"


def manifest_wheels(platform: str) -> list[str]:
    """File names of the wheels in the manifest that belong to a platform."""
    listed = tomllib.loads(MANIFEST.read_text())["wheels"]
    tags = {"linux-x64": "linux", "windows-x64": "win_", "macos-arm64": "macosx"}
    return [Path(item).name for item in listed if tags[platform] in item.rpartition("-")[2]]


def pin() -> None:
    """Write the wheels that requirements.txt asks for, for all platforms and Pythons, into the manifest."""
    names: set[str] = set()
    for platform in wheel_files.PLATFORMS:
        for python in wheel_files.PYTHONS:
            names.update(wheel_files.file_names(platform, python))
    listed = toml_list("wheels", [f"./wheels/{name}" for name in sorted(names)])
    MANIFEST.write_text(WHEELS.sub(lambda _: listed, MANIFEST.read_text()))


def blender_scripts() -> Path:
    """Blender's scripts folder in the bpy wheel, found without loading bpy."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        sys.exit("the bpy wheel is not installed: run this through 'make package'")
    return next(Path(spec.origin).parent.glob("*/scripts"))


def blender_ext(*arguments: str) -> None:
    """Run Blender's extension tool, a plain script."""
    tool = blender_scripts() / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    done = subprocess.run([sys.executable, str(tool), *arguments], check=False)
    if done.returncode:
        sys.exit(f"blender_ext.py {arguments[0]} failed (see above)")


def stage(folder: Path, platform: str, paths: list[Path]) -> None:
    """Copy what belongs to the extension, and a manifest for one platform."""
    skipped = shutil.ignore_patterns("__pycache__", "tests", ".*")
    shutil.copytree(ROOT / "photon_engine", folder / "photon_engine", ignore=skipped)
    for name in ("__init__.py", "README.md", "LICENSE", "CHANGELOG.md"):
        shutil.copy(ROOT / name, folder)
    (folder / "wheels").mkdir()
    for path in paths:
        (folder / "wheels" / path.name).symlink_to(path)
    text = WHEELS.sub(lambda _: toml_list("wheels", [f"./wheels/{path.name}" for path in paths]), MANIFEST.read_text())
    (folder / MANIFEST.name).write_text(PLATFORMS.sub(lambda _: f'platforms = ["{platform}"]\n', text))


def build(platform: str, output: Path) -> Path:
    """Build and validate the zip of one platform; returns its path."""
    version = tomllib.loads(MANIFEST.read_text())["version"]
    target = output.resolve() / f"photon_engine-{version}-{platform.replace('-', '_')}.zip"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.unlink(missing_ok=True)
    paths = wheel_files.fetch(platform, manifest_wheels(platform))
    with tempfile.TemporaryDirectory() as folder:
        stage(Path(folder), platform, paths)
        blender_ext("build", "--source-dir", folder, "--output-filepath", str(target))
    tags = next(blender_scripts().glob("**/extensions/tags.py"), None)
    blender_ext("validate", str(target), *(("--valid-tags", str(tags)) if tags else ()))
    return target


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Build the extension's zip with its wheels.")
    parser.add_argument("--platform", choices=list(wheel_files.PLATFORMS), default="linux-x64")
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    parser.add_argument("--pin", action="store_true", help="first list the wheels of requirements.txt in the manifest")
    options = parser.parse_args()
    if options.pin:
        pin()
    path = build(options.platform, options.output)
    print(f"{path} ({path.stat().st_size / 1e6:.0f} MB)")


if __name__ == "__main__":
    main()
