"""Error bars against noise and bias that are known."""

import numpy as np
import pytest

from ..accumulate import STRIP, Film
from ..error import (
    BIAS_FACTOR,
    ERROR_NAMES,
    capped_square,
    error_map,
    error_picture,
    picture_error,
    quantile_of_errors,
    squared_bias,
)
from ..passes import RAW

SIZE = 48


def film_of(passes, sigma=0.2, bias=None, truth=1.0, size=SIZE, seed=0, **options):
    """A film of Direct and Caustic = truth + bias + normal noise, its bias estimate three times as noisy."""
    film = Film(size, size, **options)
    rng = np.random.default_rng(seed)
    bias = np.zeros((size, size, 3)) if bias is None else bias
    for i in range(passes):
        image = {name: np.zeros((size, size, c), np.float32) for name, c in RAW.items()}
        image["Direct"][:] = truth + sigma * rng.standard_normal((size, size, 3))
        image["Caustic"][:] = truth + bias + sigma * rng.standard_normal((size, size, 3))
        image["CausticBias"][:] = bias + 3.0 * sigma * rng.standard_normal((size, size, 3))
        film.add(i, image)
    return film


def waves(height=0.1, size=SIZE):
    """A bias that is positive here and negative there."""
    x = np.arange(size) / size
    return np.repeat((height * np.sin(8 * x)[:, None] * np.cos(9 * x)[None, :])[:, :, None], 3, axis=2)


@pytest.mark.parametrize("passes", [2, 4, 16, 64])
def test_noise_is_the_standard_error(passes):
    """Of 7000 values each of few degrees of freedom: within 3%, of Combined 2^(1/2) as much of twice the light."""
    film = film_of(passes)
    direct, combined = picture_error(film, "Direct"), picture_error(film, "Combined")
    # the brightness that errors are relative to is (1 + FLOOR^2)^(1/2) of the truth: half a percent more
    assert direct.noise == pytest.approx(0.2 / passes**0.5, rel=0.03) and direct.bias == 0.0
    assert combined.noise == pytest.approx(0.2 / (2.0 * passes) ** 0.5, rel=0.03)
    assert direct.error == pytest.approx(direct.noise, rel=0.02)


def test_noise_falls_with_the_root_of_passes():
    """Exponent of claimed noise over 4 to 256 passes; its own noise is 0.002."""
    counts = [4, 16, 64, 256]
    noise = [picture_error(film_of(n, size=24), "Direct").noise for n in counts]
    assert np.polyfit(np.log(counts), np.log(noise), 1)[0] == pytest.approx(-0.5, abs=0.05)


def test_bias_is_found_under_noise_of_its_own_size():
    """Waves of rms 0.05 whose estimate has noise 0.6 a pass: found within 15% after 16 passes, and none without."""
    bias = waves()
    rms = np.sqrt((bias**2).mean())
    found = np.sqrt(squared_bias(film_of(16, bias=bias), "Caustic").mean()) / BIAS_FACTOR
    assert found == pytest.approx(rms, rel=0.15)
    assert picture_error(film_of(16), "Caustic").bias < 0.3 * rms * BIAS_FACTOR
    assert not squared_bias(film_of(4), "Direct").any()


@pytest.mark.parametrize("passes", [4, 8, 32])
@pytest.mark.parametrize("biased", [False, True])
def test_interval_holds_the_truth(passes, biased):
    """95% asked; variance is pooled upward and the bias added to noise, so more than that hold."""
    film = film_of(passes, bias=waves(0.3) if biased else None)
    inside = np.abs(film.mean("Caustic") - 1.0) <= error_map(film, "Caustic").interval
    assert 0.94 < inside.mean() <= 1.0


def test_one_photon_does_not_smear_its_bias_over_its_neighbours():
    """A pixel 100 times too bright counts once, not in the 80 pixels that share its bias: 2 pixels of 2304 wrong."""
    bias = np.zeros((SIZE, SIZE, 3))
    bias[20, 20] = 100.0
    plain, lit = (picture_error(film_of(16, 0.02, b), "Caustic") for b in (None, bias))
    assert lit.bias**2 * SIZE**2 == pytest.approx(BIAS_FACTOR**2, rel=0.2)
    assert lit.error**2 - plain.error**2 < 2.0 * BIAS_FACTOR**2 / SIZE**2


