"""Reference pictures: mean and standard error of each pixel in one small EXR, with how it was made."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import OpenImageIO as oiio

from photon_engine.report import reference as files


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


def write_reference(path: str | Path, reference: Reference) -> None:
    """As photon_engine.report.reference writes them."""
    files.write_reference(path, {"Combined": files.Known(reference.mean, reference.se)}, reference.meta)


def read_reference(path: str | Path) -> Reference:
    """What `write_reference` wrote."""
    pictures, meta = files.read_reference(path)
    mean, se = pictures["Combined"]
    if se is None:
        raise OSError(f"{path}: has no standard error")
    return Reference(mean, se, meta)


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
