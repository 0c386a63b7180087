"""The claimed errors against the true ones, for each component of every sample: runs of sample_blends/components.py."""

import numpy as np
import pytest

from photon_engine.driver.listener import Listener
from photon_engine.driver.session import Session
from photon_engine.film.error import brightness, error_map, picture_error
from photon_engine.film.halves import FLOOR, most
from photon_engine.issues import IssueLog
from photon_engine.settings import Settings
from sample_blends import components

PASSES = (4, 8)  # later ones are easier: 16 and 32 were looked at once
# few photons: passes are quick and the radius, bounded by the pilot, smears enough to be seen beside the noise
SETTINGS = Settings(passes=PASSES[-1], caustic_photons=20_000, diffuse_photons=20_000, seed=5)
INSIDE = 0.90  # of the pixels, of intervals that claim 95%
FACTOR = 1.5  # between the claimed and the true error of the picture: came out 0.72 to 1.2
# six pixels of 64 x 64 that are off by all of their brightness: a lamp seen by chance in a glass, which not even the
# long run has met everywhere
A_FEW_PIXELS = (6 / 64**2) ** 0.5
# a pass seen in fewer pixels, by a photon or two each even in the long run, is judged over all of them: Diffuse of
# ring_cardioid, 1.6% of the pixels in the long run and 87% of those inside; all others have 94% or more inside
RARE = 0.02


class Snapshots(Listener):
    """Looks at the film after some of the passes."""

    def __init__(self, truth):
        self.truth = truth
        self.found = {}

    def picture(self, darkroom, final):
        """Judge every component."""
        film = darkroom.film
        if film.count in PASSES and film.count not in self.found:
            self.found[film.count] = {name: judge(film, name, self.truth) for name in self.truth.mean}


def judge(film, name, truth):
    """Part of the pixels inside their interval; the error claimed; the true one, with the long run's own noise."""
    reference, se = truth.mean[name].astype(float), truth.se[name].astype(float)
    difference = np.abs(film.mean(name) - reference)
    inside = difference <= error_map(film, name).interval + 1.96 * se
    seen = (film.mean(name) > 0.0) | (reference > 0.0)  # where there is something to be wrong about
    counted = seen if (reference > 0.0).mean() > RARE else np.ones_like(seen)
    relative = (difference**2).mean(axis=2, keepdims=True) / brightness(film_of(reference, name, truth), name) ** 2
    true = np.sqrt(np.minimum(relative, 1.0).mean())
    return float(inside[counted].mean()), picture_error(film, name).error, float(true)


def film_of(reference, name, truth):
    """What `brightness` asks of a film, answered by the long run."""

    class Known:
        def mean(self, asked):
            return reference if asked == name else truth.mean[asked].astype(float)

    return Known()


@pytest.mark.slow
@pytest.mark.parametrize("name", components.SAMPLES)
def test_claimed_errors_are_true(name):
    listener = Snapshots(components.read(name))
    Session(components.open_sample(name), SETTINGS, IssueLog()).render(listener)
    wrong = []
    for passes, found in listener.found.items():
        for part, (inside, claimed, true) in found.items():
            text = f"{part} after {passes} passes: {inside:.3f} inside, claimed {claimed:.3f}, true {true:.3f}"
            print(text)
            near = claimed < FACTOR * true + A_FEW_PIXELS and true < FACTOR * claimed + A_FEW_PIXELS
            if inside < INSIDE or not near:
                wrong.append(text)
    assert set(listener.found) == set(PASSES) and not wrong, "\n".join(wrong)


DENOISED = ("cornell_caustics", "diffuse_room", "pool")
# in relMSE, beyond the figure's own doubt; at 4, 8 and 16 passes of all six samples 15 of 18 figures were, the worst
# off by 2.1. Of diffuse_room seeds 5, 6, 7 told 0.014, 0.006, 0.004 of 0.013, 0.015, 0.012: its raw halves are noise
DENOISED_FACTOR = 1.5


@pytest.mark.slow
@pytest.mark.parametrize("name", DENOISED)
def test_the_denoised_error_is_told_from_half_buffers(name):
    settings = SETTINGS.replace(passes=8, denoise="FINAL")
    truth = components.read(name)
    session = Session(components.open_sample(name), settings, IssueLog())
    session.render()
    picture = session.darkroom.pictures(["Combined"])["Combined"][..., :3]
    reference, se = truth.mean["Combined"].astype(float), truth.se["Combined"].astype(float)
    relative = ((picture - reference) ** 2 - se**2) / (reference**2 + FLOOR)
    true, told = most(relative.mean(axis=2)), session.denoised_errors[-1]
    claimed, doubt = told["total"], 2.0 * told["doubt"]
    print(f"{name}: claimed {claimed:.4f} +- {doubt:.4f}, true {true:.4f}")
    assert true / DENOISED_FACTOR - doubt < claimed < true * DENOISED_FACTOR + doubt
