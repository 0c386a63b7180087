"""Renders of small scenes, and the laws that they are held to."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from photon_engine.driver.checks import check_scene
from photon_engine.film.accumulate import Film
from photon_engine.film.error import brightness, error_map, picture_error
from photon_engine.film.passes import LIGHT_NAMES
from photon_engine.issues import IssueLog
from photon_engine.settings import Settings
from photon_engine.transport.renderer import Renderer

SMALL = {"caustic_photons": 20_000, "diffuse_photons": 20_000, "threads": 1}
SIZE = 24  # [px]
BLOCK = 8  # [px]
PASSES, MORE = 8, 64  # of the run whose errors are judged, and of its judge
FACTOR = 1.5  # between the claimed and the true error of the picture
# the long run is no judge of bias with a radius of its own: half of what the short run smears would be in both
SHARP = {"caustic_photons": 50_000, "diffuse_photons": 50_000, "caustic_radius": 1.0, "diffuse_radius": 2.0}
A_FEW = 4  # pixels: a lamp seen by chance in a wave; not even the long run has met all


class Shot(NamedTuple):
    """What a render gave."""

    film: Film
    passes: dict[str, np.ndarray]  # name -> (n, h, w, 3) f64, pass by pass; the light passes and Combined
    issues: list[str]
    seconds: float  # of the processor, without preparation
    flux: dict[str, np.ndarray]  # of photon runs: (4, 3) W emitted, absorbed, escaped, dropped, summed over passes

    def mean(self, name: str = "Combined") -> np.ndarray:
        """The picture (h, w, 3) f64."""
        return self.passes[name].mean(axis=0)

    def blocks(self, name: str = "Combined") -> tuple[np.ndarray, np.ndarray]:
        """Means of square blocks of pixels and their standard errors over the passes."""
        n, h, w, _ = self.passes[name].shape
        b = min(BLOCK, h, w)
        a = self.passes[name][:, : h // b * b, : w // b * b]
        means = a.reshape(n, h // b, b, w // b, b, 3).mean(axis=(2, 4))
        return means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(n)


class Finding(NamedTuple):
    """What a case found."""

    good: bool
    figure: str  # the measured number and its bound
    seconds: float  # of the processor
    used: float = float("nan")  # of what is allowed, where that is a number


class Case(NamedTuple):
    """One line of the table."""

    family: str
    name: str
    law: str
    check: Callable[[], Finding]
    short: bool  # part of every test run
    known: str  # why the law is broken as yet; empty: it must hold


CASES: list[Case] = []


def case(family: str, name: str, law: str, short: bool = False, known: str = ""):
    """Register a function () -> Finding."""

    def add(check: Callable[[], Finding]) -> Callable[[], Finding]:
        CASES.append(Case(family, name, law, check, short, known))
        return check

    return add


def shoot(scene, passes: int = 4, **settings) -> Shot:
    """Render; the film refuses what is not finite, and no light pass may be negative."""
    issues = IssueLog()
    check_scene(scene, issues)
    chosen = Settings(**{**SMALL, **settings})
    frame = scene.frame
    film = Film(frame.y1 - frame.y0, frame.x1 - frame.x0, chosen.seed, frame.exposure)
    renderer = Renderer(scene, chosen, issues)
    kept = {name: [] for name in (*LIGHT_NAMES, "Combined")}
    try:
        renderer.prepare(lambda text: None)
        start = time.process_time()
        for i in range(passes):
            image = renderer.render_pass(i, lambda: False)
            film.add(i, image)
            for name in LIGHT_NAMES:
                assert (image[name] >= 0.0).all(), f"{name} is negative in pass {i}"
                kept[name].append(image[name].astype(np.float64))
            kept["Combined"].append(sum(kept[name][-1] for name in LIGHT_NAMES))
        seconds = time.process_time() - start
    finally:
        renderer.close()
    return Shot(film, {name: np.array(a) for name, a in kept.items()}, [str(issue) for issue in issues], seconds,
                renderer.statistics["flux"])  # fmt: skip


def same_randoms(one: Shot, two: Shot, factor: float = 1.0, allowed: float = 0.01) -> Finding:
    """Two renders with the same random numbers of what should be the same picture, the second brighter by a factor.

    Rounding turns a few paths elsewhere, so the pictures are compared by blocks: the largest difference of a block,
    over the mean of the picture, and not more than noise allows when paths differ.
    """
    (a, ea), (b, eb) = one.blocks(), two.blocks()
    scale = a.mean()
    gap = np.abs(b / factor - a)
    worst = float((gap / scale).max())
    noise = 4.0 * np.sqrt(ea**2 + (eb / factor) ** 2)
    good = bool((gap <= np.maximum(allowed * scale, noise)).all()) and scale > 0.0
    good = good and abs(b.mean() / factor / scale - 1.0) <= allowed
    mean = abs(b.mean() / factor / scale - 1.0)
    used = max(float((gap / np.maximum(allowed * scale, noise)).max()), mean / allowed)
    return Finding(good, f"largest block off by {worst:.1e}, mean by {mean:.1e}", two.seconds, used)


def within(value: float, expected: float, tolerance: float, seconds: float, what: str = "value") -> Finding:
    """A number against a law."""
    off = abs(value / expected - 1.0) if expected else abs(value)
    text = f"{what} {value:.5g}, expected {expected:.5g} within {tolerance:.1%}"
    return Finding(off <= tolerance, text, seconds, off / tolerance)


def level(shot: Shot, expected: float, allowed: float, name: str = "Combined", most_noise: float = 0.02) -> Finding:
    """A picture that should be of one value everywhere: every block within the allowance and four standard errors.

    most_noise : standard error of a block, relative, beyond which the case says nothing and fails
    """
    means, errors = shot.blocks(name)
    gap = np.abs(means / expected - 1.0)
    noise = float(errors.max() / expected)
    good = bool((gap <= allowed + 4.0 * errors / expected).all()) and noise <= most_noise
    mean = float(means.mean())
    text = f"mean {mean:.5g} of {expected:.5g}, largest block off by {gap.max():.1e}, noise {noise:.1e}"
    return Finding(good, text, shot.seconds, float((gap / (allowed + 4.0 * errors / expected)).max()))


def average(shot: Shot, name: str, expected: float, allowed: float, most_noise: float = 0.03) -> Finding:
    """The mean of a pass of the picture against a law, within the allowance and four standard errors.

    most_noise : standard error, relative, beyond which the case says nothing and fails
    """
    means = shot.passes[name].mean(axis=(1, 2, 3))
    value, noise = float(means.mean()), float(means.std(ddof=1) / np.sqrt(len(means)) / expected)
    used = abs(value / expected - 1.0) / (allowed + 4.0 * noise)
    good = used <= 1.0 and noise <= most_noise
    text = f"{value:.5g}, expected {expected:.5g}: off by {value / expected - 1.0:+.1%}, noise {noise:.1%}"
    return Finding(good, text, shot.seconds, used)


def calibrated(scene, names=("Combined",), least_inside: float = 0.9, **settings) -> Finding:
    """Claimed errors after PASSES against the true ones, by a run of MORE passes of another seed and smaller radii.

    least_inside : of pixels in intervals that claim 95%
    The claimed error of the picture may be FACTOR times too small or too large, beside A_FEW pixels that are wrong by
    all their brightness.
    """
    few_pixels = (A_FEW / (scene.frame.width * scene.frame.height)) ** 0.5
    short, long = shoot(scene, PASSES, **settings), shoot(scene, MORE, **{**SHARP, **settings, "seed": 9})
    good, texts = True, []
    for name in names:
        truth = long.film.mean(name)
        se = np.sqrt(long.film.variance(name) / MORE)
        gap = np.abs(short.film.mean(name) - truth)
        inside = float((gap <= error_map(short.film, name).interval + 1.96 * se).mean())
        relative = (gap**2).mean(axis=2, keepdims=True) / brightness(long.film, name) ** 2
        claimed, true = picture_error(short.film, name).error, float(np.sqrt(np.minimum(relative, 1.0).mean()))
        near = claimed <= FACTOR * true + few_pixels and true <= FACTOR * claimed + few_pixels
        good = good and inside >= least_inside and near
        texts.append(f"{name}: {inside:.1%} inside, claimed {claimed:.2g}, true {true:.2g}")
    return Finding(good, "; ".join(texts), short.seconds)


def told(shot: Shot, *words: str) -> bool:
    """Whether one message holds all the words."""
    return any(all(word in issue for word in words) for issue in shot.issues)
