"""How far a picture is from a reference."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..film.exr import srgb
from ..issues import RenderError
from .reference import Known

EPSILON = 0.01
# part of the pixels that relMSE999 leaves out: it tells whether a few rule relMSE, and does not stand for it, as it
# flatters pictures whose light comes in few fireflies (Cycles after 1 s of cornell_caustics: relMSE 8, relMSE999 0.03)
WORST = 0.001
INSTALL = "pip install -r requirements-dev.txt"


class Errors(NamedTuple):
    """Errors of one picture."""

    relMSE: float  # mean((x - ref)^2 / (ref^2 + 0.01)) over all values [Rousselle et al. 2011]
    relMSE999: float  # the same without the 0.1% of pixels that are worst in it
    RMSE: float  # in units of radiance
    mean_ratio: float  # mean(x) / mean(ref): what is left is bias
    p99: float  # 99th percentile over pixels of the root of the relative squared error: fireflies
    FLIP: float  # mean FLIP of the sRGB pictures [Andersson et al. 2020], 67 pixels a degree


def errors(picture: np.ndarray, reference: Known) -> Errors:
    """Errors of (h, w, 3) f32 linear Rec. 709; a RenderError when the sizes differ or a package is missing.

    Where the reference knows its own standard error, its square is taken off relMSE, relMSE999 and RMSE, as its noise
    would be told as the picture's: of diffuse_room's it is 0.0007, half of what was told. What is left is never told as
    less than the doubt of what was taken off: where one bright pixel rules both, their difference may come out below 0,
    and the figure is not known to be small. What a reference does not know of cannot be taken off: where none of its
    paths met a lamp's small image, its standard error is 0, and a picture that has the image is told as wrong. Such
    pixels are few: where relMSE is several times relMSE999, they rule it.
    """
    if picture.shape != reference.mean.shape:
        theirs, ours = ("{1} x {0}".format(*a.shape[:2]) for a in (reference.mean, picture))
        raise RenderError("reference", f"is {theirs}, the picture {ours}", f"render with --resolution {theirs}")
    x, ref = picture.astype(np.float64), reference.mean.astype(np.float64)
    squared, known = (x - ref) ** 2, own_noise(reference)
    relative = squared / (ref**2 + EPSILON)
    by_pixel, noise = relative.mean(axis=2), (known / (ref**2 + EPSILON)).mean(axis=2)
    most = best(by_pixel)
    return Errors(
        left(by_pixel, noise),
        left(by_pixel.ravel()[most], noise.ravel()[most]),
        left(squared.mean(axis=2), known.mean(axis=2)) ** 0.5,
        float(x.mean() / ref.mean()) if ref.any() else float("nan"),
        float(np.quantile(np.sqrt(by_pixel), 0.99)),
        flip(picture, reference.mean),
    )


def left(squared: np.ndarray, noise: np.ndarray) -> float:
    """Mean of squared differences by pixel without the reference's squared noise, and no less than its doubt.

    Doubt: the square of normal noise of variance v has the variance 2 v^2; pixels are independent, channels are not.
    """
    doubt = (2.0 * (noise**2).sum()) ** 0.5 / noise.size
    return max(float((squared - noise).mean()), float(doubt))


def best(by_pixel: np.ndarray) -> np.ndarray:
    """Places in the flattened picture of all pixels but the WORST part, which is at least one of several pixels."""
    count = min(max(round(WORST * by_pixel.size), 1), by_pixel.size - 1)
    return np.argsort(by_pixel, axis=None, kind="stable")[: by_pixel.size - count]


def own_noise(reference: Known) -> np.ndarray:
    """Squared standard error of a reference: (h, w, 3) f64, zero where it is not known."""
    se = np.zeros(1) if reference.se is None else reference.se.astype(np.float64)
    return np.broadcast_to(se**2, reference.mean.shape)


def noise_figure(reference: Known) -> float:
    """The relMSE of the reference itself, as far as it knows: what is taken off."""
    return float((own_noise(reference) / (reference.mean.astype(np.float64) ** 2 + EPSILON)).mean())


def flip(picture: np.ndarray, reference: np.ndarray) -> float:
    """Mean FLIP, of both pictures as a screen shows them."""
    try:
        import flip_evaluator
    except ImportError:
        raise RenderError("report", "the package flip-evaluator is not installed", INSTALL) from None
    shown = [np.ascontiguousarray(srgb(a)[::-1], np.float32) for a in (reference, picture)]
    return float(flip_evaluator.evaluate(*shown, "LDR", applyMagma=False)[1])
