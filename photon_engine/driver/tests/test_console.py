import io
import logging
import os
import signal

import pytest

from ..console import Console, ConsoleHandler, interruptible
from ..listener import Progress, clock, seconds_left


class Terminal(io.StringIO):
    def isatty(self):
        return True


def progress(done, total=10):
    return Progress(done, total, 2.0 * done, 2.0 * (total - done), done / total, 100.0, 120.0)


def test_plain_lines_are_few():
    console = Console(io.StringIO())
    for done in range(1, 11):
        console.progress(progress(done))
    lines = console.stream.getvalue().splitlines()
    assert lines[0].startswith("Pass 1/10 | Time 2.0s | Left 18.0s") and lines[-1].startswith("Pass 10/10")
    assert len(lines) == 2  # ten passes in no time: the first and the last


def test_terminal_overwrites_and_issues_stay():
    console = Console(Terminal())
    handler = ConsoleHandler(console)
    console.progress(progress(1))
    handler.emit(logging.LogRecord("x", logging.WARNING, "", 0, "Wood: no such node", (), None))
    console.progress(progress(2))
    console.close()
    text = console.stream.getvalue()
    assert text.count("\n") == 2 and "warning: Wood: no such node\n" in text and "\rPass 2/10" in text


def test_quiet_says_only_what_must_be_said():
    console = Console(io.StringIO(), quiet=True)
    console.stage("Building")
    console.progress(progress(1))
    console.say("done")
    assert console.stream.getvalue() == "done\n"


def test_first_interrupt_asks_second_breaks_off():
    console = Console(io.StringIO())
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), interruptible(console):
        os.kill(os.getpid(), signal.SIGINT)
        assert console.cancelled()
        os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_clock():
    assert [clock(s) for s in (0.04, 59.94, 65, 3753)] == ["0.0s", "59.9s", "1:05", "1:02:33"]


def test_seconds_left_follows_the_rate_and_the_nearer_limit():
    assert seconds_left([], 0, 0.0) is None
    assert seconds_left([], 5, 0.0) is None
    assert seconds_left([30.0] + [1.0] * 9, 20, 0.0) == pytest.approx(10.0)  # the slow first pass is forgotten
    assert seconds_left([1.0, 1.0], 20, 5.0) == pytest.approx(3.0)
    assert seconds_left([1.0, 1.0], 3, 5.0) == pytest.approx(1.0)
    assert seconds_left([9.0], 20, 5.0) == 0.0
