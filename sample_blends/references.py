"""Make the reference pictures of the samples: ``python sample_blends/references.py [NAME ...]``.

Cycles where it can find the light; where it cannot (a small or distant light behind glass or a mirror), a long run
of the brute-force path tracer in ``tests/``, which connects nothing and is patient: see `BRUTE_FORCE`.
"""

from __future__ import annotations

import logging
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from tests.oracle import cycles, images  # noqa: E402

FOLDER = HERE / "references"
SIZE = 128
BUDGET = {"width": SIZE, "height": SIZE, "target": 0.0015, "max_batches": 400}

# name of the reference -> what Cycles renders
CYCLES = {
    "cornell_caustics_soft": cycles.Job(  # the same box with a lamp of 0.5 m
        builder="sample_blends.builders.cornell_caustics:build", arguments={"light_size": 0.5}, spp=64, seconds=240,
        **BUDGET,
    ),
    "diffuse_room": cycles.Job(blend=str(HERE / "diffuse_room.blend"), spp=32, seconds=240, **BUDGET),
    "material_shelf": cycles.Job(blend=str(HERE / "material_shelf.blend"), spp=32, seconds=240, **BUDGET),
}

# name of the reference -> why Cycles cannot make it
BRUTE_FORCE = {
    "cornell_caustics": "a lamp of 0.1 m: a path meets it through the glass ball once in some 100 000 tries",
    "ring_cardioid": "a lamp of 2 cm, seen by a diffuse point in the ring only by chance",
    "pool": "the sun (half a degree) through refracting water: Cycles has no connection through a surface",
    "wine_glass": "a lamp of 3 cm through three interfaces",
}


def make(name: str) -> Path:
    """Render one reference by Cycles and write it."""
    reference = cycles.render(CYCLES[name])
    path = FOLDER / f"{name}.exr"
    reference.meta["sample"] = name
    images.write_reference(path, reference)
    images.write_png(cycles.CACHE / f"{name}.png", [reference.mean])
    return path


def main(names: list[str]) -> int:
    """Make the references named, or all that Cycles can make."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for name in names or CYCLES:
        if name in BRUTE_FORCE:
            logging.error("%s: not by Cycles (%s)", name, BRUTE_FORCE[name])
            return 2
        if name not in CYCLES:
            logging.error("unknown reference %s; there are: %s", name, ", ".join([*CYCLES, *BRUTE_FORCE]))
            return 2
        path = make(name)
        logging.info("%s: %s", path.name, images.read_reference(path).meta)
    return 0


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)
