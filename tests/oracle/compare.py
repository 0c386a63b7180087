"""Does a picture agree with the oracle? By means over blocks of 16x16 pixels, outside noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import stats

BLOCK = 16
# 60 scenes x 16 blocks x 3 channels are about 3000 comparisons: at 4 sigma chance alone fails one run in five thousand
SIGMAS = 4.0
# a block whose mean is known no better than this part of the tolerance gets no verdict: at 4 sigma only an error of
# 1% + 4 x 0.5% = 3% would show
MAX_NOISE = 0.5
# light that Cycles drops at black: 1e-4 of the picture's mean, or dark blocks would be judged on rounding to half
FLOOR = 1e-4


class Block(NamedTuple):
    """One channel of one block."""

    row: int
    column: int
    channel: int
    ours: float
    theirs: float
    se: float  # of the difference

    def __str__(self) -> str:
        """Where, and by how much."""
        ratio = self.ours / self.theirs if self.theirs else float("inf")
        noise = self.se / self.theirs if self.theirs else float("inf")
        return (
            f"block ({self.row}, {self.column}) {'RGB'[self.channel]}: {self.ours:.5g} vs {self.theirs:.5g}, "
            f"ratio {ratio:.4f} +- {noise:.4f}"
        )


class BlockReport(NamedTuple):
    """The comparison of two pictures."""

    out: list[Block]  # beyond the tolerance, and not by noise
    unconverged: list[Block]  # too noisy for a verdict
    count: int  # blocks times channels compared
    mean_ratio: float  # mean(ours) / mean(theirs), luminance over the whole picture
    rel_mse: float
    judged: float  # part of the picture's light that lies in blocks with a verdict

    @property
    def agrees(self) -> bool:
        """Nothing out of tolerance, and a verdict on at least half of the light (else nothing was tested)."""
        return not self.out and self.judged >= 0.5

    def __str__(self) -> str:
        """Summary, then the blocks out of tolerance and those without a verdict."""
        lines = [
            f"{self.count - len(self.out) - len(self.unconverged)} of {self.count} agree, {len(self.out)} out of "
            f"tolerance, {len(self.unconverged)} without verdict ({100 * self.judged:.0f}% of the light judged); "
            f"mean ratio {self.mean_ratio:.4f}, relMSE {self.rel_mse:.2e}"
        ]
        lines += [f"  OUT  {block}" for block in self.out]
        lines += [f"  ?    {block}" for block in self.unconverged]
        return "\n".join(lines)


def blocks_of(image: np.ndarray, size: int = BLOCK) -> list[tuple[slice, slice]]:
    """Slices of the blocks, row by row; a remainder at the edges makes smaller blocks."""
    h, w = image.shape[:2]
    return [
        (slice(y, min(y + size, h)), slice(x, min(x + size, w))) for y in range(0, h, size) for x in range(0, w, size)
    ]


def block_grid(image: np.ndarray, size: int = BLOCK) -> tuple[int, int]:
    """Rows and columns of blocks."""
    h, w = image.shape[:2]
    return -(-h // size), -(-w // size)


def block_means(image: np.ndarray, size: int = BLOCK) -> np.ndarray:
    """Mean of each block: (h, w, c) -> (ceil(h / size), ceil(w / size), c) f64."""
    means = [image[s].reshape(-1, image.shape[2]).astype(np.float64).mean(axis=0) for s in blocks_of(image, size)]
    return np.array(means).reshape(*block_grid(image, size), image.shape[2])


def block_errors(se: np.ndarray, size: int = BLOCK) -> np.ndarray:
    """Standard error of each block's mean from that of its pixels, taken as independent."""
    errors = []
    for s in blocks_of(se, size):
        values = se[s].reshape(-1, se.shape[2]).astype(np.float64)
        errors.append(np.sqrt((values**2).sum(axis=0)) / len(values))
    return np.array(errors).reshape(*block_grid(se, size), se.shape[2])


def batch_block_errors(means: np.ndarray) -> np.ndarray:
    """Standard error of the average of independent pictures' block means (n, rows, columns, c).

    Pixels may depend on each other (photons are shared by neighbours). Widened by the ratio of Student's quantile to
    the normal one, so that SIGMAS times it is exceeded as seldom as with a known error.
    """
    n = len(means)
    tail = stats.norm.sf(SIGMAS)
    return means.std(axis=0, ddof=1) / np.sqrt(n) * stats.t.isf(tail, n - 1) / SIGMAS


def rel_mse(image: np.ndarray, reference: np.ndarray) -> float:
    """mean((x - ref)^2 / (ref^2 + 0.01)) over pixels and channels [Rousselle et al. 2011]."""
    x, ref = image.astype(np.float64), reference.astype(np.float64)
    return float(((x - ref) ** 2 / (ref**2 + 0.01)).mean())


def mean_ratio(image: np.ndarray, reference: np.ndarray) -> float:
    """Ratio of the mean luminances."""
    weights = np.array([0.2126, 0.7152, 0.0722])
    theirs = float(reference.reshape(-1, 3).astype(np.float64).mean(axis=0) @ weights)
    ours = float(image.reshape(-1, 3).astype(np.float64).mean(axis=0) @ weights)
    return ours / theirs if theirs else (1.0 if ours == 0.0 else float("inf"))


def compare_blocks(
    ours: np.ndarray, theirs: np.ndarray, se_theirs: np.ndarray, tolerance: float = 0.01,
    se_ours: np.ndarray | None = None, size: int = BLOCK,
) -> BlockReport:
    """Compare block means: a difference counts when beyond `tolerance` of the reference plus SIGMAS standard errors.

    ours, theirs : (h, w, 3);  se_theirs : (h, w, 3) per pixel;  se_ours : of the *blocks* of ours (photons are
    shared by neighbouring pixels, so per-pixel errors do not add up: see `batch_block_errors`), or None.
    A block whose standard error is above MAX_NOISE times the tolerance has no verdict, unless it is out all the same.
    """
    if ours.shape != theirs.shape:
        raise ValueError(f"pictures of different sizes: {ours.shape} and {theirs.shape}")
    if not np.isfinite(ours).all():
        raise ValueError(f"{np.count_nonzero(~np.isfinite(ours))} values of ours are not finite")
    a, b = block_means(ours, size), block_means(theirs, size)
    se = block_errors(se_theirs, size)
    if se_ours is not None:
        se = np.hypot(se, se_ours)
    allowed = tolerance * np.abs(b) + FLOOR * b.mean()
    out, unconverged = [], []
    for row, column, channel in np.ndindex(a.shape):
        at = (row, column, channel)
        block = Block(row, column, channel, float(a[at]), float(b[at]), float(se[at]))
        if abs(a[at] - b[at]) > allowed[at] + SIGMAS * se[at]:
            out.append(block)
        elif se[at] > MAX_NOISE * allowed[at]:
            unconverged.append(block)
    total = float(b.sum())
    judged = 1.0 - sum(block.theirs for block in unconverged) / total if total else 1.0
    return BlockReport(out, unconverged, a.size, mean_ratio(ours, theirs), rel_mse(ours, theirs), judged)
