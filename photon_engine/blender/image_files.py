"""Files of image sequences, movies' frames and UDIM tiles, read beside Blender, which holds one of them at a time."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import bpy
import numpy as np

FLOAT_FORMATS = {"openexr": "OPEN_EXR", "hdr": "HDR", "rla": "RLA"}


def frame_number(user: Any, scene_frame: int) -> int:
    """The number of the file that an image user shows in a frame of the scene."""
    if not user.use_auto_refresh:
        return user.frame_current
    frame, count = scene_frame - user.frame_start + 1, user.frame_duration
    if count == 0:
        return 0
    frame = (frame - 1) % count + 1 if user.use_cyclic else min(max(frame, 0), count)
    return frame + user.frame_offset


def sequence_path(path: str, number: int) -> str:
    """A file's path with its last number replaced, digits kept."""
    folder, name = Path(path).parent, Path(path).name
    found = list(re.finditer(r"\d+", Path(name).stem))
    if not found:
        return path
    digits = found[-1]
    width = digits.end() - digits.start()
    return str(folder / f"{name[:digits.start()]}{number:0{width}d}{name[digits.end():]}")


def tile_path(path: str, number: int) -> str:
    """A UDIM image's path of one tile: <UDIM> is 1001, ..., <UVTILE> is u1_v1, ..."""
    column, row = (number - 1001) % 10, (number - 1001) // 10
    return path.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}")


class FileImage:
    """A file as if Blender had loaded it: what `images.read_image` asks of a bpy image."""

    source = "FILE"
    packed_file = None
    is_dirty = False

    def __init__(self, image: Any, path: str, label: str) -> None:
        """Settings are those of the image; `label` tells the files apart in messages."""
        self.name = f"{image.name} {label}"
        self.colorspace_settings = image.colorspace_settings
        self.alpha_mode = image.alpha_mode
        self.library = image.library
        self.filepath = bpy.path.abspath(path, library=image.library)
        self.size, self.channels, self.is_float, self.depth, self.file_format = (0, 0), 0, False, 0, ""
        self._pixels = np.empty(0, np.float32)
        self._read()

    @property
    def pixels(self) -> FileImage:
        """Itself: it has a length and foreach_get."""
        return self

    def __len__(self) -> int:
        """Number of values."""
        return len(self._pixels)

    def foreach_get(self, target: np.ndarray) -> None:
        """Copy the values, bottom row first; bytes straight, floats premultiplied, as Blender has them."""
        target[:] = self._pixels

    def _read(self) -> None:
        """Read the file, if it can be."""
        if not Path(self.filepath).is_file():
            return
        import OpenImageIO as oiio

        config = oiio.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)
        file = oiio.ImageInput.open(self.filepath, config)
        if file is None:
            return
        spec, pixels = file.spec(), file.read_image(format="float")
        kind = file.format_name()
        file.close()
        if pixels is None:
            return
        pixels = np.asarray(pixels, np.float32).reshape(spec.height, spec.width, -1)[::-1]
        wide = spec.format != oiio.UINT8
        self.is_float = wide
        self.file_format = FLOAT_FORMATS.get(kind, kind.upper())
        channels = min(pixels.shape[2], 4)
        if wide and kind not in FLOAT_FORMATS and channels in (2, 4):
            pixels = np.concatenate([pixels[..., : channels - 1] * pixels[..., channels - 1 : channels],
                                     pixels[..., channels - 1 : channels]], axis=2)
        self.size, self.channels = (spec.width, spec.height), channels
        self.depth = 8 * channels
        self._pixels = np.ascontiguousarray(pixels[..., :channels]).ravel()
