"""How wrong a denoised picture still is, from two half buffers: passes of even and of odd place, denoised apart.

With R_a, R_b the raw halves (independent, unbiased but for the gather radius) and D_a, D_b the same denoised:

    E (D_a - D_b)^2 = 2 n                     n: variance of a denoised half
    E (D_a - R_b)^2 = m + v,  E (R_a - R_b)^2 = 2 v     m: mean squared error of D_a, v: variance of R_a

so m = (|D_a - R_b|^2 + |D_b - R_a|^2) / 2 - |R_a - R_b|^2 / 2 also holds what the denoiser smeared, which the
difference of two denoised pictures alone cannot show. The picture of all passes has half the variance of a half:
m - n / 2 is left. On three samples at 2 to 16 passes the estimate was 0.5 to 1.5 times the true relMSE.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .passes import LIGHT_NAMES

FLOOR = 0.01  # added to the squared picture, as in relMSE


class DenoisedError(NamedTuple):
    """Relative mean squared error of the denoised Combined, mean((x - truth)^2 / (truth^2 + 0.01)), as estimated."""

    noise: float  # its random part
    total: float  # with what the denoiser smeared; not below the noise


class Halves:
    """Sums of Combined over every other pass. It takes no part in merging: it tells of the passes added to it."""

    def __init__(self, height: int, width: int, exposure: float) -> None:
        self.sums = np.zeros((2, height, width, 3))
        self.counts = [0, 0]
        self.exposure = exposure

    def add(self, image: dict[str, np.ndarray]) -> None:
        """Take in one pass, as Film.add does."""
        half = sum(self.counts) % 2
        for name in LIGHT_NAMES:
            self.sums[half] += image[name]
        self.counts[half] += 1

    @property
    def full(self) -> bool:
        """Whether both halves hold the same number of passes, at least one."""
        return self.counts[0] == self.counts[1] > 0

    def pictures(self) -> tuple[np.ndarray, np.ndarray]:
        """The raw halves (h, w, 3) f32, exposure applied."""
        first, second = (
            (total * (self.exposure / max(count, 1))).astype(np.float32)
            for total, count in zip(self.sums, self.counts, strict=True)
        )
        return first, second


def denoised_error(raw: tuple[np.ndarray, np.ndarray], clean: tuple[np.ndarray, np.ndarray]) -> DenoisedError:
    """The error of the denoised picture of all passes, from the raw and the denoised halves, each (h, w, 3)."""
    (ra, rb), (da, db) = (tuple(x.astype(np.float64) for x in pair) for pair in (raw, clean))
    # the darker half: where one of them has a blotch the mean of both would hide it
    weight = 1.0 / (np.minimum(da, db) ** 2 + FLOOR)
    variance = 0.5 * float(np.mean((da - db) ** 2 * weight))
    half = 0.5 * float(np.mean(((da - rb) ** 2 + (db - ra) ** 2 - (ra - rb) ** 2) * weight))
    noise = 0.5 * variance
    return DenoisedError(noise, max(half - noise, noise))
