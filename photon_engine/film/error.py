"""How wrong the picture still is: noise and bias of each light pass and of Combined, by pixel and as one figure.

Noise: passes are independent pictures, so the squared standard error of their mean is the variance over passes by
their count, whatever their radii were.

Bias: what the gather radius smears. Each pass brings an estimate of its own bias (transport/gather_kernels.gather);
the mean of those estimates the bias of the mean. At one pixel it is noisier than the picture itself, so what is used is
its square less the square of its own standard error, averaged over a neighbourhood: unbiased, and small where there
is little to smear. The estimate is exact for smooth light and half of the truth (rms) across an edge; BIAS_FACTOR
lies between.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .accumulate import Film
from .passes import BIASES, LIGHT_NAMES

BIAS_OF = BIASES | {"Combined": "CombinedBias"}
ERROR_NAMES = (*LIGHT_NAMES, "Combined")
BIAS_FACTOR = 2.0**0.5  # 1 where light is smooth, 2 across an edge: wrong by at most 1.41 either way
BIAS_WINDOW = 9  # [px] side of the neighbourhood that the squared bias is averaged over
NOISE_WINDOW = 5  # [px] side of the neighbourhood that lends its variance where few passes saw light
SPREAD_WINDOW = 3  # [px] the same for figures of the picture, where a wider one would multiply single bright pixels
FLOOR = 0.1  # of the pass's mean: what is darker counts as this bright, or black pixels would have infinite errors
FLOOR_OF_COMBINED = 0.01  # nor does a pass count as darker than this part of all light: nobody would see its error
CONFIDENCE = 0.95
TINY = 1e-300
SPREAD_STEP = 0.02  # relative width of a bin of standard deviations
MOST_MEASURED = 1 << 18  # [px] enough for figures of a picture of any size; 0.2 s for a light pass
FEWEST_PASSES = 2  # that show a variance


class ErrorMap(NamedTuple):
    """Errors of one pass of the picture, by pixel, in units of radiance."""

    noise: np.ndarray  # (h, w, 3) f64, standard error of the mean
    bias: np.ndarray  # (h, w, 3) f64, expected size (rms) of what the radius smears
    interval: np.ndarray  # (h, w, 3) f64: the true value is within this of the mean in 95% of pixels


class PassError(NamedTuple):
    """Errors of one pass of the picture, relative to its brightness: see `relative`."""

    noise: float  # rms over pixels and channels
    bias: float
    error: float  # both together, where no pixel counts as more than 100% off
    at_share: float  # the asked share of pixels is off by less

    def rounded(self) -> dict[str, float | None]:
        """Plain values for logs, None where nothing is known."""
        return {name: None if np.isnan(value) else float(f"{value:.4g}") for name, value in self._asdict().items()}


def box(values: np.ndarray, side: int) -> np.ndarray:
    """Mean over a square of side x side pixels around each, cut off at the picture's edges; (h, w, c)."""
    from scipy.ndimage import uniform_filter

    return uniform_filter(values, (side, side, 1), mode="nearest")


def squared_noise(film: Film, name: str) -> np.ndarray:
    """Squared standard error of the mean, unbiased: (h, w, 3)."""
    return film.variance(name) / max(film.count, 1)


def squared_bias(film: Film, name: str) -> np.ndarray:
    """Squared bias, averaged relative to brightness over a neighbourhood: (h, w, 3), zero for passes without a radius.

    Where noise makes the estimate negative it is cut at zero, and what is left is scaled to the sum that the picture
    has without the cut, or noise would pile up as bias.
    """
    if name not in BIAS_OF:
        return np.zeros((film.height, film.width, 3))
    scale2 = np.maximum(brightness(film, name) ** 2, TINY)
    relative = (film.mean(BIAS_OF[name]) ** 2 - squared_noise(film, BIAS_OF[name])) / scale2
    # more than all of a pixel's light is not smeared away: it is one rare photon, and no matter of its neighbours
    relative = np.clip(relative, -1.0, 1.0)
    near = box(relative, BIAS_WINDOW)
    positive = np.maximum(near, 0.0)
    kept = max(relative.sum(), 0.0) / max(positive.sum(), TINY)
    return BIAS_FACTOR**2 * kept * positive * scale2


