"""Long runs of the samples by component, to hold the claimed errors against: ``python sample_blends/components.py``.

Our own engine with gather radii of half a pixel to a pixel and three times the photons of the default, until its noise
is a few percent: the truth of a short run's noise and of what its radius smears. Whether the engine as a whole is
right is another question, put by the references of references.py.
"""

from __future__ import annotations

import json
import logging
import os
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import OpenImageIO as oiio

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from photon_engine.driver.session import Session  # noqa: E402
from photon_engine.film.accumulate import Film  # noqa: E402
from photon_engine.film.error import ERROR_NAMES, squared_noise  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
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
ATTRIBUTE = "photon_map:components"


class Components(NamedTuple):
    """A long run."""

    mean: dict[str, np.ndarray]  # by names of film.error.ERROR_NAMES, those that are not black: (h, w, 3) f32
    se: dict[str, np.ndarray]  # standard error, rms over channels: (h, w, 1) f32
    meta: dict


def write(path: Path, film: Film, meta: dict) -> None:
    """A half-float EXR with the channels NAME.R, NAME.G, NAME.B, NAME.se."""
    names = [name for name in ERROR_NAMES if film.mean(name).any()]
    layers = []
    for name in names:
        layers += [film.mean(name), np.sqrt(squared_noise(film, name).mean(axis=2, keepdims=True))]
    spec = oiio.ImageSpec(film.width, film.height, 4 * len(names), "half")
    spec.channelnames = tuple(f"{name}.{letter}" for name in names for letter in ("R", "G", "B", "se"))
    spec.attribute("compression", "zip")
    spec.attribute(ATTRIBUTE, json.dumps(meta))
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.ascontiguousarray(np.concatenate(layers, axis=2)[::-1], np.float32)
    out = oiio.ImageOutput.create(str(path))
    if not out or not out.open(str(path), spec) or not out.write_image(pixels):
        raise OSError(f"{path}: {oiio.geterror()}")
    out.close()


def read(name: str) -> Components:
    """The stored run of a sample."""
    source = oiio.ImageInput.open(str(FOLDER / f"{name}.exr"))
    if source is None:
        raise OSError(f"{name}: {oiio.geterror()}")
    channels = list(source.spec().channelnames)
    meta = json.loads(source.spec().getattribute(ATTRIBUTE))
    pixels = np.asarray(source.read_image(oiio.FLOAT), np.float32)[::-1]
    source.close()
    found = [item for item in ERROR_NAMES if f"{item}.se" in channels]
    mean = {item: pixels[..., [channels.index(f"{item}.{letter}") for letter in "RGB"]] for item in found}
    return Components(mean, {item: pixels[..., [channels.index(f"{item}.se")]] for item in found}, meta)


def open_sample(name: str):
    """SceneData of a sample at SIZE x SIZE; in a process that has Blender."""
    from photon_engine.blender.load import Options, load_blend

    return load_blend(HERE / f"{name}.blend", Options(None, None, None, (SIZE, SIZE)), IssueLog())[0]


def make(name: str) -> dict:
    """Render one and write it."""
    session = Session(open_sample(name), SETTINGS, IssueLog())
    session.render()
    meta = {"sample": name, "passes": session.film.count, "settings": SETTINGS.to_dict()}
    write(FOLDER / f"{name}.exr", session.film, meta)
    return meta


def main(names: list[str]) -> None:
    """Make those named, or all."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    for name in names or SAMPLES:
        logging.info("%s", make(name))


if __name__ == "__main__":
    main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(0)
