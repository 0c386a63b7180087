"""One timed render, in a process of its own: by this engine, or by Cycles in Blender as a module."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..film.exr import read_exr
from ..issues import RenderError
from .reference import NAMES, read_reference

ROOT = Path(__file__).resolve().parents[2]
OURS, OURS_DENOISED = "Photon Map", "Photon Map, denoised"
CYCLES, CYCLES_DENOISED = "Cycles", "Cycles, denoised"


class Task(NamedTuple):
    """What all engines render."""

    blend: Path
    resolution: tuple[int, int]
    threads: int
    settings: tuple[str, ...]  # NAME=VALUE of ours
    seed: int = 0


class Run(NamedTuple):
    """What came of one render."""

    seconds: float  # of sampling, and of denoising; not of reading, building the tree, compiling and the pilot
    setup: float  # [s] of those
    detail: dict[str, Any]  # passes or samples
    pictures: dict[str, np.ndarray]  # Combined, and ours by light pass: (h, w, 3) f32, bottom row first
    cpu: float = float("nan")  # processor seconds of all threads within `seconds`: they tell more on a busy machine


def ours(task: Task, seconds: float, denoise: bool, place: Path) -> Run:
    """A render by this engine, stopped after the pass that goes beyond `seconds`.

    Denoised, it makes Combined alone, as Cycles does; raw, every light pass.
    """
    width, height = task.resolution
    command = [
        sys.executable, "-m", "photon_engine", "render", str(task.blend), "-o", str(place / "ours.exr"), "--no-sheet",
        "--resolution", f"{width}x{height}", "--seconds", str(seconds), "--threads", str(task.threads), "--quiet",
        "--log", str(place / "ours.json"), "--set", f"denoise={'FINAL' if denoise else 'OFF'}",
        "--set", f"seed={task.seed}", *(["--only", "Combined"] if denoise else []),
    ]  # fmt: skip
    for pair in task.settings:
        command += ["--set", pair]
    _call(command, task.blend)
    record = json.loads((place / "ours.json").read_text())
    pictures, _ = read_exr(place / "ours.exr")
    wanted = {name: pictures[name][..., :3] for name in NAMES if name in pictures}
    denoising = record["stage_seconds"].get("Denoising", 0.0)
    setup = sum(record["stage_seconds"].values()) - denoising - record["stage_seconds"].get("Writing", 0.0)
    detail = {"passes": record["passes"], "denoising": denoising}
    return Run(record["seconds"] + denoising, setup, detail, wanted, record["cpu_seconds"])


def cycles(task: Task, seconds: float, denoise: bool, place: Path) -> Run:
    """A render by Cycles with a time limit: path tracing, caustics on, no clamping; see blender/cycles.py."""
    job = {
        "blend": str(task.blend), "resolution": task.resolution, "threads": task.threads, "seconds": seconds,
        "denoise": denoise, "seed": task.seed, "output": str(place / "cycles.exr"), "log": str(place / "cycles.json"),
    }  # fmt: skip
    (place / "job.json").write_text(json.dumps(job))
    _call([sys.executable, "-m", "photon_engine.blender.cycles", str(place / "job.json")], task.blend)
    record = json.loads((place / "cycles.json").read_text())
    detail = {"settings": record["settings"], "version": record["version"]}
    pictures = {"Combined": read_reference(place / "cycles.exr")[0]["Combined"].mean}
    return Run(record["seconds"], record["setup"], detail, pictures, record["cpu_seconds"])


def _call(command: list[str], blend: Path) -> None:
    """Run a render to its end; a RenderError with what it said when it failed."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if done.returncode:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise RenderError(str(blend), f"a render failed: {said[-1] if said else done.returncode}", "render it alone")
