"""Pictures on disk: a multilayer EXR that Blender opens as one, and a PNG sheet to look at."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from ..issues import RenderError
from .output import OutputError, check_writable
from .passes import PASSES

SHEET = ("Combined", "Direct", "Caustic", "Diffuse")
LABEL_HEIGHT = 16  # [px]; a sheet of smaller pictures than four labels has none


def write_exr(path: str | Path, pictures: dict[str, np.ndarray], layer: str, metadata: dict | None = None) -> None:
    """One part, 32-bit, ZIP, channels named `layer.pass.channel` as Blender's multilayer EXR.

    pictures : name in passes.PASSES -> (h, w, c) f32, bottom row first;  metadata : name -> anything that JSON can hold
    """
    present = [item for item in PASSES if item.name in pictures]
    pixels = np.concatenate([pictures[item.name] for item in present], axis=2).astype(np.float32, copy=False)
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, "float")
    spec.channelnames = tuple(f"{layer}.{item.name}.{letter}" for item in present for letter in item.ids)
    spec.attribute("compression", "zip")
    spec.attribute("BlenderMultiChannel", "Blender V2.55.1 and newer")  # how Blender knows its own layout
    spec.attribute("Software", "Photon Map")
    for key, value in (metadata or {}).items():
        spec.attribute(f"photon_map/{key}", value if isinstance(value, str) else json.dumps(value))
    _write(path, spec, pixels[::-1])


def read_exr(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """What `write_exr` wrote (one part): pictures by pass name, bottom row first, and the metadata as text."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise RenderError(str(path), "cannot be read as a picture", oiio.geterror() or "check the path")
    spec = source.spec()
    pixels = source.read_image(0, 0, 0, spec.nchannels, "float")[::-1]
    source.close()
    names = list(spec.channelnames)
    pictures = {}
    for item in PASSES:
        found = [i for letter in item.ids for i, n in enumerate(names) if n.endswith(f".{item.name}.{letter}")]
        if found:
            pictures[item.name] = np.ascontiguousarray(pixels[..., found])
    prefix = "photon_map/"
    meta = {a.name[len(prefix) :]: a.value for a in spec.extra_attribs if a.name.startswith(prefix)}
    return pictures, meta


def srgb(linear: np.ndarray) -> np.ndarray:
    """Linear Rec. 709 as sRGB code values in [0, 1] [IEC 61966-2-1]."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1.0 / 2.4) - 0.055)


def write_sheet(path: str | Path, pictures: dict[str, np.ndarray]) -> None:
    """A PNG of Combined and its three main parts, 2 x 2, labelled, as sRGB without tone mapping.

    Of pictures without some of them those that are there; without any, the first picture.
    """
    names = [name for name in SHEET if name in pictures] or list(pictures)[:1]
    tiles = [_labelled(srgb(_three(pictures[name])[::-1]).astype(np.float32), name) for name in names]
    if len(tiles) == 3:
        tiles.append(np.zeros_like(tiles[0]))
    rows = [np.concatenate(tiles[i : i + 2], axis=1) for i in range(0, len(tiles), 2)]
    sheet = np.concatenate(rows, axis=0)
    height, width, _ = sheet.shape
    spec = oiio.ImageSpec(width, height, 3, "uint8")
    _write(path, spec, np.round(sheet * 255.0).astype(np.uint8))


def _three(picture: np.ndarray) -> np.ndarray:
    """The first three channels; one channel as grey."""
    return picture[..., :3] if picture.shape[2] >= 3 else np.repeat(picture[..., :1], 3, axis=2)


def _labelled(tile: np.ndarray, text: str) -> np.ndarray:
    """The tile with its name in the upper left corner, where there is room for it."""
    height, width, _ = tile.shape
    if height < 4 * LABEL_HEIGHT or width < 8 * LABEL_HEIGHT:
        return tile
    buffer = oiio.ImageBuf(np.ascontiguousarray(tile))
    for shift, colour in ((1, (0.0, 0.0, 0.0)), (0, (1.0, 1.0, 1.0))):  # a shadow, for bright pictures
        x, y = LABEL_HEIGHT // 2 + shift, 3 * LABEL_HEIGHT // 2 + shift
        if not oiio.ImageBufAlgo.render_text(buffer, x, y, text, LABEL_HEIGHT, "", colour):
            return tile  # OpenImageIO without fonts: a sheet without labels
    return buffer.get_pixels(oiio.FLOAT)


def _write(path: str | Path, spec: oiio.ImageSpec, pixels: np.ndarray) -> None:
    """Write the image beside its place and move it there, so that no half-written file is left."""
    path = Path(path)
    check_writable(path)
    partial = path.with_name(f"{path.stem}.partial{path.suffix}")
    out = oiio.ImageOutput.create(str(partial))
    if out is None:
        raise OutputError(str(path), f"cannot be written: {oiio.geterror()}", "use the ending .exr or .png")
    ok = out.open(str(partial), spec) and out.write_image(np.ascontiguousarray(pixels))
    problem = out.geterror()
    if not (out.close() and ok):
        partial.unlink(missing_ok=True)
        raise OutputError(str(path), f"cannot be written: {problem or out.geterror()}", "choose another place")
    try:
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(str(path), f"cannot be written: {error.strerror}", "choose another place") from error
