"""The Image Texture node."""

from __future__ import annotations

import numpy as np

from ..registry import f32, node, unlinked
from ..textures import (
    DECODE,
    EXTENSIONS,
    INTERPOLATIONS,
    LINEAR,
    UNPREMULTIPLY,
    sample_image,
)

MISSING = (1.0, 0.0, 1.0)  # magenta, as Cycles shows what it cannot find


def image_needs(item, used):
    """UVs when no vector is linked."""
    return {"uv"} if unlinked("Vector")(item, used) else set()


def place(vector, projection):
    """Image coordinates of a texture vector: flat, on a sphere or on a tube."""
    if projection not in ("SPHERE", "TUBE"):
        return vector[:2]
    x, y, z = 2.0 * vector - f32(1.0)
    radius = np.sqrt(x * x + y * y)
    u = np.where(radius > 0.0, f32(0.5) * (f32(1.0) - np.arctan2(x, y) * f32(1.0 / np.pi)), f32(0.0))
    if projection == "TUBE":
        return np.stack([u, (z + f32(1.0)) * f32(0.5)])
    size = np.sqrt(radius * radius + z * z)
    v = f32(1.0) - np.arccos(np.clip(z / np.where(size > 0.0, size, f32(1.0)), -1.0, 1.0)) * f32(1.0 / np.pi)
    return np.stack([u, np.where(size > 0.0, v, f32(0.0))])


@node("ShaderNodeTexImage", varies=unlinked("Vector"), needs=image_needs)
def image_texture(x, props, points):
    """Colour and alpha of an image at the vector, or at the active UV layer."""
    vector = x.get("Vector")
    uv = points.uvs[""].T if vector is None else place(vector, props.get("projection", "FLAT"))
    index = props.get("image")
    if index is None:  # no image is chosen
        return {"Color": np.array(MISSING, f32)[:, None], "Alpha": np.ones(1, f32)}
    image = props["images"][index]
    flags = DECODE if image.encoded else 0
    premultiplied = image.colorspace != "Non-Color" and image.alpha_mode not in ("CHANNEL_PACKED", "NONE")
    if premultiplied and "Alpha" in props["used"]:  # Cycles gives straight colour only beside its alpha
        flags |= UNPREMULTIPLY
    mode = INTERPOLATIONS.get(props.get("interpolation", "Linear"), LINEAR)
    extension = EXTENSIONS[props.get("extension", "REPEAT")]
    out = sample_image(image.pixels, uv, mode, extension, flags)
    return {"Color": out[:3], "Alpha": out[3]}
