"""Reference pictures on disk: means and standard errors by name in a small EXR, and the choice among several files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import OpenImageIO as oiio

from ..film.passes import COMBINED, LIGHT_NAMES
from ..issues import RenderError

NAMES = (COMBINED.name, *LIGHT_NAMES)
ATTRIBUTE = "photon_map:reference"
SE = "se"  # in the names of channels that hold a standard error
SE_MANTISSA_BITS = 3  # a standard error from a dozen batches is known to 20% at best; fewer bits compress better


class Known(NamedTuple):
    """One picture of a reference."""

    mean: np.ndarray  # (h, w, 3) f32, linear Rec. 709 radiance, bottom row first
    se: np.ndarray | None = None  # standard error of the mean: (h, w, 3), or rms over channels (h, w, 1); None: unknown


class References(NamedTuple):
    """All pictures that a report is held against, of one size."""

    pictures: dict[str, Known]  # by names in NAMES, Combined among them
    sources: dict[str, str]  # picture -> the file that it is from, or how it was made

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        height, width, _ = self.pictures[COMBINED.name].mean.shape
        return width, height

    def told(self) -> str:
        """Which picture is from where, for people."""
        return "; ".join(
            f"{', '.join(name for name in self.sources if self.sources[name] == source)}: {short(source)}"
            for source in dict.fromkeys(self.sources.values())
        )


def short(source: str) -> str:
    """A file with its folder alone: references of one scene differ by these."""
    return "/".join(Path(source).parts[-2:]) if source.endswith(".exr") else source


def write_reference(path: str | Path, pictures: dict[str, Known], meta: dict[str, Any]) -> None:
    """Write a half-float EXR (ZIP) with `meta` as JSON; raises OSError.

    Channels R, G, B, se.R, se.G, se.B of Combined, so that any viewer shows it; NAME.R, ..., NAME.se.B of components. A
    standard error that is one for all channels is in se or NAME.se.
    """
    channels, layers = [], []
    for name, known in pictures.items():
        prefix = "" if name == COMBINED.name else f"{name}."
        channels += [prefix + letter for letter in "RGB"]
        layers.append(known.mean)
        if known.se is not None:
            one = known.se.shape[2] == 1
            channels += [f"{prefix}{SE}"] if one else [f"{prefix}{SE}.{letter}" for letter in "RGB"]
            layers.append(coarse(known.se))
    pixels = np.ascontiguousarray(np.concatenate(layers, axis=2)[::-1], np.float32)
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(channels), oiio.HALF)
    spec.channelnames = tuple(channels)
    spec.attribute("compression", "zip")
    spec.attribute(ATTRIBUTE, json.dumps(meta))
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    out = oiio.ImageOutput.create(str(path))
    if not out or not out.open(str(path), spec) or not out.write_image(pixels):
        raise OSError(f"{path}: {oiio.geterror()}")
    out.close()


def coarse(a: np.ndarray) -> np.ndarray:
    """`a` with its mantissa rounded to SE_MANTISSA_BITS bits."""
    mantissa, exponent = np.frexp(a)
    steps = 2.0 ** (SE_MANTISSA_BITS + 1)
    return np.ldexp(np.round(mantissa * steps) / steps, exponent).astype(np.float32)


def read_reference(path: str | Path) -> tuple[dict[str, Known], dict[str, Any]]:
    """Pictures and metadata of what `write_reference` wrote, or of a render: an RGB picture, or a multilayer EXR.

    Pictures are known by names of channels: R or LAYER.Combined.R, Caustic.R or LAYER.Caustic.R; of several layers the
    first counts. Raises a RenderError that names the file when it cannot be used.
    """
    path = Path(path)
    if not path.is_file():
        raise RenderError(str(path), "no such file", "check the path of --reference")
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise RenderError(str(path), "cannot be read as a picture", oiio.geterror() or "check the path")
    spec = source.spec()
    meta = json.loads(spec.getattribute(ATTRIBUTE) or "{}")
    pixels = np.asarray(source.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT), np.float32)[::-1]
    source.close()
    if spec.format.basetype in (oiio.UINT8, oiio.UINT16):
        raise RenderError(str(path), "holds colours as a screen shows them, not radiance", "give an EXR")
    found: dict[tuple[str, str], int] = {}
    for index, channel in enumerate(spec.channelnames):
        found.setdefault(_meaning(channel), index)
    pictures = {}
    for name in NAMES:
        mean = _take(pixels, found, name, "RGB")
        if mean is not None:
            pictures[name] = Known(mean, _standard_error(pixels, found, name))
    if not pictures:
        raise RenderError(str(path), f"holds none of {', '.join(NAMES)}", "give an RGB picture or a multilayer EXR")
    for name, known in pictures.items():
        if not all(np.isfinite(part).all() for part in known if part is not None):
            raise RenderError(str(path), f"has pixels in {name} that are no finite numbers", "make it again")
    return pictures, meta


def _meaning(channel: str) -> tuple[str, str]:
    """(picture, letter) of a channel's name; the letter is se, se.R, se.G, se.B for standard errors."""
    *rest, letter = channel.split(".")
    if letter != SE and rest[-1:] == [SE]:
        rest, letter = rest[:-1], f"{SE}.{letter}"
    return (rest[-1] if rest else COMBINED.name), letter


def _take(
    pixels: np.ndarray, found: dict[tuple[str, str], int], name: str, letters: Sequence[str]
) -> np.ndarray | None:
    """The channels `letters` of a picture, None where one is missing."""
    indices = [found.get((name, letter)) for letter in letters]
    return None if None in indices else np.ascontiguousarray(pixels[..., indices])


def _standard_error(pixels: np.ndarray, found: dict[tuple[str, str], int], name: str) -> np.ndarray | None:
    """By channel, or one for all, or None."""
    each = _take(pixels, found, name, [f"{SE}.{letter}" for letter in "RGB"])
    return _take(pixels, found, name, [SE]) if each is None else each


def choose(paths: Sequence[str | Path]) -> References:
    """Of each picture the first file that holds it.

    A RenderError where sizes differ, a file holds nothing that those before it do not, or none holds Combined.
    """
    pictures: dict[str, Known] = {}
    sources: dict[str, str] = {}
    first = (0, 0)
    for path in paths:
        here = read_reference(path)[0]
        height, width, _ = next(iter(here.values())).mean.shape
        if not pictures:
            first = (width, height)
        if (width, height) != first:
            said = "is {} x {}, {} is {} x {}".format(width, height, paths[0], *first)
            raise RenderError(str(path), said, "give references of one size")
        new = [name for name in here if name not in pictures]
        if not new:
            said = f"holds only {', '.join(here)}, as a --reference before it does"
            raise RenderError(str(path), said, "leave it out, or give it first")
        pictures |= {name: here[name] for name in new}
        sources |= dict.fromkeys(new, str(path))
    if COMBINED.name not in pictures:
        raise RenderError("--reference", "Combined is in none of the files", "give one that holds it too")
    return References({name: pictures[name] for name in NAMES if name in pictures}, sources)
