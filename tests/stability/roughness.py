"""Surfaces of every roughness: white ones stay white, and nothing happens where a lobe becomes sharp."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, case, level, shoot
from .transforms import furnace, plain

SHARP, ROUGH = 0.0499, 0.0501  # each side of the specular threshold
MIRROR, GLASS = "BsdfAnisotropic", "BsdfGlass"
LABELS = {MIRROR: "mirror", GLASS: "glass"}


def surface(kind: str, roughness: float):
    """A white mirror or glass."""
    index = {"IOR": 1.5} if kind == GLASS else {}
    return s.material(kind, 1.0, Roughness=roughness, **index)


def _white(kind: str, roughness: float, short: bool = False) -> None:
    @case("roughness", f"white {LABELS[kind]} of roughness {roughness:g}", "a white world stays white", short)
    def check() -> Finding:
        ball = s.sphere((0, 0, 0), 1.0, 48)
        shot = shoot(furnace([(ball, surface(kind, roughness))]), 16, max_bounces=256, light_samples=16)
        return level(shot, 1.0, 0.01, most_noise=0.05)


for roughness in (0.0, 1e-4, 0.0099, 0.0101, SHARP, ROUGH, 0.2, 0.5, 1.0):
    for kind in (MIRROR, GLASS):
        _white(kind, roughness, short=kind == GLASS and roughness in (ROUGH, 0.2))


def room(kind: str, roughness: float):
    """The plain room, its glass or mirror ball of that roughness."""
    scene = plain()
    index = [material.name for material in scene.materials].index("BsdfGlass" if kind == GLASS else MIRROR)
    scene.materials[index] = surface(kind, roughness)
    return scene


def _step(kind: str, low: float, high: float, allowed: float, short: bool = False) -> None:
    @case("roughness", f"{LABELS[kind]} of {low:g} and {high:g} in the room", "the same Combined", short)
    def check() -> Finding:
        """By blocks of the picture over its mean, beside 4 standard errors.

        Both renders have the same random numbers, but a lamp that is mirrored sharply is Emission, met by chance, and
        beyond the threshold Direct, by lobes and shadow rays: 0.5% and 0.7% of the mean is noise after 32 passes.
        """
        one, two = (shoot(room(kind, roughness), 32, caustic_photons=100_000) for roughness in (low, high))
        (a, ea), (b, eb) = one.blocks(), two.blocks()
        noise = 4.0 * np.hypot(ea, eb) / a.mean()
        whole = [shot.passes["Combined"].mean(axis=(1, 2, 3)) for shot in (one, two)]
        least = 4.0 * np.hypot(*(x.std(ddof=1) / np.sqrt(len(x)) for x in whole)) / a.mean()
        gap, mean = np.abs(a - b) / a.mean(), abs(b.mean() / a.mean() - 1.0)
        moved = (one.mean("Caustic").mean() - two.mean("Caustic").mean()) / a.mean()
        text = f"mean off by {mean:.1e}, a block by {gap.max():.1e}; caustic light less by {moved:.1e}"
        if low >= 0.01:
            text += f"; noise {least / 4.0:.1e}, {noise.max() / 4.0:.1e}"
        else:  # nothing changes its pass: differences are rounding
            noise, least = 0.0 * noise, 0.0
        good = bool((gap <= allowed + noise).all()) and mean <= 0.2 * allowed + least and least <= 0.05
        return Finding(good, text, two.seconds)


for kind in (MIRROR, GLASS):
    _step(kind, 0.0, 1e-4, 1e-6)
    _step(kind, 0.0099, 0.0101, 0.02)
# a caustic of the fine kernel becomes diffuse light of the coarse one, and a lamp seen in the ball is direct light
_step(MIRROR, SHARP, ROUGH, 0.03, short=True)
_step(GLASS, SHARP, ROUGH, 0.12)


def _no_threshold(roughness: float, short: bool = False) -> None:
    @case("roughness", f"glass of {roughness:g}, threshold 0", "a white world stays white", short)
    def check() -> Finding:
        """Below 0.01 a lobe has no width for the kernels, whatever the setting says."""
        scene = furnace([(s.sphere((0, 0, 0), 1.0, 48), surface(GLASS, roughness))])
        return level(shoot(scene, 8, specular_threshold=0.0, max_bounces=256), 1.0, 0.01, most_noise=0.05)


for roughness in (0.0, 5e-3, 0.0101):
    _no_threshold(roughness, short=roughness == 5e-3)


def _weak(index: float, roughness: float, short: bool = False) -> None:
    name = f"rough glass {roughness:g} of index {index:g}"

    @case("roughness", name, "bends next to nothing: a white world stays white", short)
    def check() -> Finding:
        glass = s.material(GLASS, 1.0, Roughness=roughness, IOR=index)
        scene = furnace([(s.sphere((0, 0, 0), 1.0, 48), glass)])
        return level(shoot(scene, 8, max_bounces=256), 1.0, 0.01, most_noise=0.05)


_weak(1.0, 0.3, short=True)
_weak(1.0001, 0.3)
_weak(1.01, 0.3)
for index in (1.0002, 1.001, 1.003, 1.006, 0.999):
    _weak(index, 1.0, short=index == 1.001)
