"""Time and state: cancelled anywhere, hardly any time, very many passes, settings at the ends of their ranges."""

from __future__ import annotations

import copy
import time

import numpy as np

from photon_engine.driver.listener import Listener
from photon_engine.driver.session import Session
from photon_engine.film.accumulate import Film
from photon_engine.film.passes import RAW
from photon_engine.issues import IssueLog, RenderError, StopReason
from photon_engine.settings import FIELDS, Settings

from .lab import SMALL, Finding, case
from .transforms import plain

PATIENCE = 3.0  # [s] for a cancel: 0.6 on an idle machine


class Ear(Listener):
    """Cancels at a stage, or after some seconds, and tells how long it took until the end."""

    def __init__(self, stage: int = -1, seconds: float = np.inf) -> None:
        self.texts: list[str] = []
        self.at, self.until, self.since = stage, time.monotonic() + seconds, 0.0

    def cancelled(self) -> bool:
        now = 0 <= self.at < len(self.texts) or time.monotonic() > self.until
        if now and not self.since:
            self.since = time.monotonic()
        return bool(self.since)

    def stage(self, text: str) -> None:
        self.texts.append(text)


def session(scene=None, **changes) -> Session:
    """Of the plain room, small."""
    scene = scene or plain()
    scene.frame.x1 = scene.frame.y1 = scene.frame.width = scene.frame.height = 16
    return Session(scene, Settings(**{**SMALL, "passes": 3, **changes}), IssueLog())


@case("time and state", "cancelled at every stage", f"ends within {PATIENCE:g} s, with the passes done so far")
def cancelled_anywhere() -> Finding:
    whole, start = Ear(), time.process_time()
    session().render(whole)
    worst, wrong = 0.0, []
    for i, text in enumerate(whole.texts):
        ear, run = Ear(i), session()
        stop = run.render(ear)
        worst = max(worst, time.monotonic() - ear.since)
        done = sum(word.startswith("Pass ") for word in whole.texts[: i + 1]) - 1
        kept = run.film.count in (max(done, 0), done + 1)  # a pass may end just before it hears
        if stop is not StopReason.CANCELLED or not kept or not np.isfinite(run.film.picture("Combined")).all():
            wrong.append(text)
    figure = f"{len(whole.texts)} stages, the slowest {worst:.2f} s{', wrong: ' + ', '.join(wrong) if wrong else ''}"
    return Finding(worst < PATIENCE and not wrong, figure, time.process_time() - start)


@case("time and state", "0.1 s in all", "one pass at least, and no more than the budget and one pass", short=True)
def hardly_any_time() -> Finding:
    run, start = session(passes=0, seconds=0.1), time.process_time()
    stop = run.render()
    spent, longest = sum(run.durations), max(run.durations)
    good = stop is StopReason.SECONDS and run.film.count >= 1 and spent <= 0.1 + longest
    return Finding(good, f"{run.film.count} passes in {spent:.2f} s", time.process_time() - start)


@case("time and state", "a million passes of 1e6 with deviation 1e-3", "variance right to 1e-3", short=True)
def million_passes() -> Finding:
    """A steady light of 1e6 and noise of 1e-3: 1000 passes one by one, doubled ten times by merging, 1000 more."""
    rng, start = np.random.default_rng(1), time.process_time()
    noise = (1e-3 * rng.standard_normal((2000, 4, 4, 3))).astype(np.float32)
    blank = {name: np.zeros((4, 4, c), np.float32) for name, c in RAW.items()}
    blank["Emission"][:] = 1e6
    film = Film(4, 4)
    for i in range(1000):
        film.add(i, blank | {"Caustic": noise[i]})
    for k in range(10):
        other = copy.deepcopy(film)
        n = film.count
        other.blocks = [(0, n, 2 * n)]
        film.merge(other)
        assert film.count == 1000 << (k + 1)
    for i in range(1000, 2000):
        film.add(film.next_pass, blank | {"Caustic": noise[i]})
    x = noise.astype(np.float64)
    n, a, b = film.count, 1024 * x[:1000].sum(axis=0), x[1000:].sum(axis=0)
    mean = (a + b) / n
    expected = (1024 * ((x[:1000] - mean) ** 2).sum(axis=0) + ((x[1000:] - mean) ** 2).sum(axis=0)) / (n - 1)
    off = float(np.abs(film.variance("Combined") / expected - 1.0).max())
    seconds = time.process_time() - start
    return Finding(off < 1e-3, f"off by {off:.1e} after {n} passes", seconds)


def ends() -> list[tuple[str, object]]:
    """Every setting with both ends of its range, or each choice."""
    out = []
    for name, item in FIELDS.items():
        meta = item.metadata
        if "items" in meta:
            out += [(name, entry[0]) for entry in meta["items"]]
        elif isinstance(item.default, bool):
            out += [(name, False), (name, True)]
        else:
            out += [(name, meta["min"]), (name, meta["max"])]
    return out


@case("time and state", "settings at both ends of every range", "a finite picture, or kept after a cancel, or told")
def ends_of_ranges() -> Finding:
    start, wrong, answers = time.process_time(), [], {"done": 0, "cancelled": 0, "told": 0}
    for name, value in ends():
        run, ear = session(**({"passes": 1} | {name: value})), Ear(seconds=4.0)
        try:
            stop = run.render(ear)
        except RenderError:
            answers["told"] += 1
            continue
        late = ear.since and time.monotonic() - ear.since > PATIENCE
        if late or not np.isfinite(run.film.picture("Combined")).all():
            wrong.append(f"{name}={value}")
        answers["cancelled" if stop is StopReason.CANCELLED else "done"] += 1
    figure = ", ".join(f"{count} {word}" for word, count in answers.items()) + (f"; wrong: {wrong}" if wrong else "")
    return Finding(not wrong, figure, time.process_time() - start)
