"""Where the time of work that several threads share goes."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager


class Clock:
    """Seconds by name, summed over threads. Each thread adds to entries of its own: no lock.

    What is counted within another count is not counted there.
    """

    def __init__(self) -> None:
        self._spent: dict[tuple[int, str], float] = defaultdict(float)
        self._inner: dict[int, float] = defaultdict(float)  # seconds of finished counts in the one that runs

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Count what happens within under a name."""
        thread = threading.get_ident()
        outer, self._inner[thread] = self._inner[thread], 0.0
        begin = time.perf_counter()
        try:
            yield
        finally:
            passed = time.perf_counter() - begin
            self._spent[thread, name] += passed - self._inner[thread]
            self._inner[thread] = outer + passed

    def split(self, seconds: float) -> dict[str, float]:
        """So many seconds of wall time, divided between the names as the threads' time was."""
        spent: dict[str, float] = defaultdict(float)
        for (_, name), part in list(self._spent.items()):
            spent[name] += part
        total = sum(spent.values())
        return {name: seconds * part / total for name, part in spent.items()} if total else {}
