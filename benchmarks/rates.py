"""Claims of rate, measured and fitted: ``python -m benchmarks.rates`` (minutes) prints and writes out/rates.json.

- noise against passes: -1/2 (a component with rare bright photons nears it late: its variance is not yet seen)
- bias against the gather radius: 2 where light is smooth, 1 where edges decide
- seconds of the photon pass against photons, of the eye pass against pixels: 1
- seconds a ray against triangles: grows like their logarithm; given as the exponent (near 0) and per doubling

Times are thread CPU seconds of one worker, the least of several repeats.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
REPEATS = 5


def exponent(x, y) -> float:
    """Slope of log y against log x by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def renderer_of(scene, **settings):
    """A prepared renderer with one worker."""
    from photon_engine.issues import IssueLog
    from photon_engine.settings import Settings
    from photon_engine.transport.renderer import Renderer

    renderer = Renderer(scene, Settings(threads=1, **settings), IssueLog())
    renderer.prepare(lambda text: None)
    return renderer


def film_of(renderer, passes: int):
    """A film of so many passes."""
    from photon_engine.film.accumulate import Film

    frame = renderer.data.frame
    film = Film(frame.height, frame.width)
    for i in range(passes):
        film.add(i, renderer.render_pass(i, lambda: False))
    return film


def noise_against_passes(scene, counts=(4, 16, 64)) -> dict[str, Any]:
    """Claimed noise of each component that is not black."""
    from photon_engine.film.accumulate import Film
    from photon_engine.film.error import ERROR_NAMES, picture_error

    # a constant radius: a shrinking one adds noise from pass to pass
    renderer = renderer_of(scene, caustic_photons=20_000, diffuse_photons=20_000, alpha=1.0)
    film, found = Film(scene.frame.height, scene.frame.width), {}
    for i in range(max(counts)):
        film.add(i, renderer.render_pass(i, lambda: False))
        if i + 1 in counts:
            found[i + 1] = {name: picture_error(film, name).noise for name in ERROR_NAMES}
    renderer.close()
    lit = [name for name in ERROR_NAMES if found[counts[0]][name] > 0.0]
    return {name: exponent(counts, [found[n][name] for n in counts]) for name in lit}


def bias_against_radius(scene, radii=(2.0, 4.0, 8.0), passes: int = 24) -> dict[str, Any]:
    """Claimed bias of Diffuse for constant radii [half pixels]."""
    from photon_engine.film.error import picture_error

    found = []
    for radius in radii:
        renderer = renderer_of(scene, diffuse_radius=radius, diffuse_photons=400_000, alpha=1.0)
        # so many photons would allow a fifth of these radii, all of them the same
        free = renderer.pilot.diffuse._replace(least=0.0, bound=renderer.scene.flat.radius)
        renderer.pilot = renderer.pilot._replace(diffuse=free)
        found.append(picture_error(film_of(renderer, passes), "Diffuse").bias)
        renderer.close()
    return {"radii": radii, "bias": found, "exponent": exponent(radii, found)}


def best_cpu(work) -> float:
    """Least CPU seconds of the process over REPEATS calls."""
    best = float("inf")
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        best = min(best, time.process_time() - begin)
    return best


def seconds_against_photons(scene, counts=(50_000, 100_000, 200_000, 400_000)) -> dict[str, Any]:
    """The photon pass."""
    from photon_engine.transport.photon_pass import run_for, trace_photons
    from photon_engine.transport.photon_rules import DIFFUSE

    seconds = []
    for n in counts:
        renderer = renderer_of(scene, diffuse_photons=n)
        run = run_for(renderer.settings, 0, DIFFUSE)
        seconds.append(best_cpu(lambda r=renderer, run=run: trace_photons(r.scene, r._pool, run, lambda: False)))
        renderer.close()
    return {"photons": counts, "seconds": seconds, "exponent": exponent(counts, seconds)}


def seconds_against_pixels(scene, sizes=(128, 256, 512)) -> dict[str, Any]:
    """A pass without photons."""
    frame, seconds = scene.frame, []
    for size in sizes:
        scene.frame = dataclasses.replace(frame, width=size, height=size, x1=size, y1=size)
        renderer = renderer_of(scene, diffuse_photons=0, caustic_photons=0)
        seconds.append(best_cpu(lambda r=renderer: r.render_pass(0, lambda: False)))
        renderer.close()
    scene.frame = frame
    pixels = [size * size for size in sizes]
    return {"pixels": pixels, "seconds": seconds, "exponent": exponent(pixels, seconds)}


def seconds_against_triangles(counts=(1_000, 10_000, 100_000, 1_000_000), rays: int = 200_000) -> dict[str, Any]:
    """Rays from the middle of a bumpy sphere of n triangles, by Embree as the engine calls it."""
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    rng = np.random.default_rng(0)
    d = rng.normal(size=(rays, 3)).astype(np.float32)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    o = np.zeros_like(d)
    nanoseconds = []
    for n in counts:
        rows = int(np.sqrt(n / 2))
        theta, phi = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, rows + 1), indexing="ij")
        radius = 1.0 + 0.1 * rng.random(theta.shape)
        unit = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        p = (radius * unit).reshape(3, -1).T
        i = (np.arange(rows)[:, None] * (rows + 1) + np.arange(rows)).ravel()
        lower, upper = (i, i + 1, i + rows + 1), (i + 1, i + rows + 2, i + rows + 1)
        faces = np.concatenate([np.stack(corners, 1) for corners in (lower, upper)])
        scene = rtcore_scene.EmbreeScene()
        TriangleMesh(scene, p.astype(np.float32), faces.astype(np.int32))
        scene.run(o[:8], d[:8])  # builds the tree
        nanoseconds.append(1e9 * best_cpu(lambda s=scene: s.run(o, d)) / rays)
    doublings = np.log2(counts[-1] / counts[0])
    return {
        "triangles": counts, "ns_per_ray": nanoseconds, "exponent": exponent(counts, nanoseconds),
        "ns_per_doubling": (nanoseconds[-1] - nanoseconds[0]) / doublings,
    }  # fmt: skip


def main() -> None:
    """Measure all and write the figures."""
    from benchmarks.run import load

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default=str(ROOT / "out" / "rates.json"))
    target = Path(parser.parse_args().output)
    small = load("cornell_caustics")
    small.frame = dataclasses.replace(small.frame, width=64, height=64, x1=64, y1=64)
    # its lamp of 0.1 m is seen in the glass by chance: 64 passes do not show the variance of that
    soft = dataclasses.replace(small, lights=[dataclasses.replace(small.lights[0], size=(0.5, 0.5))])
    result = {
        "noise_against_passes": noise_against_passes(soft),
        "bias_against_radius": bias_against_radius(small),
        "seconds_against_photons": seconds_against_photons(small),
        "seconds_against_pixels": seconds_against_pixels(small),
        "seconds_against_triangles": seconds_against_triangles(),
    }
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(result, indent=1, default=float))
    print(json.dumps(result, indent=1, default=float))


if __name__ == "__main__":
    main()
