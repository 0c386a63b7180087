import pickle
import threading
import time

import pytest

from ...film.output import OutputError
from ...issues import IssueLog, RenderError, StopReason
from ...jit import compiled_functions, is_compiling
from ...settings import Settings
from ..listener import Listener
from ..session import Session
from ..worker import GRACE, Abandoned, Worker
from .fake import FakeRenderer, triangle_scene

STUCK = 20.0  # [s] of work in one piece, ended by the test


class Stages(Listener):
    """Keeps what it hears, with the thread that told it; cancels when asked to."""

    def __init__(self):
        self.stages, self.threads, self.stop = [], set(), False

    def cancelled(self):
        self.threads.add(threading.current_thread())
        return self.stop

    def stage(self, text):
        self.threads.add(threading.current_thread())
        self.stages.append(text)


def test_result_and_exception_come_back():
    worker = Worker(Listener())
    assert worker.call(lambda: 7) == 7
    with pytest.raises(ZeroDivisionError):
        worker.call(lambda: 1 / 0)
    assert not worker.abandoned


class Stuck(FakeRenderer):
    """Works in one piece, and heeds no cancel, in one place."""

    where = ""
    free = threading.Event()
    gone = threading.Event()

    def __init__(self, *arguments):
        self.hang("init")
        super().__init__(*arguments)

    def hang(self, place):
        if place == self.where:
            self.free.wait(STUCK)

    def prepare(self, stage, cancelled):
        super().prepare(stage, cancelled)
        self.hang("prepare")

    def render_pass(self, i, cancelled):
        if i == 2:
            self.hang("pass")
        return super().render_pass(i, cancelled)

    def close(self):
        self.gone.set()


@pytest.mark.parametrize(("where", "passes"), [("init", 0), ("prepare", 0), ("pass", 2)])
def test_work_in_one_piece_is_left_to_itself_after_a_cancel(where, passes):
    kind = type("Kind", (Stuck,), {"where": where, "free": threading.Event(), "gone": threading.Event()})
    listener = Stages()
    threading.Timer(0.3, lambda: setattr(listener, "stop", True)).start()
    session = Session(triangle_scene(), Settings(passes=9), IssueLog(), kind)
    begin = time.monotonic()
    assert session.render(listener) is StopReason.CANCELLED
    took = time.monotonic() - begin
    assert session.film.count == passes  # what was finished is kept
    assert 0.3 + GRACE <= took < STUCK / 2.0  # the bound is loose for a busy machine; idle it takes 0.85 s
    assert listener.threads == {threading.current_thread()}  # a host hears from nobody else
    assert not kind.gone.is_set()
    kind.free.set()
    assert where == "init" or kind.gone.wait(STUCK)  # closed when the work ends


def test_what_is_broken_off_by_hand_is_abandoned_too():
    class Interrupted(Listener):
        def cancelled(self):
            raise KeyboardInterrupt

    free, worker = threading.Event(), Worker(Interrupted())
    with pytest.raises(KeyboardInterrupt):
        worker.call(lambda: free.wait(STUCK))
    assert worker.abandoned
    free.set()


def test_abandoned_is_raised_once_the_grace_is_over():
    listener, free = Stages(), threading.Event()
    listener.stop = True
    with pytest.raises(Abandoned):
        Worker(listener).call(lambda: free.wait(STUCK))
    free.set()


def test_compiling_is_told():
    import numba

    jit = numba.njit  # noqa: TID251  our own would keep the result in the cache

    @jit
    def slow(x):  # takes about 0.1 s to compile
        return [x + i for i in range(int(x))]

    @jit
    def slower(x):
        return sum(slow(x)) + sum(slow(x + 1))

    listener = Stages()
    before = compiled_functions()
    watch = []
    worker = Worker(listener)
    worker._told = float("-inf")
    worker.call(lambda: (watch.append(is_compiling()), slower(3.0), watch.append(is_compiling())))
    assert compiled_functions() - before >= 2 and watch == [False, False]
    assert any("Compiling (first run)" in text for text in listener.stages)


@pytest.mark.parametrize("kind", [RenderError, OutputError])
def test_errors_survive_a_pickle(kind):
    error = pickle.loads(pickle.dumps(kind("Lamp", "is broken", "mend it")))
    assert type(error) is kind and error.issue == kind("Lamp", "is broken", "mend it").issue
