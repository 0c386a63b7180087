"""Long runs of the samples by component, to hold the claimed errors against: ``python sample_blends/components.py``.

Our own engine with gather radii of half a pixel to a pixel and three times the photons of the default, until its noise
is a few percent: the truth of a short run's noise and of what its radius smears. Whether the engine as a whole is
right is another question, put by the references of references.py.

Those of 64 x 64 are for the tests; those of 128 x 128, NAME_128.exr, for ``report`` beside the references of that
size: ``python sample_blends/components.py --size 128 --seconds 300 NAME ...``.
"""

from __future__ import annotations

import argparse
import logging
import os
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from photon_engine.driver.session import Session  # noqa: E402
from photon_engine.film.accumulate import Film  # noqa: E402
from photon_engine.film.error import ERROR_NAMES, squared_noise  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.report.reference import Known, read_reference, write_reference  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402

FOLDER = HERE / "references" / "components"
SIZE = 64
SAMPLES = ("cornell_caustics", "diffuse_room", "material_shelf", "pool", "ring_cardioid", "wine_glass")
SECONDS = 270.0
# another seed than any test's; radii in half pixels: on a pixel's mean, half a pixel smears next to nothing
SETTINGS = Settings(
    passes=0, seconds=SECONDS, seed=1000, caustic_photons=300_000, diffuse_photons=300_000, light_samples=8,
    caustic_radius=1.0, diffuse_radius=1.5,
)  # fmt: skip


class Components(NamedTuple):
    """A long run."""

    mean: dict[str, np.ndarray]  # by names of film.error.ERROR_NAMES, those that are not black: (h, w, 3) f32
    se: dict[str, np.ndarray]  # standard error, rms over channels: (h, w, 1) f32
    meta: dict


def path_of(name: str, size: int = SIZE) -> Path:
    """Where the run of a sample is kept."""
    return FOLDER / (f"{name}.exr" if size == SIZE else f"{name}_{size}.exr")


def write(path: Path, film: Film, meta: dict) -> None:
    """All pictures that are not black, with their standard errors, rms over channels."""
    names = [name for name in ERROR_NAMES if film.mean(name).any()]
    se = {name: np.sqrt(squared_noise(film, name).mean(axis=2, keepdims=True)) for name in names}
    write_reference(path, {name: Known(film.mean(name), se[name]) for name in names}, meta)


def read(name: str) -> Components:
    """The stored run of a sample."""
    pictures, meta = read_reference(path_of(name))
    mean = {item: known.mean for item, known in pictures.items()}
    return Components(mean, {item: known.se for item, known in pictures.items() if known.se is not None}, meta)


def open_sample(name: str, size: int = SIZE):
    """SceneData of a sample at size x size; in a process that has Blender."""
    from photon_engine.blender.load import Options, load_blend

    return load_blend(HERE / f"{name}.blend", Options(None, None, None, (size, size)), IssueLog())[0]


def make(name: str, size: int, seconds: float) -> dict:
    """Render one and write it."""
    settings = SETTINGS.replace(seconds=seconds)
    session = Session(open_sample(name, size), settings, IssueLog())
    session.render()
    meta = {"sample": name, "passes": session.film.count, "settings": settings.to_dict()}
    write(path_of(name, size), session.film, meta)
    return meta


def main() -> None:
    """Make those named, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"default: {' '.join(SAMPLES)}")
    parser.add_argument("--size", type=int, default=SIZE, metavar="PX")
    parser.add_argument("--seconds", type=float, default=SECONDS, metavar="S")
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for name in given.names or SAMPLES:
        logging.info("%s", make(name, given.size, given.seconds))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)