def error_map(film: Film, name: str) -> ErrorMap:
    """Error bars of a pass; NaN with fewer than two passes of the loop.

    In the interval, the variance of a pixel is no less than the mean of its neighbourhood's: where a rare bright photon
    falls, most pixels have not seen one yet, and their own variance would claim certainty. Student's quantile for
    the few passes at first.
    """
    from scipy.stats import t

    noise2, bias = squared_noise(film, name), np.sqrt(squared_bias(film, name))
    pooled = np.sqrt(np.maximum(noise2, box(noise2, NOISE_WINDOW)))
    quantile = t.ppf(0.5 + 0.5 * CONFIDENCE, film.count - 1) if film.count > 1 else np.nan
    return ErrorMap(np.sqrt(noise2), bias, quantile * pooled + bias)


def error_picture(film: Film, name: str) -> np.ndarray:
    """One of passes.ERROR_MAPS: (h, w, 3) f32, of Combined."""
    return getattr(error_map(film, "Combined"), name.lower()).astype(np.float32)


def brightness(film: Film, name: str) -> np.ndarray:
    """What errors are relative to: (h, w, 1), the pixel's mean over channels, smoothed, and never near black."""
    value = np.maximum(film.mean(name).mean(axis=2, keepdims=True), 0.0)
    floor = max(FLOOR * value.mean(), FLOOR_OF_COMBINED * film.mean("Combined").mean())
    return np.hypot(box(value, NOISE_WINDOW), floor)


def picture_error(film: Film, name: str, share: float = CONFIDENCE) -> PassError:
    """Errors of a pass as figures for the picture; NaN with fewer than two passes and where nothing is
    measured, zero for a black pass.

    share : of pixels, for `at_share`
    Root mean squares over pixels of the error by the pixel's brightness. Of big pictures, the
    film's measured rows.
    """
    if film.count < FEWEST_PASSES or not film.measures:
        return PassError(*[float("nan")] * 4)
    film = film.measured()
    scale2 = brightness(film, name) ** 2
    if not scale2.any():
        return PassError(0.0, 0.0, 0.0, 0.0)
    noise2 = (squared_noise(film, name) / scale2).mean(axis=2)
    bias2 = (squared_bias(film, name) / scale2).mean(axis=2)
    # the own variance of a pixel with few passes is a gamble, and 0 where it saw no light yet: ask its neighbours
    spread = np.sqrt(np.maximum(box((noise2 + bias2)[:, :, None], SPREAD_WINDOW), 0.0))  # box rounds
    rms = (float(np.sqrt(square.mean())) for square in (noise2, bias2, capped_square(spread)))
    return PassError(*rms, quantile_of_errors(spread, share))


def capped_square(spread: np.ndarray) -> np.ndarray:
    """Mean of min(e^2, 1) of a normal error e with standard deviation `spread`.

    A pixel off by more than its brightness is wrong, however much: without the cap one firefly is the error of a whole
    picture, and nothing can be said of it before it was seen.
    """
    from scipy.special import erf

    a = 1.0 / np.maximum(spread, 1e-9)
    inside = erf(a / np.sqrt(2.0))
    return spread**2 * (inside - np.sqrt(2.0 / np.pi) * a * np.exp(-0.5 * a * a)) + 1.0 - inside


def quantile_of_errors(spread: np.ndarray, share: float) -> float:
    """What the given share of errors stays below, errors being normal with the standard deviations `spread`.

    Solves mean erf(x / (sqrt(2) spread)) = share over a histogram of the spreads (steps of 2%).
    """
    from scipy.optimize import brentq
    from scipy.special import erf

    lit = spread[spread > 0.0]
    black = 1.0 - lit.size / spread.size
    if share <= black:
        return 0.0
    step = np.rint(np.log(lit) / SPREAD_STEP).astype(int)
    part = np.bincount(step - step.min()) / spread.size
    sigma = np.exp((step.min() + np.arange(len(part))) * SPREAD_STEP)

    def beyond(log_x: float) -> float:
        return black + (part * erf(np.exp(log_x) / (np.sqrt(2.0) * sigma))).sum() - share

    return float(np.exp(brentq(beyond, np.log(sigma[0] * 1e-9), np.log(sigma[-1] * 40.0), xtol=1e-4)))
