"""The error of a render while it runs: its curve against passes and seconds, whether it is small enough, and when."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..film.accumulate import Film
from ..film.error import CONFIDENCE, ERROR_NAMES, PassError, picture_error
from ..settings import Settings

EVERY_PASS = 8  # the first passes are measured one by one, later ones when an eighth more is done
FEWEST_TO_FIT = 3  # points of the curve that show a rate
SLOWEST, FASTEST = -0.05, -0.6  # exponents of error against seconds that are believed; noise alone has -1/2
NO_RATE = -0.5


class Mark(NamedTuple):
    """The errors of all pictures after some passes."""

    passes: int  # in the film
    seconds: float  # spent on them
    errors: dict[str, PassError]  # by the names in film.error.ERROR_NAMES

    def record(self) -> dict[str, Any]:
        """As plain values."""
        errors = {name: error.rounded() for name, error in self.errors.items()}
        return {"passes": self.passes, "seconds": round(self.seconds, 4), "errors": errors}


def measured(film: Film, seconds: float, share: float = CONFIDENCE) -> Mark:
    """The errors of all pictures of a film."""
    return Mark(film.count, seconds, {name: picture_error(film, name, share) for name in ERROR_NAMES})


class ErrorWatch:
    """Measures the film now and then and keeps the curve.

    When it measures depends on the number of passes alone, so that a target is met after the same pass on any machine.
    """

    def __init__(self, settings: Settings) -> None:
        self.target = settings.error
        self.share = settings.error_share
        self.name = settings.error_pass.capitalize()
        self.curve: list[Mark] = []  # after 2, 4, 8, ... passes, and the last
        self.found: list[tuple[int, float, PassError]] = []  # (passes, seconds, error) of the picture asked about

    def measure(self, film: Film, seconds: float) -> None:
        """Look at the film after one more pass, if it is time to."""
        if film.count & (film.count - 1) == 0 and film.count > 1:
            self.measure_all(film, seconds)
        elif is_due(film.count):
            self.found.append((film.count, seconds, picture_error(film, self.name, self.share)))

    def measure_all(self, film: Film, seconds: float) -> None:
        """Measure all pictures, if that was not just done."""
        if film.count < 2 or not film.measures or (self.curve and self.curve[-1].passes == film.count):
            return
        self.curve.append(measured(film, seconds, self.share))
        self.found.append((film.count, seconds, self.curve[-1].errors[self.name]))

    @property
    def error(self) -> float | None:
        """What the asked share of pixels was last seen to be within, relative; None: not known yet."""
        return self.found[-1][2].at_share if self.found and not math.isnan(self.found[-1][2].at_share) else None

    def met(self) -> bool:
        """Whether a target is set and the error is no larger."""
        return bool(self.target and self.error is not None and self.error <= self.target)

    def seconds_left(self, seconds: float) -> float | None:
        """Time until the target is met by the fitted rate, `seconds` having been spent; None: no target, no rate."""
        if not self.target or not self.error:
            return None
        slope, at, error = self._rate()
        return max(at * (self.target / error) ** (1.0 / slope) - seconds, 0.0)

    def fraction(self, seconds: float) -> float | None:
        """Part of the time to the target that is spent; None where it is not known."""
        left = self.seconds_left(seconds)
        return None if left is None else seconds / max(seconds + left, 1e-9)

    def _rate(self) -> tuple[float, float, float]:
        """Exponent of the error against seconds, and the seconds and error of the fit's last point.

        Least squares on logarithms over the latter half of what was measured.
        """
        points = [(s, e.at_share) for _, s, e in self.found if e.at_share > 0.0 and s > 0.0]
        points = points[len(points) // 2 :] if len(points) >= 2 * FEWEST_TO_FIT else points[-FEWEST_TO_FIT:]
        x, y = [math.log(s) for s, _ in points], [math.log(e) for _, e in points]
        if len(points) < FEWEST_TO_FIT or x[-1] == x[0]:
            return NO_RATE, *points[-1]
        mx, my = sum(x) / len(x), sum(y) / len(y)
        slope = sum((a - mx) * (b - my) for a, b in zip(x, y, strict=True)) / sum((a - mx) ** 2 for a in x)
        slope = min(max(slope, FASTEST), SLOWEST)
        return slope, points[-1][0], math.exp(my + slope * (x[-1] - mx))


def is_due(passes: int) -> bool:
    """Whether the film is measured after so many passes: all of the first, then after each eighth more or so."""
    if passes < 2:
        return False
    octave = max(passes.bit_length() - 1 - EVERY_PASS.bit_length() + 1, 0)
    return passes % (1 << octave) == 0
