"""Reference pictures: mean and standard error of each pixel in one small EXR, with how it was made."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import OpenImageIO as oiio

ATTRIBUTE = "photon_map:reference"
CHANNELS = ("R", "G", "B", "se.R", "se.G", "se.B")
SE_MANTISSA_BITS = 3  # a standard error from a dozen batches is known to 20% at best; fewer bits compress better


class Reference(NamedTuple):
    """A converged picture."""

    mean: np.ndarray  # (h, w, 3) f32, linear Rec. 709 radiance, bottom row first
    se: np.ndarray  # (h, w, 3) f32, standard error of the mean, independent from pixel to pixel
    meta: dict[str, Any]  # renderer, spp, batches, seconds, ...


def read_picture(path: str | Path) -> np.ndarray:
    """The first three channels of an image file as (h, w, 3) f32, bottom row first."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    pixels = source.read_image(0, 0, 0, 3, oiio.FLOAT)
    source.close()
    return np.ascontiguousarray(np.asarray(pixels)[::-1], dtype=np.float32)


def coarse(a: np.ndarray) -> np.ndarray:
    """`a` with its mantissa rounded to SE_MANTISSA_BITS bits."""
    mantissa, exponent = np.frexp(a)
    steps = 2.0 ** (SE_MANTISSA_BITS + 1)
    return np.ldexp(np.round(mantissa * steps) / steps, exponent).astype(np.float32)


def write_reference(path: str | Path, reference: Reference) -> None:
    """Write a half-float EXR (ZIP) with channels R, G, B, se.R, se.G, se.B and the metadata as JSON."""
    h, w, _ = reference.mean.shape
    spec = oiio.ImageSpec(w, h, len(CHANNELS), oiio.HALF)
    spec.channelnames = CHANNELS
    spec.attribute("compression", "zip")
    spec.attribute(ATTRIBUTE, json.dumps(reference.meta))
    pixels = np.concatenate([reference.mean, coarse(reference.se)], axis=2)[::-1]
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    out = oiio.ImageOutput.create(str(path))
    if not out or not out.open(str(path), spec) or not out.write_image(np.ascontiguousarray(pixels, np.float32)):
        raise OSError(f"{path}: {oiio.geterror()}")
    out.close()


def read_reference(path: str | Path) -> Reference:
    """What `write_reference` wrote."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    names = list(source.spec().channelnames)
    pixels = np.asarray(source.read_image(oiio.FLOAT), np.float32)[::-1]
    meta = json.loads(source.spec().getattribute(ATTRIBUTE) or "{}")
    source.close()
    order = [names.index(name) for name in CHANNELS]  # EXR files keep channels in alphabetic order
    pixels = np.ascontiguousarray(pixels[:, :, order])
    return Reference(pixels[:, :, :3], pixels[:, :, 3:], meta)


def write_png(path: str | Path, pictures: list[np.ndarray], zoom: int = 2) -> None:
    """Linear pictures (h, w, 3), bottom row first, side by side as an sRGB PNG."""
    sheet = np.concatenate(pictures, axis=1)[::-1]
    sheet = np.clip(np.nan_to_num(sheet, nan=1.0), 0.0, 1.0)
    srgb = np.where(sheet <= 0.0031308, 12.92 * sheet, 1.055 * sheet ** (1 / 2.4) - 0.055)
    srgb = srgb.repeat(zoom, axis=0).repeat(zoom, axis=1).astype(np.float32)
    h, w, _ = srgb.shape
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    out = oiio.ImageOutput.create(str(path))
    if not out or not out.open(str(path), oiio.ImageSpec(w, h, 3, oiio.UINT8)) or not out.write_image(srgb):
        raise OSError(f"{path}: {oiio.geterror()}")
    out.close()
