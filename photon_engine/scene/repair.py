"""What a scene may hold that no picture can be made of, replaced and named."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..issues import IssueLog
from .data import Image, SceneData


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
