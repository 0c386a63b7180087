"""The curve of the error, the target, and when it will be met."""

import itertools
import json

import numpy as np
import pytest

from ...film.accumulate import Film
from ...film.error import PassError
from ...film.passes import RAW
from ...issues import IssueLog, StopReason
from ...settings import Settings
from ..listener import Progress, percent
from ..log import run_record, write_json
from ..session import Session
from ..watch import ErrorWatch, is_due
from .fake import FakeRenderer, triangle_scene
from .test_session import Recorder, session_of


def test_when_it_is_measured():
    due = [n for n in range(100) if is_due(n)]
    assert due[:9] == [2, 3, 4, 5, 6, 7, 8, 9, 10] and due[15:20] == [18, 20, 22, 24, 26]
    assert all(b / a <= 1.15 for a, b in itertools.pairwise(due[8:]))


def test_every_render_has_a_curve():
    session = session_of(passes=11)
    session.render()
    assert [mark.passes for mark in session.watch.curve] == [2, 4, 8, 11]
    errors = session.watch.curve[-1].errors
    # uniform numbers in [0, 1] over 11 passes: 12^(-1/2) / 11^(1/2) of a mean of 0.5
    assert errors["Direct"].noise == pytest.approx(0.174, rel=0.1)
    assert errors["Combined"].noise == pytest.approx(0.174 / 5**0.5, rel=0.1)
    assert session.stages["Measuring the error"] > 0.0


def film_of(passes, sigma):
    """A film of Direct = 1 with noise."""
    film = Film(32, 32)
    rng = np.random.default_rng(0)
    for i in range(passes):
        image = {name: np.zeros((32, 32, c), np.float32) for name, c in RAW.items()}
        image["Direct"][:] = 1.0 + sigma * rng.standard_normal((32, 32, 3))
        film.add(i, image)
    return film


def test_error_stops_the_render_after_as_many_passes_as_it_takes():
    """Noise of 0.577 / n^(1/2) in each pass, of Combined 1 / 5^(1/2) as much; 68% of pixels within one sigma."""
    stops = {}
    for name in ("COMBINED", "DIRECT"):
        session, heard = session_of(passes=0, error=0.1, error_share=0.6827, error_pass=name), Recorder()
        assert session.render(heard) is StopReason.ERROR
        assert session.watch.error <= 0.1 < heard.heard[-2].error
        assert heard.heard[-1].fraction == 1.0 and heard.heard[-1].target == 0.1
        stops[name] = session.film.count
    assert 6 <= stops["COMBINED"] <= 9 and 29 <= stops["DIRECT"] <= 38  # 6.7 and 33.3, measured at steps


def test_passes_and_seconds_still_stop_it():
    assert session_of(passes=3, error=1e-6).render() is StopReason.PASSES
    assert session_of(passes=0, seconds=1e-9, error=1e-6).render() is StopReason.SECONDS


def test_time_left_follows_the_fitted_rate():
    """Error 0.4 / s^(1/2): 0.1 is met after 16 s; by an error that hardly falls, much later."""
    watch = ErrorWatch(Settings(error=0.1))
    assert watch.seconds_left(0.0) is None and not watch.met()
    watch.found = [(n, n / 2, PassError(0, 0, 0, 0.4 / (n / 2) ** 0.5)) for n in range(2, 9)]
    assert watch.seconds_left(4.0) == pytest.approx(12.0, rel=1e-6)
    assert watch.fraction(4.0) == pytest.approx(0.25)
    watch.found = [(n, n / 2, PassError(0, 0, 0, 0.4 / (n / 2) ** 0.25)) for n in range(2, 9)]
    assert watch.seconds_left(4.0) == pytest.approx(252.0, rel=1e-6)
    assert ErrorWatch(Settings()).seconds_left(4.0) is None


def test_two_points_are_taken_for_noise():
    watch = ErrorWatch(Settings(error=0.1))
    watch.found = [(2, 1.0, PassError(0, 0, 0, 0.2)), (3, 1.5, PassError(0, 0, 0, 0.2))]
    assert watch.seconds_left(1.5) == pytest.approx(4.5)


def test_named_pass_and_share_are_measured():
    film = film_of(4, 0.2)
    few, many = (ErrorWatch(Settings(error=0.1, error_pass="DIRECT", error_share=share)) for share in (0.5, 0.99))
    few.measure_all(film, 1.0)
    many.measure_all(film, 1.0)
    assert few.error == pytest.approx(0.0674, rel=0.05) and many.error == pytest.approx(0.2576, rel=0.05)
    assert few.met() and not many.met()


def test_status_line_shows_error_and_target():
    progress = Progress(3, 0, 2.0, 61.0, 0.5, 100.0, 120.0, 0.0312, 0.01)
    assert str(progress) == "Pass 3 | Time 2.0s | Left 1:01 | Error 3.1% > 1.0% | Mem 100M"
    assert [percent(x) for x in (0.0, 0.00123, 0.0456, 0.5, 1.234)] == ["0.0000%", "0.12%", "4.6%", "50%", "123%"]


def test_log_holds_curve_radii_and_reason(tmp_path):
    class WithRadii(FakeRenderer):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            self.statistics["radii"] = {"caustic": [[0, 2.0, 0.1]]}

    session = Session(triangle_scene(), Settings(passes=2), IssueLog(), WithRadii)
    session.render()
    write_json(tmp_path / "run.json", run_record(session))
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["radii"] == {"caustic": [[0, 2.0, 0.1]]} and record["stop"] == "the requested passes are done"
    (mark,) = record["error_curve"]
    assert mark["passes"] == 2 and set(mark["errors"]["Combined"]) == {"noise", "bias", "error", "at_share"}
