from importlib.util import find_spec

import numpy as np
import pytest

from ...issues import IssueLog
from .. import oidn
from ..accumulate import Film
from ..darkroom import DENOISED, Darkroom
from ..halves import Halves
from ..passes import LIGHT_NAMES, RAW

SIZE = (48, 40)


def truth() -> np.ndarray:
    """A lit floor and a wall: a step, and a slope."""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]] / SIZE[0]
    return np.stack([0.2 + x, 0.5 + 0.5 * y, np.where(x > 0.5, 1.0, 0.2)], axis=2).astype(np.float32)


def film_of(passes: int, size=SIZE) -> Film:
    """Passes whose Direct is exponentially distributed about the truth, Caustic a tenth of it, the rest black."""
    film = Film(*size)
    for i in range(passes):
        rng = np.random.default_rng(i)
        image = {name: np.zeros((*size, c), np.float32) for name, c in RAW.items()}
        clean = truth()[: size[0], : size[1]]
        image["Direct"] = (clean * rng.exponential(1.0, clean.shape)).astype(np.float32)
        image["Caustic"] = (0.1 * clean * rng.exponential(1.0, clean.shape)).astype(np.float32)
        image["Alpha"][:] = rng.uniform(0.0, 1.0, (*size, 1))
        image["Denoising Albedo"][:] = 0.5
        image["Denoising Normal"][:, :, 2] = 1.0
        film.add(i, image)
    return film


def darkroom_of(film, denoise="FINAL", threads=1, cancelled=lambda: False) -> Darkroom:
    return Darkroom(film, denoise, threads, IssueLog(), cancelled)


@pytest.fixture(autouse=True)
def needs_the_library():
    try:
        oidn.library()
    except oidn.DenoiserMissing as error:
        if find_spec("bpy"):  # which carries it: not finding it there is our fault
            raise
        pytest.skip(str(error))


def error(picture, clean) -> float:
    return float(np.mean((picture[..., :3] - clean) ** 2))


def test_each_picture_loses_its_noise_and_the_raw_ones_stay():
    film = film_of(4)
    out = darkroom_of(film).pictures([*DENOISED, "Noisy Combined", "Noisy Caustic", "Depth", "Albedo"])
    # measured: 53 and 50 times less; independent noise of 4 passes over 1920 pixels
    assert error(out["Combined"], 1.1 * truth()) < 0.05 * error(out["Noisy Combined"], 1.1 * truth())
    assert error(out["Caustic"], 0.1 * truth()) < 0.05 * error(out["Noisy Caustic"], 0.1 * truth())
    for name in ("Combined", "Caustic"):
        np.testing.assert_array_equal(out[f"Noisy {name}"], film.picture(name))
    np.testing.assert_array_equal(out["Combined"][..., 3], film.picture("Combined")[..., 3])
    for name in ("Depth", "Albedo", "Emission"):  # no noise, no light
        np.testing.assert_array_equal(out[name], film.picture(name))


