"""One damaged file after another in a process that may die of it."""

from __future__ import annotations

import faulthandler
from collections.abc import Callable
from pathlib import Path

import numpy as np

Mutate = Callable[[bytes, np.random.Generator], tuple[str, bytes]]


def try_each(base: Path, numbers: range, seed: int, mutate: Mutate, answer: Callable[[bytes], str], patience: float):
    """Print what was done to each mutant and, after "= ", the answer; one may take `patience` [s]."""
    content = base.read_bytes()
    for i in numbers:
        what, data = mutate(content, np.random.default_rng([seed, i]))
        print(f"{i} {what}", flush=True)
        faulthandler.dump_traceback_later(patience, exit=True)
        said = answer(data)
        faulthandler.cancel_dump_traceback_later()
        print(f"= {said}", flush=True)
