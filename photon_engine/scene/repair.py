"""What a scene may hold that no picture can be made of, replaced and named."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..issues import IssueLog
from .data import Image, Light, SceneData

FARTHEST = 1e12  # [m] a lamp may be away or wide: three such lengths multiplied are still a number in single precision
THINNEST = 1e-12  # [m] of a round lamp: a point, and its radiance would go beyond single precision
NARROWEST = 1e-6  # [rad] angles whose cosine is told from 1 in double precision, with digits to spare


def with_finite_images(scene: SceneData, issues: IssueLog) -> SceneData:
    """The scene with its images' texels finite; the same object when they are.

    A texel of which one channel is NaN or infinite becomes 0 in all four, as in Cycles: one channel alone would change
    its hue, and a single such texel would make every pixel that its light reaches a NaN.
    """
    images = [_finite(image, issues) for image in scene.images]
    same = all(new is old for new, old in zip(images, scene.images, strict=True))
    return scene if same else dataclasses.replace(scene, images=images)


def _finite(image: Image, issues: IssueLog) -> Image:
    """An image without texels that are not finite numbers."""
    pixels = image.pixels
    if pixels is None or pixels.dtype.kind != "f" or np.isfinite(pixels.sum(dtype=np.float64)):
        return image
    good = np.isfinite(pixels).all(axis=2)
    if good.all():  # the sum alone overflowed
        return image
    issues.warn(
        image.name,
        f"{int((~good).sum())} texels are not finite numbers and are taken as black",
        "look at how the image was made",
    )
    return dataclasses.replace(image, pixels=np.where(good[:, :, None], pixels, np.float32(0.0)).astype(pixels.dtype))


def with_lamps_in_reach(scene: SceneData, issues: IssueLog) -> SceneData:
    """The scene without lamps that are too far, too large or too narrow for the numbers that would describe them.

    Each is named. Those so small that their radiance would be no number become points and directions, with the same
    light. The same object when nothing changes.
    """
    lights = [without_a_trace_of_size(item) for item in scene.lights if _in_reach(item, issues)]
    same = len(lights) == len(scene.lights) and all(a is b for a, b in zip(lights, scene.lights, strict=True))
    return scene if same else dataclasses.replace(scene, lights=lights)


def without_a_trace_of_size(light: Light) -> Light:
    """The lamp, its radius, angle or spread 0 when below THINNEST or NARROWEST; the same object when none is."""
    least = {"radius": THINNEST, "angle": NARROWEST, "spread": NARROWEST}
    gone = {name: 0.0 for name, value in least.items() if 0.0 < getattr(light, name) < value}
    return dataclasses.replace(light, **gone) if gone else light


def _in_reach(light: Light, issues: IssueLog) -> bool:
    """Whether a lamp can be computed with; numbers that are not finite are for the lights' table to refuse."""
    scale = np.abs(light.matrix[:3]).max()
    if max(scale, light.radius, scale * max(light.size)) > FARTHEST:
        issues.warn(light.name, f"it is farther away or larger than {FARTHEST:g} m: left out", "move it, or use a sun")
        return False
    if light.kind == "SPOT" and light.spot_size < NARROWEST:
        issues.warn(light.name, "its cone is too narrow to light anything: left out", "widen the spot size")
        return False
    return True
