"""How wrong a denoised picture still is, from two half buffers: passes of even and of odd place, denoised apart.

With R_a, R_b the raw halves (independent, unbiased but for the gather radius) and D_a, D_b the same denoised:

    E (D_a - D_b)^2 = 2 n                     n: variance of a denoised half
    E (D_a - R_b)^2 = m + v,  E (R_a - R_b)^2 = 2 v     m: mean squared error of D_a, v: variance of R_a

so m = (|D_a - R_b|^2 + |D_b - R_a|^2) / 2 - |R_a - R_b|^2 / 2 also holds what the denoiser smeared, which the
difference of two denoised pictures alone cannot show. The picture of all passes has half the variance of a half:
m - n / 2 is left. What the gather radius smeared is in both halves: the film's own estimate of it is added.

Where one half saw a lamp in a glass by chance and the other did not, the figure is that pixel's luck: at 8 passes of
cornell_caustics one such pixel made it -0.018 instead of 0.001. So a thousandth of the pixels is left out at each end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .passes import LIGHT_NAMES

FLOOR = 0.01  # added to the squared picture, as in relMSE
OUTLIERS = 0.001  # part of the pixels left out, the lowest and the highest each
DOUBT = 2.0  # of the square of a pixel's relative standard error: beyond 1 / DOUBT nothing of it is kept as rendered
TINY = 1e-30


class DenoisedError(NamedTuple):
    """Relative mean squared error of the denoised Combined, mean((x - truth)^2 / (truth^2 + 0.01)), as estimated.

    Of all pixels but a thousandth at either end.
    """

    noise: float  # its random part
    total: float  # with what the denoiser and the gather radius smeared; not below the noise
    doubt: float  # standard error of the total: raw halves that are all noise tell little of what was smeared


class Halves:
    """Sums of Combined and of Emission over every other pass.

    It takes no part in merging: it tells of the passes added to it.
    """

    def __init__(self, height: int, width: int, exposure: float) -> None:
        self.sums = np.zeros((2, height, width, 3))
        self.emission: np.ndarray | None = None  # as sums; None: black so far
        self.counts = [0, 0]
        self.exposure = exposure

    def add(self, image: dict[str, np.ndarray]) -> None:
        """Take in one pass, as Film.add does."""
        half = sum(self.counts) % 2
        for name in LIGHT_NAMES:
            self.sums[half] += image[name]
        if image["Emission"].any():
            if self.emission is None:
                self.emission = np.zeros_like(self.sums)
            self.emission[half] += image["Emission"]
        self.counts[half] += 1

    @property
    def full(self) -> bool:
        """Whether both halves hold the same number of passes, at least one."""
        return self.counts[0] == self.counts[1] > 0

    def pictures(self) -> tuple[np.ndarray, np.ndarray]:
        """The raw halves (h, w, 3) f32, exposure applied."""
        return self._means(self.sums)

    def emissions(self) -> tuple[np.ndarray, np.ndarray] | None:
        """The same of Emission; None where it is black."""
        return None if self.emission is None else self._means(self.emission)

    def _means(self, sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means over the passes of either half."""
        first, second = (
            (total * (self.exposure / max(count, 1))).astype(np.float32)
            for total, count in zip(sums, self.counts, strict=True)
        )
        return first, second


def steady_share(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """How much of each pixel of Emission is kept as rendered, (h, w, 1) f32, from its two halves (h, w, 3).

    1 where both saw the same, 0 where one of them saw next to all: (a - b)^2 / (a + b)^2 estimates the square of the
    relative standard error of the mean. The mean plus and minus a known standard error are such halves too.
    """
    first, second = first.astype(np.float64), second.astype(np.float64)
    gap, sum_ = ((x**2).sum(axis=2, keepdims=True) for x in (first - second, first + second))
    return np.maximum(1.0 - DOUBT * gap / np.maximum(sum_, TINY), 0.0).astype(np.float32)


def denoised_error(
    raw: tuple[np.ndarray, np.ndarray], clean: tuple[np.ndarray, np.ndarray], smeared: float = 0.0
) -> DenoisedError:
    """The error of the denoised picture of all passes, from the raw and the denoised halves, each (h, w, 3).

    smeared : mean over pixels of the relative squared bias of the gather radius
    """
    (ra, rb), (da, db) = (tuple(x.astype(np.float64) for x in pair) for pair in (raw, clean))
    # by the darker half it came out half as large again as the truth, on six samples
    weight = 1.0 / (0.25 * (da + db) ** 2 + FLOOR)
    variance = 0.5 * most(((da - db) ** 2 * weight).mean(axis=2))
    noise = 0.5 * variance
    squares = (0.5 * ((da - rb) ** 2 + (db - ra) ** 2 - (ra - rb) ** 2) * weight).mean(axis=2)
    doubt = float(kept(squares).std()) / squares.size**0.5
    return DenoisedError(noise, max(most(squares) - noise, noise) + smeared, doubt)


def kept(values: np.ndarray) -> np.ndarray:
    """The values of a picture (h, w) but the outliers at either end."""
    cut = int(OUTLIERS * values.size)
    return np.partition(values.ravel(), (cut, values.size - 1 - cut))[cut : values.size - cut]


def most(values: np.ndarray) -> float:
    """Mean over a picture (h, w), the outliers at either end counted as nothing."""
    return float(kept(values).sum() / values.size)
