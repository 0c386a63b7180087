"""The renderer in a thread of its own, so that a cancel is heard whatever it is doing.

Some work is in one piece: compiling a kernel, building Embree's tree, reading a large texture. Whoever started the
render waits here instead and asks twenty times a second whether to stop. Work that does not stop soon is left to end by
itself; nothing of it is used. The renderer never calls the listener from its threads: a host may be gone by then.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from typing import Any

from .listener import Listener

POLL = 0.05  # [s] between questions whether to stop
GRACE = 0.5  # [s] that work has to end by itself after a cancel; it is abandoned then
TELL = 5.0  # [s] between words on the progress of compiling


class Abandoned(Exception):
    """The work was cancelled and goes on without us."""


class Worker:
    """Calls functions one after the other, each in a thread, and asks the listener meanwhile."""

    def __init__(self, listener: Listener) -> None:
        self.listener = listener
        self.stop = threading.Event()  # set by a cancel; what the work should look at
        self.on_late_end: Callable[[], None] | None = None  # called when abandoned work ends at last
        self.abandoned = False
        self._deadline = float("inf")
        self._stages: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._told = float("-inf")  # when compiling was last mentioned
        self._lock = threading.Lock()

    def stage(self, text: str) -> None:
        """What is being done, from the thread that does it."""
        self._stages.put(text)

    def call(self, function: Callable[[], Any]) -> Any:
        """The function's result, or its exception; Abandoned after a cancel that it did not heed in time."""
        job = _Job(function, self._lock)
        try:
            self._ask()
            job.thread.start()
            while not job.done.wait(POLL):
                self._tell()
                self._ask()
                if time.monotonic() > self._deadline:
                    raise Abandoned
        except BaseException:  # also a KeyboardInterrupt while waiting
            self.abandoned = True
            job.abandon(self.on_late_end)
            raise
        self._tell()
        if job.error is not None:
            raise job.error
        return job.result

    def _ask(self) -> None:
        """Hear a cancel."""
        if not self.stop.is_set() and self.listener.cancelled():
            self.stop.set()
            self._deadline = time.monotonic() + GRACE

    def _tell(self) -> None:
        """Pass on what the work says it does, and that kernels are being compiled."""
        while not self._stages.empty():
            self.listener.stage(self._stages.get())
            self._told = float("-inf")
        from ..jit import compiled_functions, is_compiling  # here: who only enables the extension needs no numba

        now = time.monotonic()
        if is_compiling() and now - self._told > TELL:
            self.listener.stage(f"Compiling (first run), {compiled_functions()} functions done")
            self._told = now


class _Job:
    """One call in its thread. A daemon: an abandoned one must not keep the process."""

    def __init__(self, function: Callable[[], Any], lock: threading.Lock) -> None:
        self.done = threading.Event()
        self.result: Any = None
        self.error: BaseException | None = None
        self._late: Callable[[], None] | None = None
        self._function = function
        self._lock = lock
        self.thread = threading.Thread(target=self._run, name="photon-map-render", daemon=True)

    def _run(self) -> None:
        try:
            self.result = self._function()
        except BaseException as error:
            self.error = error
        with self._lock:
            self.done.set()
            late = self._late
        if late is not None:
            late()

    def abandon(self, late: Callable[[], None] | None) -> None:
        """Nobody waits any more; `late` is called when the work ends, at once when it has."""
        with self._lock:
            self._late = late
            ended = self.done.is_set()
        if ended and late is not None:
            late()
