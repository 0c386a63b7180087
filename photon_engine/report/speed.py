"""How much sooner we are as right as Cycles: time to equal relMSE, raw against raw and denoised against denoised."""

from __future__ import annotations

import math
from itertools import groupby, pairwise, product
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from .runs import CYCLES, CYCLES_DENOISED, OURS, OURS_DENOISED

PAIRS = {"raw": (OURS, CYCLES), "denoised": (OURS_DENOISED, CYCLES_DENOISED)}
LEAST_ERROR = 1e-9  # of a picture that is equal to its reference
BOUNDS = {"=": "", ">": "at least ", "<": "at most "}
FIGURES = ("relMSE", "relMSE999")

Curve = list[tuple[float, float]]  # (seconds, error), ascending


class Comparison(NamedTuple):
    """Two engines over the same scene."""

    pictures: str  # raw or denoised
    figure: str  # one of FIGURES: what the errors are
    clock: str  # "seconds", or "cpu_seconds" of all threads
    times: float  # how many times more of them Cycles takes to our error
    bound: str  # "=", or ">": at least so many, since it never got there; "<": at most, since it began there
    stays: float  # least error of Cycles
    error_ratio: float  # its error by ours after equal time, median over our points; path tracing's falls as 1 / time

    def __str__(self) -> str:
        """For people."""
        clock = "seconds" if self.clock == "seconds" else "processor seconds"
        stays = f", Cycles stays at {self.stays:.2g}" if self.bound == ">" else ""
        times = f"{BOUNDS[self.bound]}{self.times:.2g} times faster"
        return (
            f"{self.pictures}: {times} to equal {self.figure} in {clock}{stays}; "
            f"after equal time that of Cycles is {self.error_ratio:.2g} times ours"
        )


def medians(points: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One point for each engine, picture and asked time, whose figures are medians over repeated runs."""
    order = list(dict.fromkeys(_key(point) for point in points))
    found = []
    for _, group in groupby(sorted(points, key=lambda point: order.index(_key(point))), key=_key):
        runs = list(group)
        numbers = [name for name, value in runs[0].items() if isinstance(value, float)]
        found.append(runs[0] | {name: median(run[name] for run in runs) for name in numbers})
    return found


def _key(point: dict[str, Any]) -> tuple[float, str, str]:
    """What repeated runs share."""
    return point["asked_seconds"], point["engine"], point["part"]


def compare(points: list[dict[str, Any]]) -> list[Comparison]:
    """Ours against Cycles on Combined, by each figure, by the clock and by the processor's time."""
    found = []
    for (pictures, (ours, theirs)), figure, clock in product(PAIRS.items(), FIGURES, ("seconds", "cpu_seconds")):
        curves = [curve(points, engine, clock, figure) for engine in (ours, theirs)]
        if all(curves):
            found.append(Comparison(pictures, figure, clock, *faster(*curves), error_ratio(*curves)))
    return found


def curve(points: list[dict[str, Any]], engine: str, clock: str, figure: str = "relMSE") -> Curve:
    """(seconds, error of Combined) of an engine, ascending in time; an error once reached is kept."""
    mine = [point for point in points if (point["engine"], point["part"]) == (engine, "Combined")]
    line = sorted((point[clock], point[figure]) for point in mine if point[clock] > 0.0)
    least = np.minimum.accumulate([max(error, LEAST_ERROR) for _, error in line]) if line else []
    return [(seconds, float(error)) for (seconds, _), error in zip(line, least, strict=True)]


def faster(ours: Curve, theirs: Curve) -> tuple[float, str, float]:
    """How many times more seconds theirs takes to the errors of ours: (times, bound, least error of theirs).

    The median over our points whose error lies within theirs, between which error falls as a power of time. Where there
    is none: a lower bound if they never get to our first error, else an upper one.
    """
    inside = [time_to(theirs, error) / seconds for seconds, error in ours if theirs[-1][1] <= error <= theirs[0][1]]
    stays = theirs[-1][1]
    if inside:
        return median(inside), "=", stays
    better = [theirs[-1][0] / seconds for seconds, error in ours if error < stays]
    if better:
        return max(better), ">", stays
    return min(theirs[0][0] / seconds for seconds, _ in ours), "<", stays


def time_to(line: Curve, error: float) -> float:
    """When a curve comes to an error within its range."""
    for (t0, e0), (t1, e1) in pairwise(line):
        if e1 <= error <= e0 and e1 < e0:
            return t0 * (t1 / t0) ** (math.log(error / e0) / math.log(e1 / e0))
    return line[0][0]


def error_ratio(ours: Curve, theirs: Curve) -> float:
    """Error of theirs by error of ours at equal time, median over our points within their times (or all)."""
    x, y = np.log(np.array(theirs)).T
    within = [(t, e) for t, e in ours if theirs[0][0] <= t <= theirs[-1][0]] or ours
    return median(float(np.exp(np.interp(math.log(t), x, y))) / e for t, e in within)
