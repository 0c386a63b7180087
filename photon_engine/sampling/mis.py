"""Multiple importance sampling weights [Veach 1997, chapter 9]."""

from __future__ import annotations

import math

from ..jit import kernel


@kernel
def power_heuristic(pdf_a, pdf_b):
    """Weight a^2 / (a^2 + b^2) of a sample drawn with density a, when b could have drawn it too [Veach 1997, 9.2.4].

    Both densities in the same measure; an infinite pdf_a (delta) gives 1, an infinite pdf_b gives 0.
    """
    if not pdf_a > 0.0:
        return 0.0
    if math.isinf(pdf_a):
        return 1.0
    ratio = pdf_b / pdf_a
    return 1.0 / (1.0 + ratio * ratio)


@kernel
def balance_heuristic(pdf_a, pdf_b):
    """Weight a / (a + b) [Veach 1997, Eq. 9.8]; same conventions as `power_heuristic`."""
    if not pdf_a > 0.0:
        return 0.0
    if math.isinf(pdf_a):
        return 1.0
    return 1.0 / (1.0 + pdf_b / pdf_a)
