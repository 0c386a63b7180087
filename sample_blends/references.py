"""Make the reference pictures of the samples: ``python sample_blends/references.py [NAME ...]``.

Cycles where it can find the light; where it cannot (a small light behind glass or off a mirror), a long run of the
brute-force tracer in ``tests/brute``. Samples of that kind also have a soft variant, the same scene with a light so
large that Cycles converges.
"""

from __future__ import annotations

import logging
import os
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from tests.oracle import cycles, images  # noqa: E402

FOLDER = HERE / "references"
SIZE = 128
BATCHES = 16  # of the reference tracer, for error bars
BUDGET = {"width": SIZE, "height": SIZE, "target": 0.0015, "max_batches": 400}



def soft(name: str, spp: int = 64, **arguments) -> cycles.Job:
    """A sample with a light so large that Cycles converges."""
    return cycles.Job(
        builder=f"sample_blends.builders.{name}:build", arguments=arguments, spp=spp, seconds=240, **BUDGET
    )


# name of the reference -> what Cycles renders
CYCLES = {
    "cornell_caustics_soft": soft("cornell_caustics", light_size=0.5),
    "ring_cardioid_soft": soft("ring_cardioid", lamp_radius=0.2),
    "pool_soft": soft("pool", spp=32, sun_angle=0.25),
    "wine_glass_soft": soft("wine_glass", lamp_size=0.3),
    "diffuse_room": cycles.Job(blend=str(HERE / "diffuse_room.blend"), spp=32, seconds=240, **BUDGET),
    "material_shelf": cycles.Job(blend=str(HERE / "material_shelf.blend"), spp=32, seconds=240, **BUDGET),
}

# name of the reference -> (samples a pixel, photons) of the reference tracer, for what Cycles cannot find
BRUTE_FORCE = {
    "cornell_caustics": (512, 16_000_000),  # a lamp of 0.1 m
    "ring_cardioid": (512, 16_000_000),  # a lamp of 4 cm
    "wine_glass": (512, 16_000_000),  # a lamp of 3 cm behind three interfaces
}

# name of the sample -> why it has no reference with its own light; its soft variant stands in
NONE = {
    "pool": "every caustic is seen through the water: neither a path from the eye (it meets a sun of half a degree "
    "once in 50 000 tries) nor one from the sun (it cannot be joined to the eye) finds it",
}


def path_of(name: str) -> Path:
    """Where a reference is kept."""
    return FOLDER / f"{name}.exr"


def existing() -> list[str]:
    """Names of the references that are there."""
    return [name for name in (*CYCLES, *BRUTE_FORCE) if path_of(name).is_file()]


def make(name: str) -> Path:
    """Render one reference and write it."""
    reference = cycles.render(CYCLES[name]) if name in CYCLES else by_brute_force(name)
    path = path_of(name)
    reference.meta["sample"] = name
    images.write_reference(path, reference)
    images.write_png(cycles.CACHE / f"{name}.png", [reference.mean])
    return path


def by_brute_force(name: str) -> images.Reference:
    """The sample's own .blend by the tracer of tests/brute: paths from the eye, and from the lights to the eye."""
    import bpy

    from photon_engine.blender.extract import extract_scene
    from photon_engine.issues import IssueLog
    from tests.brute.harness import reference

    bpy.ops.wm.open_mainfile(filepath=str(HERE / f"{name}.blend"))
    render = bpy.context.scene.render
    render.resolution_x = render.resolution_y = SIZE
    scene = extract_scene(bpy.context.evaluated_depsgraph_get(), IssueLog())
    spp, photons = BRUTE_FORCE[name]
    begin = time.monotonic()
    batches = reference(scene, spp, photons, BATCHES)
    pictures = [sum(batches[part][k] for part in batches) for k in range(BATCHES)]
    mean, se = cycles.summary(pictures)
    meta = {
        "renderer": "tests/brute", "how": "paths from the eye; caustics and diffuse light from paths of the lights",
        "spp": spp, "photons": photons, "batches": BATCHES, "seconds": round(time.monotonic() - begin, 1),
        "worst_block_error": round(cycles.worst_noise(mean, se), 5), "source": f"{name}.blend",
    }
    return images.Reference(mean, se, meta)


def main(names: list[str]) -> int:
    """Make the references named, or those that are missing."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    known = (*CYCLES, *BRUTE_FORCE)
    for name in names or [name for name in known if name not in existing()]:
        if name not in known:
            logging.error("no reference %s (%s); there are: %s", name, NONE.get(name, "unknown"), ", ".join(known))
            return 2
        path = make(name)
        logging.info("%s: %s", path.name, images.read_reference(path).meta)
    return 0


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)
