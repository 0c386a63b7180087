"""scripts/setup.sh chooses an interpreter by running candidates, and says what to do when there is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SETUP = Path(__file__).resolve().parent.parent / "scripts" / "setup.sh"
VERSION = "{}.{}".format(*sys.version_info[:2])
NAME = f"python{VERSION}"

pytestmark = pytest.mark.skipif(os.name != "posix", reason="make and bash are for Linux and macOS")


def script(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def which(python: str = "", path: Path | None = None, pyenv: Path | None = None) -> subprocess.CompletedProcess:
    """Runs setup.sh --which with PYTHON, a folder in front of PATH, and a pyenv folder."""
    folders = f"{path}{os.pathsep}/usr/bin{os.pathsep}/bin"
    none = "/nonexistent"
    environment = {"PATH": folders, "HOME": none, "PYENV_ROOT": str(pyenv or none), "PYTHON": python}
    return subprocess.run(["bash", str(SETUP), "--which"], env=environment, capture_output=True, text=True, check=False)


def test_a_stand_in_that_fails_is_passed_over(tmp_path):
    shim = script(tmp_path / "shims" / NAME, "echo 'pyenv: command not found' >&2; exit 127")
    script(tmp_path / "pyenv" / "versions" / f"{VERSION}.99" / "bin" / NAME, f'exec "{sys.executable}" "$@"')
    for python in (NAME, ""):
        done = which(python, tmp_path / "shims", tmp_path / "pyenv")
        chosen = done.stdout.strip()  # the one in pyenv's folder, or one that the machine has
        assert chosen and chosen != str(shim), done.stderr
        said = subprocess.run([chosen, "--version"], capture_output=True, text=True, check=True).stdout
        assert said.startswith(f"Python {VERSION}." if python else ("Python 3.13.", "Python 3.11."))


def test_a_working_one_in_the_path_comes_first(tmp_path):
    real = script(tmp_path / "bin" / NAME, f'exec "{sys.executable}" "$@"')
    assert which(NAME, tmp_path / "bin").stdout.strip() in (NAME, str(real))


def test_a_path_without_venv_is_refused_with_the_remedy(tmp_path):
    lame = script(tmp_path / NAME, f'case "$2" in *venv*) exit 1;; esac\nexec "{sys.executable}" "$@"')
    done = which(str(lame))
    assert done.returncode == 1
    assert "venv module is missing" in done.stderr and f"apt-get install {NAME}-venv" in done.stderr


def test_other_versions_are_refused(tmp_path):
    old = str(script(tmp_path / "python3.9", "echo 3.9"))
    for python, message in ((old, "is Python 3.9"), ("python3.12", "not supported"), ("/no/python", "does not run")):
        done = which(python)
        assert done.returncode == 1 and message in done.stderr
