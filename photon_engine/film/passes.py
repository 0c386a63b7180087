"""The pictures that a render makes, each once: Blender's passes, the film and the files are made from this list."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

BACKGROUND_DEPTH = 1e10  # what Cycles writes where the camera sees nothing


class RenderPass(NamedTuple):
    """One picture of a render."""

    name: str
    channels: int
    ids: str  # one letter a channel, as in Blender's and OpenEXR's channel names
    kind: str  # Blender's type: COLOR, VECTOR, VALUE
    is_light: bool  # linear in radiance: film exposure multiplies it, and it has a second moment
    text: str
    usual: bool = True  # made unless told otherwise


COMBINED = RenderPass("Combined", 4, "RGBA", "COLOR", True, "All light, with alpha")
LIGHT_PASSES = (
    RenderPass("Direct", 3, "RGB", "COLOR", True, "Light that comes straight from a source to a rough surface"),
    RenderPass("Caustic", 3, "RGB", "COLOR", True, "Light focused by glass and metal onto a rough surface"),
    RenderPass("Diffuse", 3, "RGB", "COLOR", True, "Light that went between rough surfaces first"),
    RenderPass("Emission", 3, "RGB", "COLOR", True, "Sources seen by the camera, also through glass and in mirrors"),
    RenderPass("Environment", 3, "RGB", "COLOR", True, "The world, also seen through glass and in mirrors"),
)
DEPTH = RenderPass("Depth", 1, "Z", "VALUE", False, "Distance from the camera along its axis, of one sample")
GUIDE_PASSES = (
    DEPTH,
    RenderPass("Normal", 3, "XYZ", "VECTOR", False, "Shading normal in world space"),
    RenderPass("Albedo", 3, "RGB", "COLOR", False, "Colour of the surface without light"),
)
# what guides the denoiser: of the first rough surface, also through glass and in mirrors
DENOISING_PASSES = (
    RenderPass("Denoising Albedo", 3, "RGB", "COLOR", False, "Colour that guides the denoiser", False),
    RenderPass("Denoising Normal", 3, "XYZ", "VECTOR", False, "Normal that guides the denoiser", False),
)
NOISY = "Noisy "  # before the name of a pass: that pass as it was before denoising
NOISY_PASSES = tuple(
    item._replace(name=NOISY + item.name, text=f"{item.name} before denoising", usual=False)
    for item in (COMBINED, *LIGHT_PASSES)
)
ERROR_PASSES = (
    RenderPass("Noise", 3, "RGB", "COLOR", False, "Standard error of Combined, in units of light", False),
    RenderPass("Bias", 3, "RGB", "COLOR", False, "How much light in Combined the radius smears, about", False),
)
PASSES = (COMBINED, *LIGHT_PASSES, *GUIDE_PASSES, *DENOISING_PASSES, *ERROR_PASSES, *NOISY_PASSES)
USUAL = tuple(item for item in PASSES if item.usual)
BY_NAME = {item.name: item for item in PASSES}
ERROR_MAPS = frozenset(item.name for item in ERROR_PASSES)  # made when asked for: they need the variance of each pixel
ALL_NAMES = frozenset(BY_NAME) - ERROR_MAPS
GUIDES = frozenset(item.name for item in DENOISING_PASSES)
LIGHT_NAMES = tuple(item.name for item in LIGHT_PASSES)
GUIDE_NAMES = tuple(item.name for item in GUIDE_PASSES)

# what the transport hands over for each pass of the progressive loop: name -> channels
RAW = {item.name: item.channels for item in (*LIGHT_PASSES, *GUIDE_PASSES, *DENOISING_PASSES)} | {"Alpha": 1}

# light pass -> raw picture whose mean over passes estimates that pass's bias (transport/gather_kernels.gather)
BIASES = {"Caustic": "CausticBias", "Diffuse": "DiffuseBias"}
RAW |= dict.fromkeys(BIASES.values(), 3)

# what has a second moment: name -> the raw pictures that it is the sum of
MEASURED = (
    {name: (name,) for name in LIGHT_NAMES} | {"Combined": LIGHT_NAMES}
    | {name: (name,) for name in BIASES.values()} | {"CombinedBias": tuple(BIASES.values())}
)  # fmt: skip


def usual_outputs(denoise: str) -> frozenset[str]:
    """What is made unless told otherwise; a denoised render (setting `denoise`) shows its guides and its noise too."""
    return ALL_NAMES if denoise != "OFF" else frozenset(item.name for item in USUAL)


def in_full_frame(picture: np.ndarray, frame) -> np.ndarray:
    """The picture as it is written: a border that does not crop lies in a black full frame, as Blender does it.

    picture : (y1 - y0, x1 - x0, c);  frame : scene.data.Frame;  out : the same, or (height, width, c)
    """
    full = (frame.height, frame.width)
    if frame.crop or picture.shape[:2] == full:
        return picture
    out = np.zeros((*full, picture.shape[2]), picture.dtype)
    out[frame.y0 : frame.y1, frame.x0 : frame.x1] = picture
    return out
