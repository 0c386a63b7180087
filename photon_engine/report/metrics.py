"""How far a picture is from a reference."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..film.exr import srgb
from ..issues import RenderError

EPSILON = 0.01
INSTALL = "pip install -r requirements-dev.txt"


class Errors(NamedTuple):
    """Errors of one picture."""

    relMSE: float  # mean((x - ref)^2 / (ref^2 + 0.01)) over all values [Rousselle et al. 2011]
    RMSE: float  # in units of radiance
    mean_ratio: float  # mean(x) / mean(ref): what is left is bias
    p99: float  # 99th percentile over pixels of the root of the relative squared error: fireflies
    FLIP: float  # mean FLIP of the sRGB pictures [Andersson et al. 2020], 67 pixels a degree


def errors(picture: np.ndarray, reference: np.ndarray, se: np.ndarray | None = None) -> Errors:
    """Errors of (h, w, 3) f32 linear Rec. 709; a RenderError when the sizes differ or a package is missing.

    se : the reference's own standard error, (h, w, 3), where it is known. Its square is taken off relMSE and RMSE, as
    the reference's noise would be told as the picture's: of diffuse_room's it is 0.0007, half of what was told.
    """
    if picture.shape != reference.shape:
        theirs, ours = ("{1} x {0}".format(*a.shape[:2]) for a in (reference, picture))
        raise RenderError("reference", f"is {theirs}, the picture {ours}", f"render with --resolution {theirs}")
    x, ref = picture.astype(np.float64), reference.astype(np.float64)
    relative = (x - ref) ** 2 / (ref**2 + EPSILON)
    known = np.zeros_like(ref) if se is None else se.astype(np.float64) ** 2
    return Errors(
        max(float((relative - known / (ref**2 + EPSILON)).mean()), 0.0),
        max(float(((x - ref) ** 2 - known).mean()), 0.0) ** 0.5,
        float(x.mean() / ref.mean()) if ref.any() else float("nan"),
        float(np.quantile(np.sqrt(relative.mean(axis=2)), 0.99)),
        flip(picture, reference),
    )


def flip(picture: np.ndarray, reference: np.ndarray) -> float:
    """Mean FLIP, of both pictures as a screen shows them."""
    try:
        import flip_evaluator
    except ImportError:
        raise RenderError("report", "the package flip-evaluator is not installed", INSTALL) from None
    shown = [np.ascontiguousarray(srgb(a)[::-1], np.float32) for a in (reference, picture)]
    return float(flip_evaluator.evaluate(*shown, "LDR", applyMagma=False)[1])