def test_rare_bright_photons_do_not_leave_certainty_around_them():
    """A tenth of a photon a pixel and pass: most pixels have seen none in four, their own variance would claim zero."""
    rng = np.random.default_rng(3)
    film = Film(SIZE, SIZE)
    for i in range(4):
        image = {name: np.zeros((SIZE, SIZE, c), np.float32) for name, c in RAW.items()}
        image["Caustic"][:] = rng.poisson(0.1, (SIZE, SIZE, 1))
        film.add(i, image)
    inside = np.abs(film.mean("Caustic") - 0.1) <= error_map(film, "Caustic").interval
    assert inside.mean() > 0.9 and (film.mean("Caustic") == 0.0).mean() > 0.6


@pytest.mark.parametrize("spread", [0.05, 0.5, 3.0])
def test_figures_of_a_spread_are_those_of_sampled_errors(spread):
    """The closed forms against 200000 normal errors: 1%."""
    errors = spread * np.random.default_rng(1).standard_normal(200_000)
    assert capped_square(np.array([spread]))[0] == pytest.approx(np.minimum(errors**2, 1.0).mean(), rel=0.01)
    for share in (0.5, 0.95, 1.0):
        found = quantile_of_errors(np.full(10, spread), share)
        if share < 1.0:
            assert found == pytest.approx(np.quantile(np.abs(errors), share), rel=0.015)  # bins of 2%
        else:
            assert found > np.abs(errors).max()


def test_share_of_pixels():
    """Half of the picture is without error: half of the pixels are within zero, the rest decide the other shares."""
    spread = np.concatenate([np.zeros(500), np.full(500, 0.1)])
    assert quantile_of_errors(spread, 0.4) == 0.0
    assert quantile_of_errors(spread, 0.975) == pytest.approx(0.196, rel=0.02)  # 95% of the noisy half


def test_nothing_is_known_after_one_pass_and_black_is_certain():
    film = film_of(1)
    assert all(np.isnan(value) for value in picture_error(film, "Direct"))
    assert picture_error(film, "Direct").rounded()["error"] is None
    assert picture_error(film_of(2), "Emission") == (0.0, 0.0, 0.0, 0.0)
    assert set(ERROR_NAMES) == {"Direct", "Caustic", "Diffuse", "Emission", "Environment", "Combined"}


def test_strips_of_a_big_picture_tell_its_errors(tmp_path):
    """A quarter of the rows: the same noise within that of fewer values; maps need all of them."""
    size = 16 * STRIP // 2
    whole = film_of(4, size=size, bias=waves(size=size))
    part = film_of(4, size=size, bias=waves(size=size), most_measured=size * size // 4)
    assert len(part.rows) == size // 4 and part.squares["Direct"].shape == (size // 4, size, 3)
    for name in ("Direct", "Caustic", "Combined"):
        assert picture_error(part, name).noise == pytest.approx(picture_error(whole, name).noise, rel=0.03)
    np.testing.assert_array_equal(part.picture("Combined"), whole.picture("Combined"))
    with pytest.raises(ValueError, match="measured"):
        error_picture(part, "Noise")
    part.save(tmp_path / "part.npz")
    again = Film.load(tmp_path / "part.npz")
    assert picture_error(again, "Caustic") == picture_error(part, "Caustic")


def test_none_measured():
    film = film_of(2, most_measured=0)
    assert not film.squares and "CausticBias" not in film.sums
    assert np.isnan(picture_error(film, "Combined").error)


def test_maps_are_those_of_combined():
    film = film_of(8, exposure=2.0)
    expected = np.sqrt(film.variance("Combined") / 8)
    np.testing.assert_allclose(error_picture(film, "Noise"), expected, rtol=1e-6)
    assert error_picture(film, "Noise").mean() == pytest.approx(2.0 * 0.2 * (2 / 8) ** 0.5, rel=0.1)
    assert error_picture(film, "Bias").shape == (SIZE, SIZE, 3)
