import numpy as np
import pytest

from ..halves import FLOOR, Halves, denoised_error, steady_share
from ..passes import RAW

SIZE = 96


def smooth(picture, times=1):
    """A stand-in for a denoiser: means over 3 x 3 pixels, again and again."""
    for _ in range(times):
        picture = sum(np.roll(picture, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)) / 9.0
    return picture


def truth():
    y, x = np.mgrid[0:SIZE, 0:SIZE] / SIZE
    return np.repeat((2.0 + np.sin(8.0 * np.pi * x) * np.cos(4.0 * np.pi * y))[:, :, None], 3, axis=2)


def claimed_and_true(passes, times, seed):
    """Estimates from the halves, and what the denoised whole is really off by."""
    rng = np.random.default_rng(seed)
    halves, total = Halves(SIZE, SIZE, 2.0), np.zeros((SIZE, SIZE, 3))
    for _ in range(passes):
        image = {name: np.zeros((SIZE, SIZE, c), np.float32) for name, c in RAW.items()}
        image["Direct"] = (0.5 * truth() * rng.exponential(1.0, truth().shape)).astype(np.float32)
        halves.add(image)
        total += 2.0 * image["Direct"] / passes
    raw = halves.pictures()
    error = denoised_error(raw, tuple(smooth(half, times) for half in raw))
    return error, float(np.mean((smooth(total, times) - truth()) ** 2 / (truth() ** 2 + FLOOR)))


@pytest.mark.parametrize(("passes", "times"), [(16, 1), (16, 3), (64, 4)])
def test_claimed_error_is_the_true_one(passes, times):
    # over 20 seeds each it came out between 0.81 and 1.53 of the truth: weighing by the darker half errs upward
    error, true = claimed_and_true(passes, times, seed=passes + times)
    assert 0.67 < error.total / true < 1.75
    assert error.noise <= error.total


def test_doubt_is_the_spread_of_what_is_told():
    """Over 30 seeds, whose spread is known to 13%; smoothing shares noise between pixels, which adds some."""
    found = [claimed_and_true(4, 3, seed)[0] for seed in range(30)]
    spread = np.std([error.total for error in found], ddof=1)
    assert 0.6 < np.mean([error.doubt for error in found]) / spread < 1.5


def test_smear_is_seen_where_the_halves_agree():
    """Much smoothing of many passes: hardly any noise is left, and the error is the blur."""
    error, true = claimed_and_true(64, 12, seed=1)
    assert error.noise < 0.05 * true and 0.67 < error.total / true < 1.5


def test_halves_are_full_when_they_hold_as_many_passes():
    halves = Halves(2, 2, 1.0)
    image = {name: np.ones((2, 2, c), np.float32) for name, c in RAW.items()}
    states = [halves.full]
    for _ in range(4):
        halves.add(image)
        states.append(halves.full)
    assert states == [False, False, True, False, True]
    for half in halves.pictures():
        np.testing.assert_array_equal(half, 5.0)


def test_one_pixel_of_luck_does_not_decide_the_error():
    """A pixel that one half alone saw shine makes the mean of the cross terms negative, or the picture all wrong."""
    rng = np.random.default_rng(2)
    raw = [truth() * (1.0 + 0.3 * rng.normal(size=truth().shape)) for _ in range(2)]
    clean = [smooth(half, 3) for half in raw]
    expected = denoised_error(tuple(raw), tuple(clean))
    raw[0][40, 50] = 1e3
    got = denoised_error(tuple(raw), tuple(clean))
    assert abs(got.total / expected.total - 1.0) < 0.01 and got.noise == expected.noise


def test_what_the_radius_smears_is_added():
    raw = (truth(), truth())
    assert denoised_error(raw, raw, smeared=0.02) == pytest.approx((0.0, 0.02, 0.0))


def test_emission_is_kept_where_both_halves_agree():
    first = np.array([4.0, 4.0, 4.0, 0.0])[None, :, None] * np.ones(3)
    second = np.array([4.0, 3.0, 0.0, 0.0])[None, :, None] * np.ones(3)
    # relative standard errors of 0, 1 / 7, 1, and nothing seen
    np.testing.assert_allclose(steady_share(first, second)[0, :, 0], [1.0, 1.0 - 2.0 / 49.0, 0.0, 1.0], rtol=1e-6)
