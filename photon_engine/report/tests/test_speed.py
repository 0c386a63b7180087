"""Time to equal error, on curves that are known."""

import pytest

from ..speed import compare, curve, error_ratio, faster, medians


def power(scale, seconds):
    """An error that falls as 1 / time."""
    return [(t, scale / t) for t in seconds]


def points(engine, line):
    shared = {"engine": engine, "part": "Combined"}
    return [
        {**shared, "asked_seconds": t, "seconds": t, "cpu_seconds": 2.0 * t, "relMSE": e, "relMSE999": 0.5 * e**2}
        for t, e in line
    ]


def test_times_between_points_are_exact_for_a_power_of_time():
    times, bound, stays = faster(power(1.0, (1.0, 2.0)), power(3.0, (1.0, 2.0, 4.0, 8.0)))
    assert times == pytest.approx(3.0) and bound == "=" and stays == pytest.approx(3.0 / 8.0)
    assert error_ratio(power(1.0, (1.0, 3.0)), power(3.0, (1.0, 2.0, 4.0, 8.0))) == pytest.approx(3.0)


def test_an_error_that_is_never_reached_bounds_from_below():
    times, bound, stays = faster(power(1.0, (1.0, 2.0)), power(100.0, (1.0, 8.0)))
    assert (times, bound, stays) == (pytest.approx(8.0), ">", pytest.approx(12.5))


def test_an_error_that_they_had_at_once_bounds_from_above():
    times, bound, _ = faster(power(100.0, (1.0, 8.0)), power(1.0, (1.0, 2.0)))
    assert (times, bound) == (pytest.approx(1.0 / 8.0), "<")


def test_an_error_once_reached_is_kept_and_clocks_are_apart():
    line = points("Cycles", [(1.0, 0.4), (2.0, 0.1), (4.0, 0.3)])
    assert curve(line, "Cycles", "cpu_seconds") == [(2.0, 0.4), (4.0, 0.1), (8.0, 0.1)]
    ours = points("Photon Map", [(1.0, 0.2)])
    seconds, cpu, best_seconds, best_cpu = compare(ours + line)
    assert (seconds.pictures, seconds.clock, cpu.clock) == ("raw", "seconds", "cpu_seconds")
    assert [item.figure for item in (seconds, cpu, best_seconds, best_cpu)] == ["relMSE"] * 2 + ["relMSE999"] * 2
    assert seconds.times == pytest.approx(2.0**0.5) == cpu.times
    assert seconds.error_ratio == pytest.approx(2.0) and best_seconds.error_ratio == pytest.approx(4.0)
    assert str(seconds) == ("raw: 1.4 times faster to equal relMSE in seconds; after equal time that of Cycles "
                            "is 2 times ours")  # fmt: skip


def test_repeated_runs_become_their_median():
    runs = [point for error in (0.1, 0.9, 0.2) for point in points("Cycles", [(1.0, error), (2.0, error / 2.0)])]
    found = medians(runs)
    assert [point["relMSE"] for point in found] == pytest.approx([0.2, 0.1]) and len(found) == 2
