"""One timed render by Cycles, for the report: ``python -m photon_engine.blender.cycles JOB.json``."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import bpy

# Cycles as a path tracer that takes no short cut; the rest is as the file says
SETTINGS = {
    "device": "CPU", "samples": 1 << 20, "use_adaptive_sampling": False, "use_guiding": False, "use_fast_gi": False,
    "caustics_reflective": True, "caustics_refractive": True, "blur_glossy": 0.0, "sample_clamp_direct": 0.0,
    "sample_clamp_indirect": 0.0, "light_sampling_threshold": 0.0, "max_bounces": 64, "diffuse_bounces": 64,
    "glossy_bounces": 64, "transmission_bounces": 64, "transparent_max_bounces": 64,
}  # fmt: skip


def prepare(scene: bpy.types.Scene, job: dict[str, Any]) -> None:
    """Set size, threads, denoiser and output."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = job["resolution"]
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.use_persistent_data = True
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.cycles.seed = job["seed"]
    for name, value in SETTINGS.items():
        setattr(scene.cycles, name, value)
    scene.cycles.use_denoising = job["denoise"]
    if job["denoise"]:
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
    output = scene.render.image_settings
    if hasattr(output, "media_type"):  # Blender 5
        output.media_type = "IMAGE"
    output.file_format, output.color_mode, output.color_depth = "OPEN_EXR", "RGB", "32"


def timed(scene: bpy.types.Scene, samples: int, seconds: float, path: str) -> tuple[float, float]:
    """Seconds that a render took, and processor seconds of all threads."""
    scene.cycles.samples, scene.cycles.time_limit = samples, seconds
    scene.render.filepath = path
    begin, busy = time.perf_counter(), time.process_time()
    bpy.ops.render.render(write_still=True)
    return time.perf_counter() - begin, time.process_time() - busy


def main(path: str) -> None:
    """Render the job: once with one sample to build and load, once more to see what is spent besides, then for time."""
    job = json.loads(Path(path).read_text())
    bpy.ops.wm.open_mainfile(filepath=job["blend"], load_ui=False)
    scene = bpy.context.scene
    prepare(scene, {**job, "denoise": False})
    first, _ = timed(scene, 1, 0.0, job["output"])
    overhead, busy = timed(scene, 1, 0.0, job["output"])
    prepare(scene, job)
    seconds, cpu = timed(scene, SETTINGS["samples"], job["seconds"], job["output"])
    shown = {**SETTINGS, "denoise": job["denoise"], "threads": job["threads"], "time_limit": job["seconds"]}
    record = {
        "seconds": max(seconds - overhead, 0.0), "cpu_seconds": max(cpu - busy, 0.0), "setup": first,
        "settings": shown, "version": bpy.app.version_string,
    }  # fmt: skip
    Path(job["log"]).write_text(json.dumps(record))


if __name__ == "__main__":
    main(sys.argv[1])
    sys.stdout.flush()
    os._exit(0)  # bpy 4.5 hangs in an ordinary exit