def test_the_number_of_threads_does_not_change_a_bit():
    one, two = (darkroom_of(film_of(2), threads=n).pictures(["Combined"])["Combined"] for n in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_interim_pictures_are_denoised_only_when_asked():
    film = film_of(2)
    raw = film.picture("Combined")
    for denoise, final, clean in (("OFF", True, 0), ("FINAL", False, 0), ("FINAL", True, 1), ("ALWAYS", False, 1)):
        darkroom = darkroom_of(film, denoise)
        out = darkroom.pictures(["Combined"], final)["Combined"]
        assert np.array_equal(out, raw) != bool(clean)
        assert bool(darkroom.version) == bool(clean)


def test_guides_are_cleaned_once_a_pass_and_only_final_pictures_have_the_best_quality(monkeypatch):
    runs = []
    whole = oidn.Oidn._filter

    def note(self, images, flags, quality, cancelled):
        runs.append((sorted(images), quality))
        return whole(self, images, flags, quality, cancelled)

    monkeypatch.setattr(oidn.Oidn, "_filter", note)
    guides = [(["albedo"], oidn.BALANCED), (["normal"], oidn.BALANCED)]
    darkroom, color = darkroom_of(film_of(2), "ALWAYS"), ["albedo", "color", "normal"]
    darkroom.halves = Halves(*SIZE, 1.0)
    darkroom.halves.counts = [1, 1]
    assert darkroom.error() is not None and runs == [*guides, *[(color, oidn.BALANCED)] * 2]
    runs.clear()
    darkroom.pictures(["Combined", "Direct"], final=False)
    darkroom.pictures(["Combined"])
    assert runs == [*[(color, oidn.BALANCED)] * 2, (color, oidn.HIGH)]
    more = {name: np.ones((*SIZE, c), np.float32) for name, c in RAW.items()}
    darkroom.film.add(2, more | {"Emission": np.zeros((*SIZE, 3), np.float32)})
    runs.clear()
    darkroom.pictures(["Combined"])
    assert runs == [*guides, (color, oidn.HIGH)]


@pytest.mark.parametrize("with_halves", [True, False])
def test_a_lamp_in_a_ball_stays_and_light_met_by_chance_goes(with_halves):
    """Few pixels a hundred times brighter than what is around them, with 10% of noise; one that a single pass saw."""
    rng = np.random.default_rng(3)
    film, halves = Film(*SIZE, most_measured=0 if with_halves else None), Halves(*SIZE, 1.0)
    lamp = np.zeros((*SIZE, 3), np.float32)
    lamp[30, 20:22] = lamp[31, 21] = 80.0
    for i in range(8):
        image = {name: np.zeros((*SIZE, c), np.float32) for name, c in RAW.items()}
        image["Direct"] = (0.1 * truth() * rng.exponential(1.0, truth().shape)).astype(np.float32)
        image["Emission"] = (lamp * (1.0 + 0.1 * rng.normal(size=(*SIZE, 1)))).astype(np.float32)
        image["Emission"][10, 10] = 40.0 * (i == 5)
        film.add(i, image)
        halves.add(image)
    darkroom = Darkroom(film, "FINAL", 1, IssueLog(), halves=halves if with_halves else None)
    out = darkroom.pictures(["Combined", "Direct", "Emission", "Noisy Emission"])
    np.testing.assert_allclose(out["Emission"][lamp > 0.0], out["Noisy Emission"][lamp > 0.0], rtol=0.1)
    around = out["Combined"][28:34, 18:24, :3][lamp[28:34, 18:24] == 0.0]
    assert around.max() < 0.4  # direct light is at most 0.3 there; denoised as a whole it was 3 beside the lamp
    assert out["Emission"][10, 10].max() < 0.1 * out["Noisy Emission"][10, 10].max()
    np.testing.assert_allclose(out["Combined"][..., :3], out["Direct"] + out["Emission"], atol=1e-3)


def test_cancelled_work_leaves_the_raw_picture_and_says_so():
    film = film_of(2)
    calls = []
    darkroom = darkroom_of(film, cancelled=lambda: calls.append(0) or len(calls) > 2)
    out = darkroom.pictures(["Combined", "Direct"])
    np.testing.assert_array_equal(out["Combined"], film.picture("Combined"))
    assert len(calls) > 2 and not darkroom.version
    assert ["cancelled" in issue.message for issue in darkroom.issues] == [True]


def test_a_cancelled_render_is_denoised_when_that_was_quick_before():
    darkroom = darkroom_of(film_of(2), cancelled=lambda: True)
    darkroom._last = 1e-3
    assert not np.array_equal(darkroom.pictures(["Combined"])["Combined"], darkroom.film.picture("Combined"))
    darkroom._last = 10.0
    assert np.array_equal(darkroom.pictures(["Combined"])["Combined"], darkroom.film.picture("Combined"))


def test_without_the_library_the_picture_stays_and_the_user_is_told_once(monkeypatch):
    monkeypatch.setattr(oidn, "candidates", lambda: ["/nowhere/libOpenImageDenoise.so.2"])
    oidn.library.cache_clear()
    try:
        darkroom = darkroom_of(film_of(1))
        for _ in range(2):
            out = darkroom.pictures(["Combined"])["Combined"]
            np.testing.assert_array_equal(out, darkroom.film.picture("Combined"))
    finally:
        oidn.library.cache_clear()
    (issue,) = darkroom.issues
    assert "cannot be loaded" in issue.message and issue.remedy


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (48, 1)])
def test_any_size(size):
    out = darkroom_of(film_of(2, size)).pictures(DENOISED)
    for name in ("Combined", *LIGHT_NAMES):
        assert out[name].shape[:2] == size and np.isfinite(out[name]).all()
