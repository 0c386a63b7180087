"""Cycles as an oracle: any scene, every shortcut off, in a process of its own.

Renders batches with different seeds until the noise target or the time is reached, so that a standard error of
each pixel comes along. ``python -m tests.oracle.cycles JOB.json OUT.npz`` is that process.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .compare import block_errors, block_means
from .images import Reference, read_picture

ROOT = Path(__file__).resolve().parents[2]
CACHE = ROOT / "out" / "oracle"  # ignored by git
SOURCES = ("tests/scenes", "sample_blends/builders")  # what a scene builder may depend on
MIN_BATCHES = 6  # fewer say little about their own spread


@dataclass(frozen=True)
class Job:
    """One picture wanted from Cycles: from a .blend file or from a builder ``module:function``."""

    blend: str = ""
    builder: str = ""
    arguments: dict[str, Any] = field(default_factory=dict)  # of the builder
    spp: int = 64  # samples a pixel in each batch
    max_batches: int = 64
    seconds: float = 60.0  # stop after the batch that passes this
    target: float = 0.001  # stop when the standard error of every block is below this part of its mean
    seed: int = 1
    threads: int = 2
    width: int = 0  # 0: as in the scene
    height: int = 0
    bounces: int = 64


def render(job: Job, cache: bool = True) -> Reference:
    """The picture by Cycles; kept under out/oracle by a hash of the job and of all that the scene is made from."""
    kept = CACHE / f"{job_hash(job)}.npz"
    if not (cache and kept.is_file()):
        CACHE.mkdir(parents=True, exist_ok=True)
        order, result = (kept.with_suffix(f".{os.getpid()}.{end}") for end in ("json", "npz"))
        order.write_text(json.dumps(asdict(job)))
        command = [sys.executable, "-m", "tests.oracle.cycles", str(order), str(result)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        order.unlink()
        if not result.is_file():
            raise RuntimeError(f"Cycles failed ({done.returncode}):\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}")
        os.replace(result, kept)
    with np.load(kept) as data:
        return Reference(data["mean"], data["se"], json.loads(str(data["meta"])))


def job_hash(job: Job) -> str:
    """Hash of the job and of the file or the sources of the builders."""
    digest = hashlib.sha256(json.dumps(asdict(job), sort_keys=True).encode())
    files = [Path(job.blend)] if job.blend else sorted(p for s in SOURCES for p in (ROOT / s).glob("*.py"))
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:24]


def neutralise(scene, job: Job) -> None:
    """Switch off all that makes Cycles fast and wrong: clamping, caustic tricks, light threshold, denoiser, limits."""
    scene.render.engine = "CYCLES"
    scene.render.use_compositing = False
    scene.render.use_sequencer = False
    scene.render.threads_mode = "FIXED"
    scene.render.threads = job.threads
    if job.width:
        scene.render.resolution_x, scene.render.resolution_y = job.width, job.height
        scene.render.resolution_percentage = 100
    values = {
        "device": "CPU", "samples": job.spp, "time_limit": 0.0, "sample_offset": 0,
        "use_adaptive_sampling": False, "use_denoising": False, "use_guiding": False, "use_fast_gi": False,
        "caustics_reflective": True, "caustics_refractive": True, "blur_glossy": 0.0,
        "sample_clamp_direct": 0.0, "sample_clamp_indirect": 0.0, "light_sampling_threshold": 0.0,
        "max_bounces": job.bounces, "diffuse_bounces": job.bounces, "glossy_bounces": job.bounces,
        "transmission_bounces": job.bounces, "transparent_max_bounces": job.bounces, "min_light_bounces": 0,
        # blue noise would make neighbouring pixels depend on each other, and block errors would come out wrong
        "sampling_pattern": "TABULATED_SOBOL", "use_sample_subset": False,
    }
    for name, value in values.items():
        if hasattr(scene.cycles, name):  # a few exist in one of the two Blender lines only
            setattr(scene.cycles, name, value)


def write_float_exr(settings, channels: str = "RGB") -> None:
    """Make image settings of either Blender line write an EXR of floats."""
    if hasattr(settings, "media_type"):  # from Blender 5 on
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", channels
    settings.exr_codec = "ZIP"


def render_batch(scene, seed: int, path: str) -> np.ndarray:
    """One render of the current scene through a float EXR: (h, w, 3), bottom row first."""
    import bpy

    scene.cycles.seed = seed
    scene.cycles.use_animated_seed = False
    write_float_exr(scene.render.image_settings, "RGBA")
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return read_picture(path)


def open_scene(job: Job):
    """The job's scene, current in bpy."""
    import bpy

    if job.blend:
        bpy.ops.wm.open_mainfile(filepath=job.blend)
    else:
        module, function = job.builder.split(":")
        getattr(importlib.import_module(module), function)(**job.arguments)
    return bpy.context.scene


def run(job: Job) -> Reference:
    """Render in this process until the job's target, time or batches are reached."""
    import bpy

    scene = open_scene(job)
    neutralise(scene, job)
    batches = []
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        while len(batches) < job.max_batches:
            batches.append(render_batch(scene, job.seed + len(batches), str(Path(folder, "batch.exr"))))
            if len(batches) < MIN_BATCHES:
                continue
            mean, se = summary(batches)
            noise = worst_noise(mean, se)
            if noise < job.target or time.monotonic() - started > job.seconds:
                break
    meta = {
        "renderer": f"Cycles, Blender {bpy.app.version_string}", "how": "unidirectional path tracing, no shortcuts",
        "spp": job.spp * len(batches), "batches": len(batches), "seconds": round(time.monotonic() - started, 1),
        "threads": job.threads, "bounces": job.bounces, "worst_block_error": round(noise, 5),
        "frame": scene.frame_current, "source": job.builder or Path(job.blend).name, "arguments": job.arguments,
    }
    return Reference(mean, se, meta)


def summary(batches: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and its standard error over batches of equal size."""
    stack = np.array(batches, np.float64)
    return stack.mean(axis=0).astype(np.float32), (stack.std(axis=0, ddof=1) / np.sqrt(len(stack))).astype(np.float32)


def worst_noise(mean: np.ndarray, se: np.ndarray) -> float:
    """Largest relative standard error over blocks that are not black."""
    means, errors = block_means(mean), block_errors(se)
    lit = means > 1e-3 * means.mean()
    return float((errors[lit] / means[lit]).max()) if lit.any() else 0.0


def main(arguments: list[str]) -> None:
    """The subprocess: job file in, npz out."""
    order, result = arguments
    reference = run(Job(**json.loads(Path(order).read_text())))
    np.savez(result, mean=reference.mean, se=reference.se, meta=json.dumps(reference.meta))
    sys.stdout.flush()
    os._exit(0)  # bpy 4.5 hangs in an ordinary exit


if __name__ == "__main__":
    main(sys.argv[1:])
