"""A render told to a terminal or a log file, and Ctrl-C."""

from __future__ import annotations

import logging
import signal
import sys
import time
from contextlib import contextmanager
from typing import TextIO

from .listener import Listener, Progress

PLAIN_INTERVAL = 5.0  # [s] between progress lines where no terminal can overwrite them


class Console(Listener):
    """Progress on one line of a terminal, or as plain lines; cancelled by Ctrl-C."""

    def __init__(self, stream: TextIO | None = None, quiet: bool = False) -> None:
        self.stream = stream or sys.stderr
        self.quiet = quiet
        self.terminal = self.stream.isatty()
        self.interrupted = False
        self._line = ""  # what stands on the terminal's last line
        self._last = float("-inf")

    def cancelled(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self.interrupted

    def stage(self, text: str) -> None:
        """Show the stage; passes tell of themselves when done."""
        if not text.startswith("Pass "):
            self._show(f"{text} ...", always=True)

    def progress(self, progress: Progress) -> None:
        """Show where the render is."""
        self._show(str(progress), always=progress.fraction >= 1.0 or progress.passes == 1)

    def say(self, text: str) -> None:
        """A line that stays."""
        self._clear()
        self.stream.write(f"{text}\n")
        self.stream.flush()

    def close(self) -> None:
        """End the progress line."""
        if self.terminal and self._line:
            self.stream.write("\n")
        self._line = ""
        self.stream.flush()

    def _show(self, text: str, always: bool) -> None:
        """Overwrite the progress line, or print a line where that cannot be."""
        if self.quiet:
            return
        if self.terminal:
            self.stream.write("\r" + text.ljust(len(self._line)))
            self._line = text
        elif always or time.monotonic() - self._last >= PLAIN_INTERVAL:
            self.stream.write(f"{text}\n")
            self._last = time.monotonic()
        self.stream.flush()

    def _clear(self) -> None:
        """Empty the progress line."""
        if self.terminal and self._line:
            self.stream.write("\r" + " " * len(self._line) + "\r")
        self._line = ""


class ConsoleHandler(logging.Handler):
    """Issues as lines above the progress line."""

    def __init__(self, console: Console) -> None:
        super().__init__(logging.WARNING)
        self.console = console

    def emit(self, record: logging.LogRecord) -> None:
        """Print one issue."""
        self.console.say(f"{record.levelname.lower()}: {record.getMessage()}")


@contextmanager
def interruptible(console: Console):
    """Within: the first Ctrl-C (or SIGTERM) asks the render to stop and keep its passes, the second breaks it off."""

    def on_signal(number: int, _frame: object) -> None:
        if console.interrupted:
            raise KeyboardInterrupt
        console.interrupted = True
        console.say("stopping, what is rendered is kept (again to break off)")

    before = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
