"""Blender's images as arrays of the pixels that Cycles would look up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..issues import IssueLog
from ..scene.data import Image
from ..shading.textures import linear_to_srgb, srgb_to_linear
from .compat import ALPHA_BY_MODE
from .image_files import FileImage, frame_number, sequence_path, tile_path

MAGENTA = (1.0, 0.0, 1.0, 1.0)  # a missing file, as in Blender
DATA_SPACES = {"Non-Color", "Raw", "Generic Data"}
LINEAR_SPACES = {"Linear Rec.709", "Linear", "scene_linear"}
SRGB_SPACES = {"sRGB", "sRGB - Display"}
SOURCES = {
    "SEQUENCE": "a packed image sequence: the frame that Blender has loaded is used",
    "MOVIE": "a movie: the frame that Blender has loaded is used",
    "TILED": "a packed tiled (UDIM) image: its first tile is used everywhere",
}


class ImageTable:
    """The images that a scene's materials use, each once; `images` is SceneData.images."""

    def __init__(self, issues: IssueLog, keep: Any = None) -> None:
        """Start with no image; problems go to `issues`. keep : a keep.Keep that may know images already."""
        self.issues = issues
        self.keep = keep
        self.frame: int | None = None  # of the scene; None: Blender's current one
        self.images: list[Image] = []
        self._index: dict[int, int] = {}

    def index(self, image: Any, user: Any = None) -> int:
        """Place of a bpy image in `images`; it is read at the first call. user : the node's ImageUser."""
        number = 0
        if image.source == "SEQUENCE" and user is not None and image.packed_file is None:
            number = frame_number(user, bpy.context.scene.frame_current if self.frame is None else self.frame)
        key = image.as_pointer(), number
        if key not in self._index:
            self._index[key] = len(self.images)
            self.images.append(Image(image.name))
            self.images[self._index[key]] = self._read(image, number)
        return self._index[key]

    def _read(self, image: Any, number: int) -> Image:
        """A still, a sequence's file of that number, or all tiles."""
        if image.source == "TILED" and image.packed_file is None:
            return self._tiles(image)
        if number:
            path = sequence_path(image.filepath, number)
            return read_image(FileImage(image, path, f"({Path(path).name})"), self.issues)
        kept = None if self.keep is None else self.keep.image(image, read_image, self.issues)
        return read_image(image, self.issues) if kept is None else kept

    def _tiles(self, image: Any) -> Image:
        """An image without pixels whose tiles are images of their own."""
        tiles = {}
        for tile in image.tiles:
            tiles[tile.number] = len(self.images)
            file = FileImage(image, tile_path(image.filepath_raw or image.filepath, tile.number), f"({tile.number})")
            self.images.append(read_image(file, self.issues))
        return Image(image.name, None, image.colorspace_settings.name, image.alpha_mode, tiles=tiles)


def read_image(image: Any, issues: IssueLog) -> Image:
    """A bpy image's pixels, premultiplied unless its alpha is channel packed or ignored.

    Images in sRGB keep the curve (`encoded`): Cycles interpolates under it and decodes afterwards.
    """
    space = image.colorspace_settings.name
    if image.source in SOURCES:
        issues.warn(image.name, f"{SOURCES[image.source]}", "other frames and tiles are not supported yet")
    pixels = read_pixels(image)
    if pixels is None:
        path = bpy.path.abspath(image.filepath, library=image.library)
        issues.warn(image.name, _missing(path), "magenta is used in its place")
        return Image(image.name, np.array(MAGENTA, np.float32)[None, None], "Non-Color", "NONE")
    encoded = space in SRGB_SPACES
    if image.is_float:
        encoded = encoded and not is_builtin(image)
        if encoded:
            encode(pixels, image.alpha_mode)
    converted = not image.is_float and space not in SRGB_SPACES | DATA_SPACES | LINEAR_SPACES
    if space not in DATA_SPACES:
        premultiply(pixels, image, whole_bytes=not converted)
    if converted:
        to_scene_linear(pixels, space, image, issues)
    if image.alpha_mode == "NONE":
        pixels[..., 3] = 1.0
    if not image.is_float and not converted:
        pixels = np.rint(pixels * np.float32(255.0)).astype(np.uint8)
    return Image(image.name, pixels, "Non-Color" if space in DATA_SPACES else space, image.alpha_mode, encoded)


def is_builtin(image: Any) -> bool:
    """Whether Cycles takes the pixels from Blender rather than from the file."""
    return image.source in ("GENERATED", "MOVIE") or image.packed_file is not None or image.is_dirty


