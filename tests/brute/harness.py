"""Pictures in independent batches, by the engine or by the reference tracer, so that any measure has an error bar."""

from typing import NamedTuple

import numpy as np

from photon_engine.issues import IssueLog
from photon_engine.settings import Settings

from .compiled import compile_scene
from .light_tracer import trace_light
from .path_tracer import CLASSES, render


class Value(NamedTuple):
    """A measured number and its standard error."""

    mean: float
    error: float

    def agrees(self, expected, tolerance, sigmas=4.0):
        """Whether it lies within tolerance (relative) and noise of the expected value.

        Noise above the tolerance proves nothing, so it fails: ask for more samples.
        """
        allowed = tolerance * abs(expected)
        return self.error <= allowed and abs(self.mean - expected) <= allowed + sigmas * self.error

    def __str__(self):
        """With its error."""
        return f"{self.mean:.6g} +- {self.error:.2g}"


class Batches(dict):
    """Pass name -> (n, h, w, c) f64: n independent pictures."""

    def value(self, name, where=np.s_[:, :], channel=0):
        """Mean over a part of a pass (or of the sum of passes, "A+B"), with the error that the batches show."""
        picture = sum(self[part] for part in name.split("+"))
        means = np.array([p[where][..., channel].mean() for p in picture])
        return Value(float(means.mean()), float(means.std(ddof=1) / np.sqrt(len(means))))

    def blocks(self, name, size):
        """(mean, standard error), each (h / size, w / size, c), of square blocks of a pass."""
        a = self[name]
        n, h, w, c = a.shape
        means = a.reshape(n, h // size, size, w // size, size, c).mean(axis=(2, 4))
        return means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(n)


def engine(scene, passes=8, first=0, **settings):
    """Batches of the engine's passes [first, first + passes), and what it counted."""
    from photon_engine.transport.renderer import Renderer

    renderer = Renderer(scene, Settings(**settings), IssueLog())
    try:
        renderer.prepare(lambda text: None)
        pictures = [renderer.render_pass(i, lambda: False) for i in range(first, first + passes)]
        statistics = dict(renderer.statistics)
    finally:
        renderer.close()
    return Batches({name: np.array([p[name] for p in pictures], float) for name in pictures[0]}), statistics


def eye_reference(scene, spp, batches=8, first_seed=1, **options):
    """Batches of the reference path tracer, spp samples a pixel in all."""
    options["compiled"] = options.get("compiled") or compile_scene(scene)
    pictures = [render(scene, max(1, spp // batches), seed=first_seed + i, **options) for i in range(batches)]
    return Batches({name: np.array([p[name][0] for p in pictures]) for name in CLASSES})


def reference(scene, spp, photons, batches=8, first_seed=1, **options):
    """Batches of the reference: caustics and diffuse light seen directly from the light tracer, the rest from the eye.

    Small lights and caustics are what paths from the eye find badly. All classes; both estimators are unbiased.
    Half of the samples go to paths whose first vertex is sharp. photons = 0: paths from the eye only.
    """
    if photons == 0:
        return eye_reference(scene, spp, batches, first_seed, **options)
    compiled = options["compiled"] = compile_scene(scene)
    plain = eye_reference(scene, spp // 2, batches, first_seed, start="not sharp", **options)
    mirrored = eye_reference(scene, spp // 2, batches, first_seed + (1 << 20), start="sharp", **options)
    seeds = range(first_seed, first_seed + batches)
    light = [trace_light(scene, photons // batches, seed=seed, batches=1, compiled=compiled) for seed in seeds]
    out = Batches({name: plain[name] + mirrored[name] for name in CLASSES})
    for name in ("Caustic", "Diffuse"):
        out[name] = np.array([p[name][0] for p in light]) + mirrored[name]
    return out
