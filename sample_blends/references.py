"""Make the reference pictures of the samples: ``python sample_blends/references.py [NAME ...]``.

Cycles where it can find the light; where it cannot (a small light behind glass or off a mirror), beams from the lamps
through every piece of glass and off every mirror, laid down in maps for paths from the eye (tests/oracle/beams.py).
Samples of that kind also have a soft variant, the same scene with a light so large that Cycles converges.
"""

from __future__ import annotations

import logging
import os
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from tests.oracle import cycles, images  # noqa: E402

FOLDER = HERE / "references"
SIZE = 128
BATCHES = 10  # of beams, for error bars
BUDGET = {"width": SIZE, "height": SIZE, "target": 0.0015, "max_batches": 400}
# All pixels of a Cycles render take samples from the same 256 tables, each of as many points as there are samples: what
# few of those hit, as the sun through water, is as wrong as the tables, in all batches. A grey pool without waves,
# against the formula: 1.037 +- 0.005 by batches of 256 samples, 0.995 +- 0.003 by batches of 4096. pool_soft by batches
# of 32 was 1.2% brighter than by 4096, which is 1.0002 of what beams give.
MANY = 4096


def soft(name: str, spp: int = MANY, seconds: float = 600, **arguments) -> cycles.Job:
    """A sample with a light so large that Cycles converges."""
    return cycles.Job(
        builder=f"sample_blends.builders.{name}:build", arguments=arguments, spp=spp, seconds=seconds, **BUDGET
    )


# name of the reference -> what Cycles renders
CYCLES = {
    "cornell_caustics_soft": soft("cornell_caustics", light_size=0.5),
    "ring_cardioid_soft": soft("ring_cardioid", lamp_radius=0.2),
    "pool_soft": soft("pool", seconds=1800, sun_angle=0.25),
    "wine_glass_soft": soft("wine_glass", lamp_size=0.3),
    "diffuse_room": cycles.Job(blend=str(HERE / "diffuse_room.blend"), spp=32, seconds=240, **BUDGET),
    "material_shelf": cycles.Job(blend=str(HERE / "material_shelf.blend"), spp=32, seconds=240, **BUDGET),
}

# name of the reference -> eye paths a pixel (with a rough vertex; without), beams and cells [m], in each batch
BEAMS = {
    "cornell_caustics": ((32, 512), 800_000, 0.01),  # a lamp of 0.1 m
    "pool": ((32, 64), 800_000, 0.01),  # the sun, and every caustic seen through the water
    "ring_cardioid": ((32, 64), 800_000, 0.005),  # a lamp of 4 cm
    "wine_glass": ((32, 1024), 800_000, 0.003),  # a lamp of 3 cm behind three interfaces, in many tiny images
}


def path_of(name: str) -> Path:
    """Where a reference is kept."""
    return FOLDER / f"{name}.exr"


def existing() -> list[str]:
    """Names of the references that are there."""
    return [name for name in (*CYCLES, *BEAMS) if path_of(name).is_file()]


def make(name: str) -> Path:
    """Render one reference and write it."""
    reference = cycles.render(CYCLES[name]) if name in CYCLES else by_beams(name)
    path = path_of(name)
    reference.meta["sample"] = name
    images.write_reference(path, reference)
    images.write_png(cycles.CACHE / f"{name}.png", [reference.mean])
    return path


def by_beams(name: str) -> images.Reference:
    """The sample's own .blend by tests/oracle/beams.py; batches are kept, so that a run that was stopped goes on."""
    import bpy

    from photon_engine.blender.extract import extract_scene
    from photon_engine.issues import IssueLog
    from tests.oracle import beams

    bpy.ops.wm.open_mainfile(filepath=str(HERE / f"{name}.blend"))
    render = bpy.context.scene.render
    render.resolution_x = render.resolution_y = SIZE
    scene = extract_scene(bpy.context.evaluated_depsgraph_get(), IssueLog())
    spp, count, cell = BEAMS[name]
    compiled = beams.compile_scene(scene)
    cycles.CACHE.mkdir(parents=True, exist_ok=True)
    pictures = []
    for k in range(BATCHES):
        kept = cycles.CACHE / f"beams_{name}_{k}.npy"
        if not kept.is_file():
            np.save(kept, beams.render(scene, spp, count, cell, seed=k + 1, compiled=compiled))
        pictures.append(np.load(kept))
    mean, se = cycles.summary(pictures)
    meta = {
        "renderer": "tests/oracle/beams", "how": "paths from the eye; caustics in maps of beams from the lamps",
        "spp": BATCHES * spp[0], "spp_without_rough_vertex": BATCHES * spp[1], "beams": BATCHES * count, "cell": cell,
        "batches": BATCHES, "worst_block_error": round(cycles.worst_noise(mean, se), 5), "source": f"{name}.blend",
    }
    return images.Reference(mean, se, meta)


def main(names: list[str]) -> int:
    """Make the references named, or those that are missing."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    known = (*CYCLES, *BEAMS)
    for name in names or [name for name in known if name not in existing()]:
        if name not in known:
            logging.error("no reference %s; there are: %s", name, ", ".join(known))
            return 2
        path = make(name)
        logging.info("%s: %s", path.name, images.read_reference(path).meta)
    return 0


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)
