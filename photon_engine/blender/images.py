"""Blender's images as arrays of the pixels that Cycles would look up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..issues import IssueLog
from ..scene.data import Image
from ..shading.textures import linear_to_srgb, srgb_to_linear

MAGENTA = (1.0, 0.0, 1.0, 1.0)  # a missing file, as in Blender
DATA_SPACES = {"Non-Color", "Raw", "Generic Data"}
LINEAR_SPACES = {"Linear Rec.709", "Linear", "scene_linear"}
SRGB_SPACES = {"sRGB", "sRGB - Display"}
ENCODED_FORMATS = {"PNG", "TIFF", "JPEG", "BMP", "TARGA", "TARGA_RAW", "JPEG2000", "WEBP"}
SOURCES = {
    "SEQUENCE": "an image sequence: the frame that Blender has loaded is used",
    "MOVIE": "a movie: the frame that Blender has loaded is used",
    "TILED": "a tiled (UDIM) image: its first tile is used everywhere",
}


class ImageTable:
    """The images that a scene's materials use, each once; `images` is SceneData.images."""

    def __init__(self, issues: IssueLog) -> None:
        """Start with no image; problems go to `issues`."""
        self.issues = issues
        self.images: list[Image] = []
        self._index: dict[int, int] = {}

    def index(self, image: Any) -> int:
        """Place of a bpy image in `images`; it is read at the first call."""
        key = image.as_pointer()
        if key not in self._index:
            self._index[key] = len(self.images)
            self.images.append(read_image(image, self.issues))
        return self._index[key]


def read_image(image: Any, issues: IssueLog) -> Image:
    """A bpy image's pixels, premultiplied unless its alpha is channel packed or ignored.

    Byte images in sRGB keep the curve (`encoded`): Cycles interpolates them so and decodes afterwards.
    """
    space = image.colorspace_settings.name
    if image.source in SOURCES:
        issues.warn(image.name, f"{SOURCES[image.source]}", "other frames and tiles are not supported yet")
    pixels = read_pixels(image)
    if pixels is None:
        path = bpy.path.abspath(image.filepath, library=image.library)
        issues.warn(image.name, _missing(path), "magenta is used in its place")
        return Image(image.name, np.array(MAGENTA, np.float32)[None, None], "Non-Color", "NONE")
    mode = image.alpha_mode
    if mode == "NONE":
        pixels[..., 3] = 1.0
    encoded = space in SRGB_SPACES and not image.is_float
    if not image.is_float:
        if space not in SRGB_SPACES | DATA_SPACES | LINEAR_SPACES:
            pixels[..., :3] = to_scene_linear(pixels[..., :3], space, image.name, issues)
        if mode in ("STRAIGHT", "PREMUL") and space not in DATA_SPACES:
            pixels[..., :3] *= pixels[..., 3:4]
    elif space in SRGB_SPACES and image.file_format in ENCODED_FORMATS and image.source != "GENERATED":
        encode(pixels)
        encoded = True
    return Image(image.name, pixels, "Non-Color" if space in DATA_SPACES else space, mode, encoded)


def _missing(path: str) -> str:
    """Why an image has no pixels."""
    if not path:
        return "the image has no pixels and no file"
    if not Path(path).is_file():
        return f"the file {path} does not exist"
    return f"the file {path} could not be read"


def read_pixels(image: Any) -> np.ndarray | None:
    """Pixels as (H, W, 4) f32, bottom row first, as Blender holds them; None: there are none."""
    width, height = image.size
    if width == 0 or height == 0:  # not loaded yet: asking for the pixels loads it
        image.pixels  # noqa: B018
        width, height = image.size
    channels = image.channels
    if width * height * channels == 0 or len(image.pixels) != width * height * channels:
        return None
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    flat = flat.reshape(height, width, channels)
    if channels == 4:
        return flat
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = flat[..., :1] if channels < 3 else flat
    if channels == 2:
        pixels[..., 3] = flat[..., 1]
    return pixels


def encode(pixels: np.ndarray) -> None:
    """Put the sRGB curve on linear premultiplied pixels, in place, as files with 16 bits are looked up in Cycles."""
    alpha = pixels[..., 3:4]
    straight = pixels[..., :3] / np.where(alpha > 0.0, alpha, 1.0)
    pixels[..., :3] = linear_to_srgb(straight) * alpha


def to_scene_linear(rgb: np.ndarray, space: str, name: str, issues: IssueLog) -> np.ndarray:
    """Colours of a named space as scene linear, by Blender's own colour configuration."""
    try:
        import OpenImageIO as oiio
    except ImportError:
        issues.warn(name, f"the colour space {space} needs OpenImageIO", "the pixels are taken as sRGB")
        return srgb_to_linear(rgb).astype(np.float32)
    config = Path(bpy.utils.system_resource("DATAFILES")) / "colormanagement" / "config.ocio"
    source = oiio.ImageBuf(np.ascontiguousarray(rgb))
    target = oiio.ImageBufAlgo.colorconvert(source, space, "scene_linear", unpremult=False, colorconfig=str(config))
    if target.has_error:
        issues.warn(name, f"the colour space {space} is not known: {target.geterror()}", "the pixels are taken as sRGB")
        return srgb_to_linear(rgb).astype(np.float32)
    return target.get_pixels(oiio.FLOAT)