def premultiply(pixels: np.ndarray, image: Any, whole_bytes: bool) -> None:
    """Multiply colour by alpha, in place, where Cycles does.

    whole_bytes: products of bytes are cut to bytes, as they are unless a colour space is converted afterwards.
    """
    if image.alpha_mode not in ("STRAIGHT", "PREMUL"):
        return
    power = alpha_power(image)
    if power > 0 and not image.is_float and image.alpha_mode == "PREMUL" and not is_builtin(image):
        byte_product(pixels, np.rint)  # back to the file's bytes
        power -= 1
    for _ in range(power):
        if image.is_float or not whole_bytes:
            pixels[..., :3] *= pixels[..., 3:4]
        else:
            byte_product(pixels, np.floor)
    if power < 0:
        alpha = pixels[..., 3:4]
        pixels[..., :3] /= np.where(alpha > 0.0, alpha, 1.0)


def alpha_power(image: Any) -> int:
    """How often Cycles' pixels are Blender's times alpha (measured: tests/test_nodes_cycles.py).

    Blender holds bytes straight and floats premultiplied. Cycles takes generated, packed and edited images from there
    and multiplies them: from 5.0 on as the mode says, so that floats can get their alpha twice, before only bytes.
    Files it reads itself: from 5.0 on as the mode says; before, it multiplied what the format stores straight and
    left alone what OpenEXR stores premultiplied. Grey files with alpha it never multiplies.
    """
    straight = image.alpha_mode == "STRAIGHT"
    if is_builtin(image):
        return int(straight) if ALPHA_BY_MODE else int(not image.is_float)
    if is_grey_alpha(image):
        return -int(straight) if image.is_float else int(not straight)
    if not image.is_float:
        return 1 if straight or ALPHA_BY_MODE else 2
    if ALPHA_BY_MODE:
        return 0
    return -int(straight) if image.file_format in ("OPEN_EXR", "OPEN_EXR_MULTILAYER") else int(not straight)


def is_grey_alpha(image: Any) -> bool:
    """Whether the file has two channels, which Blender does not tell of PNG before 5.0."""
    if image.file_format != "PNG":
        return image.depth == 16 and not image.is_float
    with open(bpy.path.abspath(image.filepath, library=image.library), "rb") as file:
        header = file.read(26)
    return len(header) == 26 and header[25] == 4  # colour type of the IHDR chunk [PNG, section 11.2.2]


def byte_product(pixels: np.ndarray, rounding: Any) -> None:
    """Colour times alpha, in place, cut to whole bytes; the small number keeps exact products from falling short."""
    product = pixels[..., :3] * pixels[..., 3:4] * np.float32(255.0)
    pixels[..., :3] = rounding(product + np.float32(1e-4)) * np.float32(1.0 / 255.0)


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


def encode(pixels: np.ndarray, alpha_mode: str) -> None:
    """Put the sRGB curve back on the linear pixels of a float file, in place: Cycles interpolates under the curve."""
    alpha = pixels[..., 3:4] if alpha_mode in ("STRAIGHT", "PREMUL") else np.ones(1, np.float32)
    straight = pixels[..., :3] / np.where(alpha > 0.0, alpha, 1.0)
    pixels[..., :3] = linear_to_srgb(straight) * alpha


def to_scene_linear(pixels: np.ndarray, space: str, image: Any, issues: IssueLog) -> None:
    """Convert a named space's premultiplied colours to scene linear, in place, by Blender's colour configuration."""
    alpha = pixels[..., 3:4] if image.alpha_mode in ("STRAIGHT", "PREMUL") else np.ones(1, np.float32)
    straight = np.ascontiguousarray(pixels[..., :3] / np.where(alpha > 0.0, alpha, 1.0))
    config = Path(bpy.utils.system_resource("DATAFILES")) / "colormanagement" / "config.ocio"
    try:
        import OpenImageIO as oiio
    except ImportError:
        linear, error = None, "OpenImageIO is not installed"
    else:
        target = oiio.ImageBufAlgo.colorconvert(oiio.ImageBuf(straight), space, "scene_linear", colorconfig=str(config))
        linear, error = (None, target.geterror()) if target.has_error else (target.get_pixels(oiio.FLOAT), "")
    if linear is None:
        issues.warn(image.name, f"the colour space {space} cannot be converted: {error}", "it is taken as sRGB")
        linear = srgb_to_linear(straight)
    pixels[..., :3] = linear * alpha
