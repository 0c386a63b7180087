"""The one kernel decorator, and where compiled kernels are kept.

Numba's cache misses a change in a callee that lives in another file, so the folder of each module's kernels is
named after a hash of that module's source and of every module of this package that it imports.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import time
from functools import cache
from pathlib import Path

import numba
from numba.core import event as numba_event

from .linkage import Kernel

# fastmath=True would let the compiler assume that no NaN exists, and bugs would go unseen
FASTMATH = {"nsz", "arcp", "contract", "afn", "reassoc"}
PACKAGE = Path(__file__).resolve().parent
# `from ..a.b import (c, d as e)` at the start of a line: dots, module, names
IMPORT = re.compile(r"^from (\.+)([\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)
NAME = re.compile(r"\b(?<!as )(\w+)")


class _Watch(numba_event.Listener):
    """Hears when numba compiles; functions that were in the cache make no event."""

    def __init__(self) -> None:
        self.running = 0
        self.done = 0
        self.seconds = 0.0

    def on_start(self, event: numba_event.Event) -> None:
        """A function's compilation begins."""
        if not self.running:
            self._begin = time.perf_counter()
        self.running += 1

    def on_end(self, event: numba_event.Event) -> None:
        """It ends."""
        self.running -= 1
        self.done += 1
        if not self.running:
            self.seconds += time.perf_counter() - self._begin


_watch = _Watch()
numba_event.register("numba:compile", _watch)


def is_compiling() -> bool:
    """Whether a kernel is being compiled just now, in any thread."""
    return _watch.running > 0


def compiled_functions() -> int:
    """How many functions this process has compiled so far."""
    return _watch.done


def compile_seconds() -> float:
    """Time that this process has spent with compiling kernels so far."""
    return _watch.seconds


def cache_root() -> Path:
    """Folder of compiled kernels: PHOTON_MAP_CACHE, or the user's cache folder."""
    if configured := os.environ.get("PHOTON_MAP_CACHE"):
        return Path(configured)
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "photon_map"


@cache
def _imports(path: Path) -> tuple[Path, ...]:
    """Modules of this package that the file imports at its top, by relative import.

    Found by their look: parsing the sources took a sixth of a warm start.
    """
    found = []
    for dots, module, names in IMPORT.findall(_source(path).decode()):
        folder = path.parents[len(dots) - 1]
        stem = folder.joinpath(*module.split(".")) if module else folder
        for candidate in (f"{stem}.py", *(f"{stem}{os.sep}{name}.py" for name in NAME.findall(names))):
            if candidate in _modules():
                found.append(Path(candidate))
    return tuple(found)


@cache
def _modules() -> frozenset[str]:
    """Paths of this package's modules."""
    return frozenset(str(path) for path in PACKAGE.rglob("*.py"))


@cache
def _source(path: Path) -> bytes:
    """A module's text."""
    return path.read_bytes()


@cache
def source_hash(path: Path) -> str:
    """Hash of a module's source and of all that it imports from this package."""
    seen: set[Path] = set()
    todo = [path]
    while todo:
        item = todo.pop()
        if item not in seen:
            seen.add(item)
            todo.extend(_imports(item))
    digest = hashlib.sha256(f"{numba.__version__} {sys.version_info}".encode())
    for item in sorted(seen):
        digest.update(_source(item))
    return digest.hexdigest()[:16]


def kernel(function):
    """Compile a scalar function or a loop over a batch: no GIL, cached, NaN kept, no allocation.

    Without allocation numba counts no references. Counting them costs more than the work of a small function that takes
    a table of arrays, and the counters bounce between the cores: two threads were slower than one.
    Never with ``parallel=True``: its work queue aborts the process when two Python threads enter.
    """
    return _compile(function, False)


def inlined(function):
    """As `kernel`, but always inlined: for a short cut in front of a call that passes dozens of words (about 40 ns)."""
    return _compile(function, True)


def _compile(function, inline: bool):
    """Compile into the module's own cache folder; inline: whether LLVM must put the code in place."""
    options = {
        "nopython": True,
        "nogil": True,
        "fastmath": FASTMATH,
        "error_model": "numpy",
        "_nrt": False,
        "forceinline": inline,
    }
    return Kernel(function, options, cache_folder)


def cache_folder(function) -> Path:
    """Where the machine code of a function is kept."""
    path = Path(function.__code__.co_filename)
    return cache_root() / f"{path.stem}_{source_hash(path)}"
