"""Expected block means of each class for the rooms of `cornell`.

``python -m tests.brute.references [-w N] [NAME ...]`` renders them, with 1/N of the samples.

Long runs of the reference tracer, kept as block means with their standard errors, so that a test of the engine takes
seconds. `tests/test_classes.py` also renders each room anew, with fewer samples, and compares with what is kept.
"""

import sys
import time
from pathlib import Path

import numpy as np

from .harness import reference
from .path_tracer import CLASSES
from .scenes import VARIANTS, cornell

PATH = Path(__file__).resolve().parents[1] / "references" / "classes.npz"
SIZE, BLOCK = 32, 8
SPP, PHOTONS, BATCHES = 6144, 3_200_000, 16


def make(variant, spp=SPP, photons=PHOTONS, batches=BATCHES, first_seed=1):
    """{"variant/class": (2, 4, 4, 3)}: mean and standard error of each block."""
    picture = reference(cornell(variant, SIZE), spp, photons, batches, first_seed)
    return {f"{variant}/{name}": np.array(picture.blocks(name, BLOCK), np.float32) for name in CLASSES}


def load():
    """All that is kept."""
    with np.load(PATH) as archive:
        return {name: archive[name].astype(float) for name in archive.files}


def main(names):
    """Render the rooms named, or all, with 1/N of the samples, and keep them."""
    kept = load() if PATH.exists() else {}
    parts = 1
    if names[:1] == ["-w"]:
        parts, names = int(names[1]), names[2:]
    for name in names or VARIANTS:
        start = time.perf_counter()
        kept |= make(name, SPP // parts, PHOTONS // parts)
        np.savez_compressed(PATH, **{key: np.asarray(value, np.float32) for key, value in kept.items()})
        print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
