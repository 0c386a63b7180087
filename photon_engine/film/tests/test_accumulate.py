import json

import numpy as np
import pytest

from ...issues import RenderError
from ..accumulate import Film
from ..passes import BACKGROUND_DEPTH, LIGHT_NAMES, RAW

SHAPE = (5, 7)


def image(index, seed=0):
    """A pass with values over five decades, fixed by (seed, index)."""
    rng = np.random.default_rng([seed, index])
    return {name: (10.0 ** rng.uniform(-3, 2, (*SHAPE, c))).astype(np.float32) for name, c in RAW.items()}


def film_of(passes, **options):
    film = Film(*SHAPE, **options)
    for i in passes:
        film.add(i, image(i, film.seed))
    return film


def test_mean_and_variance_are_numpys():
    film = film_of(range(6), exposure=2.0)
    stack = {name: np.stack([image(i)[name] for i in range(6)]).astype(np.float64) for name in RAW}
    combined = sum(stack[name] for name in LIGHT_NAMES)
    bias = stack["CausticBias"] + stack["DiffuseBias"]
    np.testing.assert_allclose(film.variance("CombinedBias"), 4.0 * bias.var(axis=0, ddof=1), rtol=1e-12)
    np.testing.assert_allclose(film.mean("CombinedBias"), 2.0 * bias.mean(axis=0), rtol=1e-14)
    # 1e-12: rounding of six additions
    np.testing.assert_allclose(film.variance("Caustic"), 4.0 * stack["Caustic"].var(axis=0, ddof=1), rtol=1e-12)
    np.testing.assert_allclose(film.variance("Combined"), 4.0 * combined.var(axis=0, ddof=1), rtol=1e-12)
    # 1e-6: pictures are float32
    np.testing.assert_allclose(film.picture("Combined")[..., :3], 2.0 * combined.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(film.picture("Combined")[..., 3], stack["Alpha"].mean(axis=0)[..., 0], rtol=1e-6)
    np.testing.assert_allclose(film.picture("Normal"), stack["Normal"].mean(axis=0), rtol=1e-6)


def test_light_passes_sum_to_combined():
    film = film_of(range(3), exposure=0.7)
    total = sum(film.picture(name).astype(np.float64) for name in LIGHT_NAMES)
    np.testing.assert_allclose(film.picture("Combined")[..., :3], total, rtol=3e-7)  # float32 rounding of six pictures


@pytest.mark.parametrize("first", [1, 4, 7])
def test_merged_halves_have_the_bits_of_the_whole(first):
    whole, left, right = film_of(range(8)), film_of(range(first)), film_of(range(first, 8))
    right.merge(left)
    assert right.blocks == whole.blocks == [(0, 0, 8)]
    for name in ("Combined", *LIGHT_NAMES, "Depth", "Normal", "Albedo"):
        np.testing.assert_array_equal(right.picture(name), whole.picture(name))
    np.testing.assert_allclose(right.variance("Direct"), whole.variance("Direct"), rtol=1e-12)


def test_depth_is_the_lowest_passes_and_background_as_cycles():
    film = film_of([3, 1, 2])
    np.testing.assert_array_equal(film.picture("Depth"), image(1)["Depth"])
    sky = image(0)
    sky["Depth"][:] = np.inf
    film.add(0, sky)
    assert (film.picture("Depth") == np.float32(BACKGROUND_DEPTH)).all()


def test_the_same_pass_twice_is_refused():
    film = film_of(range(4))
    with pytest.raises(RenderError, match="pass 3 of seed 0 is in twice"):
        film.add(3, image(3))
    with pytest.raises(RenderError, match="twice"):
        film.merge(film_of([2]))
    before = film.picture("Combined")
    film.merge(film_of([0, 1], seed=5))
    assert film.blocks == [(0, 0, 4), (5, 0, 2)] and film.next_pass == 4
    assert not np.array_equal(before, film.picture("Combined"))


def test_other_settings_are_not_merged():
    a, b = film_of([0]), film_of([1])
    a.meta, b.meta = {"settings": {"alpha": 0.5, "x": 1}}, {"settings": {"alpha": 0.7, "x": 1}}
    with pytest.raises(RenderError, match=r"alpha 0\.5 and 0\.7"):
        a.merge(b)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_no_number_is_named_and_not_added(value):
    film = film_of([0])
    bad = image(1)
    bad["Diffuse"][2, 3, 1] = value
    with pytest.raises(FloatingPointError, match="Diffuse has 1 values that are not finite, first at x=3, y=2"):
        film.add(1, bad)
    np.testing.assert_array_equal(film.picture("Combined"), film_of([0]).picture("Combined"))
    film.add(1, image(1))
    np.testing.assert_array_equal(film.picture("Combined"), film_of([0, 1]).picture("Combined"))


def test_saved_film_goes_on_as_if_it_had_not_stopped(tmp_path):
    path = tmp_path / "film.npz"
    film = film_of(range(3), exposure=1.5)
    film.meta = {"settings": {"alpha": 0.5}, "seconds": 2.5}
    film.save(path)
    again = Film.load(path)
    assert again.meta == film.meta and again.next_pass == 3 and again.count == 3
    for i in (3, 4):
        again.add(i, image(i))
    np.testing.assert_array_equal(again.picture("Combined"), film_of(range(5), exposure=1.5).picture("Combined"))
    assert [p.name for p in tmp_path.iterdir()] == ["film.npz"]


def test_what_is_not_a_film_is_refused(tmp_path):
    with pytest.raises(RenderError, match="no such file"):
        Film.load(tmp_path / "none.npz")
    for content in (b"", b"hello", b"PK\x03\x04 broken"):
        (tmp_path / "bad.npz").write_bytes(content)
        with pytest.raises(RenderError, match="is not a saved film"):
            Film.load(tmp_path / "bad.npz")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(RenderError, match="is not a saved film"):
        Film.load(tmp_path / "other.npz")
    film_of([0, 1]).save(tmp_path / "film.npz")
    with np.load(tmp_path / "film.npz") as file:
        arrays = dict(file)
    head = json.loads(str(arrays["head"]))
    for name, value in (
        ("head", np.array(json.dumps(head | {"format": 3}))), ("head", np.array(json.dumps(head | {"height": 9**9}))),
        ("head", np.array(json.dumps(head | {"blocks": [[0, 5, 2]]}))), ("head", np.array("[]")),
        ("sum.Direct", arrays["sum.Direct"][:1]), ("square.Direct", np.full_like(arrays["square.Direct"], np.nan)),
    ):  # fmt: skip
        np.savez(tmp_path / "other.npz", **(arrays | {name: value}))
        with pytest.raises(RenderError, match="is not a saved film"):
            Film.load(tmp_path / "other.npz")


def test_a_dim_noisy_pass_beside_a_bright_steady_one_keeps_its_variance():
    """Combined of mean 1e6 and deviation 1e-3: the digits of its squares hold nothing of that after some passes."""
    n, steady = 2000, {name: np.zeros((*SHAPE, c), np.float32) for name, c in RAW.items()}
    steady["Emission"][:] = 1e6
    noise = (1e-3 * np.random.default_rng(3).standard_normal((n, *SHAPE, 3))).astype(np.float32)
    parts = [Film(*SHAPE), Film(*SHAPE)]
    for i in range(n):
        parts[i >= 700].add(i, steady | {"Diffuse": noise[i]})
    parts[0].merge(parts[1])
    expected = noise.astype(np.float64).var(axis=0, ddof=1)
    np.testing.assert_allclose(parts[0].variance("Diffuse"), expected, rtol=1e-9)
    np.testing.assert_allclose(parts[0].variance("Combined"), expected, rtol=1e-5)  # 1e6 has digits down to 1e-10


def test_black_pictures_take_no_memory(tmp_path):
    """And one that is lit later has all it needs: the mean and the variance over all passes."""
    dark, film = ("Caustic", "CausticBias", "Denoising Albedo", "Denoising Normal"), Film(*SHAPE)
    for i in range(3):
        film.add(i, image(i) | {name: np.zeros_like(image(i)[name]) for name in dark})
    assert not set(dark) & {*film.sums, *film.squares}
    assert not film.picture("Caustic").any() and not film.variance("Caustic").any()
    film.save(tmp_path / "film.npz")
    film = Film.load(tmp_path / "film.npz")
    assert not set(dark) & {*film.sums, *film.squares}
    film.add(3, image(3))
    late = np.zeros((4, *SHAPE, 3))
    late[3] = image(3)["Caustic"]
    np.testing.assert_allclose(film.picture("Caustic"), late.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(film.variance("Caustic"), late.var(axis=0, ddof=1), rtol=1e-12)


def test_variance_is_unknown_after_one_pass():
    assert np.isnan(film_of([0]).variance("Direct")).all()
