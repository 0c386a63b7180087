"""The stored references of the small test scenes and of the scenes beside the project.

``python -m tests.oracle.references [NAME ...]`` renders those that are missing or named, one after the other.
"""

from __future__ import annotations

import logging
import os
import sys
from pathlib import Path

from . import cycles, images, shared

FOLDER = cycles.ROOT / "tests" / "references"

# scenes with light through glass or off mirrors converge slowly: seconds by scene, all others SECONDS
SECONDS = 10.0
SLOW = {
    name: 30.0
    for name in (
        "mirror", "glass_clear", "glass_tinted", "glass_rough", "glass_multiscatter", "refraction", "refraction_rough",
        "principled_transmission", "principled_frosted", "principled_half_transmission", "mirrored_glass", "many",
        "absorbing_glass", "subsurface", "subsurface_large", "subsurface_skin", "subsurface_textured",
    )
}  # fmt: skip
# Blender 4 has another random walk below surfaces, and shades a mesh without material matt grey, Blender 5 as a default
# Principled; old files look otherwise in it
BY_VERSION = {"subsurface", "no_material", "clevr_objects", "blenderdiplom_glass"}
SHARED_JOBS = {
    name: cycles.Job(
        builder="tests.oracle.shared:build", arguments={"name": name}, spp=64, seconds=120, target=0.0015,
        max_batches=400,
    )
    for name in shared.SIZES
}


def scene_job(name: str) -> cycles.Job:
    """How Cycles renders one of tests/scenes."""
    return cycles.Job(
        builder="tests.scenes:build", arguments={"name": name}, spp=64, seconds=SLOW.get(name, SECONDS), target=0.0015,
        max_batches=200,
    )


def path_of(name: str) -> Path:
    """Where the reference for this Blender is kept."""
    import bpy

    older = name in BY_VERSION and bpy.app.version[0] < 5
    return FOLDER / f"{name}{'_blender4' if older else ''}.exr"


def make(name: str) -> dict:
    """Render one reference, store it and return what is known of it."""
    job = SHARED_JOBS.get(name) or scene_job(name)
    reference = cycles.render(job, cache=False)
    images.write_reference(path_of(name), reference)
    return reference.meta


def main(names: list[str]) -> None:
    """Render the references named, or all that are missing."""
    from tests.scenes import all_scenes

    logging.basicConfig(level=logging.INFO, format="%(message)s")
    wanted = names or [n for n in (*all_scenes(), *SHARED_JOBS) if not path_of(n).is_file()]
    for name in wanted:
        meta = make(name)
        noise = 100 * meta["worst_block_error"]
        logging.info("%s: %d spp, %.1f s, worst block +- %.2f%%", name, meta["spp"], meta["seconds"], noise)
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(sys.argv[1:])
