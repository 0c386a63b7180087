"""The same picture whatever the threads, and passes that can be rendered apart and merged."""

import numpy as np
import pytest

from tests.brute import scenes as s
from tests.brute.harness import engine


@pytest.fixture(scope="module")
def room():
    """A room with every kind of path, in a frame that no tile size divides."""
    scene = s.cornell("panel", 37)
    scene.world.color = (0.1, 0.2, 0.3)
    return scene


SMALL = {"caustic_photons": 30_000, "diffuse_photons": 30_000}


def test_threads_change_nothing(room):
    """The same pictures, bit for bit, with one thread and with two."""
    one, _ = engine(room, 2, threads=1, **SMALL)
    two, _ = engine(room, 2, threads=2, **SMALL)
    for name, picture in one.items():
        assert np.array_equal(picture, two[name]), name
    assert not np.array_equal(one["Caustic"][0], one["Caustic"][1])


def test_passes_stand_alone(room):
    """Passes [0, 8) of one run are [0, 4) and [4, 8) of two, bit for bit; merged films agree to rounding."""
    from photon_engine.film.accumulate import Film

    whole, _ = engine(room, 8, **SMALL)
    first, _ = engine(room, 4, **SMALL)
    second, _ = engine(room, 4, first=4, **SMALL)
    films = []
    for batches, start in ((whole, 0), (first, 0), (second, 4)):
        film = Film(37, 37)
        for i in range(len(batches["Direct"])):
            film.add(start + i, {name: picture[i].astype(np.float32) for name, picture in batches.items()})
        films.append(film)
    for name, picture in whole.items():
        assert np.array_equal(picture, np.concatenate([first[name], second[name]])), name
    films[1].merge(films[2])
    assert films[1].count == 8
    for name in ("Combined", "Caustic", "Diffuse"):
        np.testing.assert_allclose(films[1].picture(name), films[0].picture(name), rtol=1e-6, atol=1e-7)
