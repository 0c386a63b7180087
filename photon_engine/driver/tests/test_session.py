import json

import numpy as np
import pytest

from ...film.darkroom import Darkroom
from ...film.halves import DenoisedError
from ...issues import IssueLog, RenderError, StopReason
from ...settings import Settings
from ..listener import Listener
from ..log import run_record, write_json
from ..session import Session
from .fake import FakeRenderer, triangle_scene


class Recorder(Listener):
    """Keeps what it hears; cancels after some passes."""

    def __init__(self, cancel_after=None):
        self.cancel_after = cancel_after
        self.heard, self.finals = [], []

    def cancelled(self):
        return self.cancel_after is not None and len(self.heard) >= self.cancel_after

    def progress(self, progress):
        self.heard.append(progress)

    def picture(self, darkroom, final):
        self.finals.append((darkroom.film.count, final))


def session_of(renderer=FakeRenderer, **settings):
    return Session(triangle_scene(), Settings(**settings), IssueLog(), renderer)


def test_passes_are_rendered_and_told():
    session, listener = session_of(passes=3), Recorder()
    assert session.render(listener) is StopReason.PASSES
    assert session.film.blocks == [(0, 0, 3)] and len(session.durations) == 3
    assert listener.finals == [(1, False), (2, False), (3, True)]
    assert [p.fraction for p in listener.heard] == pytest.approx([1 / 3, 2 / 3, 1.0])
    assert listener.heard[-1].seconds_left == 0.0 and listener.heard[-1].memory_peak > 1.0
    assert session.statistics["photons"] == 30 and "Building the tree" in session.stages


def test_seconds_stop_it_but_not_before_one_pass(monkeypatch):
    assert session_of(passes=0, seconds=1e-9).render(Recorder()) is StopReason.SECONDS
    monkeypatch.setenv("PHOTON_MAP_FAKE_SECONDS", "0.03")
    session = session_of(passes=100, seconds=0.1)
    assert session.render() is StopReason.SECONDS
    assert 2 <= session.film.count <= 4  # 4 of 0.03 s or more pass 0.1 s


def test_no_budget_is_refused_unless_someone_watches():
    with pytest.raises(RenderError, match="neither passes nor seconds"):
        session_of(passes=0).render()
    session = session_of(passes=0)
    assert session.render(Recorder(cancel_after=5), endless=True) is StopReason.CANCELLED
    assert session.film.count == 5


def test_cancel_keeps_what_is_rendered():
    session, listener = session_of(passes=10), Recorder(cancel_after=2)
    assert session.render(listener) is StopReason.CANCELLED
    assert session.film.count == 2 and listener.finals[-1] == (2, True)
    whole = session_of(passes=2)
    whole.render()
    np.testing.assert_array_equal(session.film.picture("Combined"), whole.film.picture("Combined"))


def test_cancel_before_the_first_pass_renders_nothing():
    session, listener = session_of(passes=10), Recorder(cancel_after=0)
    assert session.render(listener) is StopReason.CANCELLED
    assert session.film.count == 0 and listener.finals == []


def test_eight_passes_are_four_and_four():
    whole, first, second = session_of(passes=8), session_of(passes=4), session_of(passes=4)
    whole.render()
    first.render()
    second.render(first=4)
    first.film.merge(second.film)
    resumed = session_of(passes=4)
    halfway = session_of(passes=4)
    halfway.render()
    resumed.render(film=halfway.film)
    for name in ("Combined", "Caustic", "Depth"):
        np.testing.assert_array_equal(first.film.picture(name), whole.film.picture(name))
        np.testing.assert_array_equal(resumed.film.picture(name), whole.film.picture(name))


def test_a_film_of_other_settings_is_not_continued():
    session = session_of(passes=1)
    session.render()
    with pytest.raises(RenderError, match=r"caustic_radius 2\.0 and 3\.0"):
        session_of(passes=1, caustic_radius=3.0).render(film=session.film)


def test_an_exception_says_where_closes_and_keeps_the_passes(monkeypatch):
    monkeypatch.setenv("PHOTON_MAP_FAKE_FAIL", "2")
    made = []

    class Kept(FakeRenderer):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            made.append(self)

    session = session_of(Kept, passes=5, seed=7)
    with pytest.raises(ValueError, match="on purpose") as caught:
        session.render()
    assert caught.value.__notes__ == ["while rendering pass 2 of seed 7"]
    assert session.film.count == 2 and made[0].closed


def test_record_is_json_and_enough_to_repeat(tmp_path):
    session = session_of(passes=2, seed=4, caustic_photons=123)
    session.issues.warn("Wood", "node Foo is not supported", "white is used")
    session.render()
    write_json(tmp_path / "run.json", run_record(session))
    record = json.loads((tmp_path / "run.json").read_text())
    assert Settings(**record["settings"]) == session.settings and record["passes"] == 2
    assert record["statistics"]["photons"] == 20 and len(record["pass_seconds"]) == 2
    assert record["issues"][0] == {
        "severity": "warning", "object": "Wood", "message": "node Foo is not supported", "remedy": "white is used",
    }  # fmt: skip
    assert record["machine"]["versions"]["numpy"] == np.__version__


def test_automatic_settings_are_decided_and_recorded():
    for denoise, radius in (("OFF", 2.0), ("FINAL", 0.5)):
        session = session_of(passes=1, denoise=denoise)
        session.render()
        assert session.film.meta["settings"]["caustic_radius"] == session.settings.caustic_radius == radius
    assert session_of(denoise="FINAL", caustic_radius=3.0).settings.caustic_radius == 3.0


def test_the_denoised_error_is_estimated_while_that_is_cheap_and_at_the_end(monkeypatch):
    def passes_of(seconds):
        session = session_of(passes=10, denoise="FINAL")
        monkeypatch.setattr(Darkroom, "error", lambda room: DenoisedError(0.1, 0.2, 0.01))
        begin = Session._measure_denoised

        def measure(self, last):
            self.darkroom.error_seconds = seconds
            begin(self, last)

        monkeypatch.setattr(Session, "_measure_denoised", measure)
        session.render()
        monkeypatch.setattr(Session, "_measure_denoised", begin)
        return [item["passes"] for item in session.denoised_errors]

    assert passes_of(0.0) == [4, 8, 10] and passes_of(1e3) == [10]


def test_every_pixels_variance_is_kept_for_a_map_only(monkeypatch):
    monkeypatch.setattr("photon_engine.driver.session.MOST_MEASURED", 16)  # of the picture's 48 pixels
    for outputs, plan, whole in (({"Combined"}, True, False), ({"Noise"}, True, True), ({"Combined"}, False, True)):
        session = Session(triangle_scene(), Settings(passes=2, plan=plan), IssueLog(), FakeRenderer, outputs)
        session.render()
        assert (session.film.rows is None) == whole
