"""Results of the last render, for the next one: made anew only where what they are made from is not the same.

What goes in is compared, by identity first and by value then, so that nobody has to tell what changed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..issues import IssueLog

T = TypeVar("T")


class _Held(NamedTuple):
    """A result, what it was made from, and what was said while it was made."""

    inputs: Any
    result: Any
    issues: IssueLog


class Memo:
    """Results by name. Nothing that went in, or came out, may be changed in place afterwards."""

    def __init__(self) -> None:
        self.made: Counter[Hashable] = Counter()  # how often each was made
        self._held: dict[Hashable, _Held] = {}
        self._used: set[Hashable] = set()

    def get(self, name: Hashable, inputs: tuple, make: Callable[[IssueLog], T], issues: IssueLog) -> T:
        """What make(issues) gives; the last such result if the same inputs went in, its issues told again.

        inputs : all that `make` reads; lists whose items may be exchanged as tuples of these items
        """
        self._used.add(name)
        held = self._held.get(name)
        if held is None or not same(inputs, held.inputs):
            own = IssueLog()
            try:
                held = _Held(inputs, make(own), own)
            finally:
                issues.extend(own)
            self.made[name] += 1
        issues.extend(held.issues)
        self._held[name] = held._replace(inputs=inputs)  # the newest arrays: identity is found at once next time
        return held.result

    def drop_unused(self) -> None:
        """Forget the results that nobody asked for since the last call."""
        self._held = {name: held for name, held in self._held.items() if name in self._used}
        self._used = set()


def same(a: Any, b: Any) -> bool:
    """Whether two values are equal for certain: arrays by their type and items, records by their fields.

    What is neither is asked; NaN equals nothing but itself as an object.
    """
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(value, b[key]) for key, value in a.items())
    if is_dataclass(a):
        return all(same(getattr(a, item.name), getattr(b, item.name)) for item in fields(a))
    return bool(a == b)
