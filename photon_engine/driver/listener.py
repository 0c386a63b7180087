"""What the progressive loop tells whoever started it, and how long it thinks it has to go."""

from __future__ import annotations

import math
import statistics
import sys
from typing import NamedTuple

RATE_WINDOW = 9  # passes whose median gives the rate: one slow pass (another program, a first call) does not move it


class Progress(NamedTuple):
    """Where a render is."""

    passes: int  # done in this session
    passes_total: int  # 0: no limit
    seconds: float  # since the first pass began
    seconds_left: float | None  # None: no limit, or nothing known yet
    fraction: float  # done of the budget, in [0, 1]
    memory: float  # of the process now [MB]
    memory_peak: float  # [MB]
    error: float | None = None  # relative, of the picture and share of pixels in the settings; None: not known yet
    target: float = 0.0  # of the error; 0: none

    def __str__(self) -> str:
        """One line for people."""
        total = f"/{self.passes_total}" if self.passes_total else ""
        left = f" | Left {clock(self.seconds_left)}" if self.seconds_left is not None else ""
        error = f" | Error {percent(self.error)}" if self.error is not None else ""
        target = f" > {percent(self.target)}" if error and self.target else ""
        return f"Pass {self.passes}{total} | Time {clock(self.seconds)}{left}{error}{target} | Mem {self.memory:.0f}M"


class Listener:
    """Hears of a render; every method may be left out."""

    def cancelled(self) -> bool:
        """Whether to stop now; asked several times a second, from the thread that renders."""
        return False

    def stage(self, text: str) -> None:
        """A stage begins: "Building the tree", "Pass 3"."""

    def progress(self, progress: Progress) -> None:
        """A pass is done."""

    def picture(self, darkroom, final: bool) -> None:
        """The film holds one more pass; `final` after the last, and after a cancel that kept something.

        darkroom : film.darkroom.Darkroom, which makes pictures of the film when asked
        """


def percent(part: float) -> str:
    """A part of one as 0.25%, 3.1% or 120%: two digits that count."""
    digits = max(0, 1 - math.floor(math.log10(max(100.0 * part, 1e-3))))
    return f"{100.0 * part:.{digits}f}%"


def clock(seconds: float) -> str:
    """Seconds as 07.5s, 1:05 or 1:02:33."""
    if seconds < 60.0:
        return f"{seconds:.1f}s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def seconds_left(durations: list[float], passes: int, seconds: float) -> float | None:
    """Time until the first limit is met.

    durations : of the passes done [s];  passes : how many there shall be, 0: no limit;  seconds : for all, 0: no limit
    The rate is the median of the last passes: later passes gather in smaller radii and are faster than the first ones.
    """
    limits = []
    if passes and durations:
        limits.append((passes - len(durations)) * statistics.median(durations[-RATE_WINDOW:]))
    if seconds:
        limits.append(seconds - sum(durations))
    return max(min(limits), 0.0) if limits else None


def memory() -> tuple[float, float]:
    """Resident memory of this process, now and at its peak [MB]; zeros where the system does not say."""
    try:
        import resource
    except ImportError:  # Windows
        return 0.0, 0.0
    unit = 2**20 if sys.platform == "darwin" else 2**10
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * resource.getpagesize() / 2**20, peak
    except OSError:
        return peak, peak
