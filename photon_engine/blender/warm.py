"""Compiles kernels in a process of low priority once the extension is enabled, so that the first render need not."""

from __future__ import annotations

import contextlib
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import bpy

DELAY = 3.0  # [s] after enabling: Blender's own start comes first
PACKAGE = Path(__file__).resolve().parent.parent

# The cache refers to types by their modules' names, and an installed extension is bl_ext.REPOSITORY.NAME.photon_engine:
# empty packages stand in for Blender's above ours, so that the names are the same in a bare Python.
CHILD = """
import importlib, os, pathlib, sys, types
package, folder, mark = sys.argv[1:]
if hasattr(os, "nice"):
    os.nice(19)
names, place = package.split("."), pathlib.Path(folder)
for count in range(len(names) - 1, 0, -1):
    place = place.parent
    module = sys.modules[".".join(names[:count])] = types.ModuleType(".".join(names[:count]))
    module.__path__ = [str(place)]
if len(names) == 1:
    sys.path.insert(0, str(place.parent))
importlib.import_module(package + ".transport.warm").warm_up()
pathlib.Path(mark).touch()
"""

_child: subprocess.Popen | None = None


def cache_folder() -> Path:
    """Where kernels are kept: as jit.cache_root, which cannot be asked without loading numba."""
    if configured := os.environ.get("PHOTON_MAP_CACHE"):
        return Path(configured)
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "photon_map"


def mark(folder: Path) -> Path:
    """The file that says that the kernels of the sources in a folder are compiled."""
    state = [f"{path.relative_to(folder)} {path.stat().st_mtime_ns}" for path in sorted(folder.rglob("*.py"))]
    digest = hashlib.sha256("\n".join([sys.version, str(folder), *state]).encode()).hexdigest()[:16]
    return cache_folder() / f"warm_{digest}"


def start(package: str, folder: Path) -> subprocess.Popen | None:
    """Begin compiling, unless that is done or there is no Python to do it; the process, or None.

    package, folder : the full name and the place of photon_engine, which holds transport/warm.py
    """
    python = Path(sys.executable)
    done = mark(folder)
    if done.exists() or "python" not in python.name.lower() or not python.is_file():
        return None
    with contextlib.suppress(OSError):
        done.parent.mkdir(parents=True, exist_ok=True)
        flags = getattr(subprocess, "IDLE_PRIORITY_CLASS", 0) | getattr(subprocess, "CREATE_NO_WINDOW", 0)
        quiet = subprocess.DEVNULL
        command = [str(python), "-c", CHILD, package, str(folder), str(done)]
        path = os.pathsep.join(item for item in sys.path if item)  # the wheels' folder is on it
        environment = {**os.environ, "PYTHONPATH": path}
        return subprocess.Popen(command, env=environment, creationflags=flags, stdin=quiet, stdout=quiet, stderr=quiet)
    return None


def _on_timer() -> None:
    """Start once; no further call."""
    global _child
    _child = start(__package__.rpartition(".")[0], PACKAGE)


def register() -> None:
    """Compile soon, when Blender has a window: a render without one compiles what it needs itself."""
    if not bpy.app.background:
        bpy.app.timers.register(_on_timer, first_interval=DELAY)


def unregister() -> None:
    """Stop it."""
    global _child
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
    if _child is not None and _child.poll() is None:
        _child.terminate()
    _child = None
