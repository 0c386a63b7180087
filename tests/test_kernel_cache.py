"""Compiled kernels between runs: several processes at once, damaged files, folders that cannot be written."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from photon_engine import kernel_cache
from photon_engine.jit import kernel
from photon_engine.kernel_cache import KernelCache, read, write

from .blender_process import ROOT, environment

# each process compiles one function for all types, each in its own order, all at once
RACER = """
import os, pathlib, random, sys, time
import numpy as np
from photon_engine import kernel_cache
replace = os.replace
def slowly(*paths):  # gives the others time to come between
    time.sleep(0.1 * random.random())
    replace(*paths)
kernel_cache.os.replace = slowly
sys.path.insert(0, sys.argv[4])
from racing import total
kinds = ["f4", "f8", "i4", "i8", "u1"]
turn = int(sys.argv[1])
here = pathlib.Path(sys.argv[4])
(here / f"ready{turn}").touch()
while not all((here / f"ready{i}").exists() for i in range(int(sys.argv[3]))):
    time.sleep(0.001)
for kind in kinds[turn:] + kinds[:turn]:
    values = (np.arange(1000) % 100).astype(kind)
    found = total(values)
    assert found == 49500.0, (kind, found)
print("loaded" if not total.entry.stats.cache_misses else "compiled")
"""
MODULE = """
from photon_engine.jit import kernel
@kernel
def total(values):
    out = 0.0
    for i in range(len(values)):
        out += float(values[i])
    return out
"""


@pytest.mark.parametrize("count", [3])
def test_processes_that_compile_at_once_do_not_mix_up_each_others_code(tmp_path, count):
    """Numba's own numbered files do, when one process writes between another's index and its code."""
    (tmp_path / "racing.py").write_text(MODULE)
    (tmp_path / "racer.py").write_text(RACER)
    env = environment(PHOTON_MAP_CACHE=str(tmp_path / "cache"), PYTHONPATH=str(ROOT))

    def start(turn: int, together: int) -> subprocess.Popen:
        command = [sys.executable, str(tmp_path / "racer.py"), str(turn), "0", str(together), str(tmp_path)]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)

    racers = [start(turn, count) for turn in range(count)]
    for racer in racers:
        out, err = racer.communicate(timeout=120)
        assert racer.returncode == 0, err
    out, err = start(0, 1).communicate(timeout=120)
    assert out.strip() == "loaded", f"what three processes compiled serves a fourth: {out} {err}"
    assert not list(tmp_path.rglob("*.tmp"))


@kernel
def doubled(x):
    return 2.0 * x


def test_a_damaged_file_is_as_none(tmp_path):
    path = tmp_path / "a.nbc"
    write(path, b"key", [1, 2, 3])
    whole = path.read_bytes()
    assert read(path, b"key") == [1, 2, 3] and read(path, b"other") is None and read(tmp_path / "b.nbc", b"key") is None
    for broken in (b"", whole[:10], whole[:-1], whole[:40] + bytes([whole[40] ^ 1]) + whole[41:], whole + b"x"):
        path.write_bytes(broken)
        assert read(path, b"key") is None
    assert [p.name for p in tmp_path.iterdir()] == ["a.nbc"], "nothing is left beside it"


def test_where_nothing_can_be_written_kernels_work_and_it_is_noted(tmp_path, monkeypatch):
    monkeypatch.setattr(KernelCache, "failed", None)
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(doubled.entry, "_cache", KernelCache(doubled.py_func, tmp_path / "file" / "folder"))
    assert doubled(np.float32(1.5)) == 3.0
    assert isinstance(KernelCache.failed, OSError)


def test_types_modules_and_code_are_told_apart(tmp_path):
    cache = KernelCache(doubled.py_func, tmp_path)
    codegen = doubled.entry.targetctx.codegen()
    doubled(1.0)
    (one,) = {sig for sig in doubled.entry.overloads if sig[0].name == "float64"}
    keys = {cache.key(one, codegen), cache.key((one[0], one[0]), codegen)}

    def doubled_otherwise(x):
        return x + x

    doubled_otherwise.__code__ = doubled_otherwise.__code__.replace(co_name="doubled")
    keys.add(KernelCache(doubled_otherwise, tmp_path).key(one, codegen))
    assert len(keys) == len({cache.path(key) for key in keys}) == 3
    assert kernel_cache.DIGEST == 32
