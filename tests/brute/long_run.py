"""A long run of the reference tracer: ``python -m tests.brute SCENE.npz|SCENE.blend -o ref.exr --minutes M``.

Writes the sum of all classes to ref.exr and each class to ref.CLASS.exr, with standard errors (tests/oracle/images.py).
Caustics and diffuse light that the eye sees directly come from paths of the lights, the rest from paths of the eye.
"""

import argparse
import multiprocessing
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from photon_engine.issues import IssueLog
from photon_engine.scene.io import load_scene, save_scene

from .compiled import compile_scene
from .harness import reference
from .path_tracer import CLASSES


def parse(arguments):
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.brute", description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--resolution", type=lambda text: tuple(map(int, text.split("x"))), help="WxH, .blend only")
    parser.add_argument("--spp", type=int, default=8, help="eye paths a pixel in each batch")
    parser.add_argument("--photons", type=int, default=250_000, help="light paths in each batch; 0: eye paths only")
    return parser.parse_args(arguments)


def from_blend(path, resolution, folder):
    """A .blend as a scene file in the folder."""
    from photon_engine.blender.load import Options, load_blend

    scene, _, _ = load_blend(path, Options(resolution=resolution), IssueLog())
    out = Path(folder) / "scene.npz"
    save_scene(scene, out)
    return out


def work(path, spp, photons, seconds, seeds):
    """(n, sums, sums of squares) of batches until time is up, at least two; sums: name -> (h, w, 3)."""
    scene = load_scene(path)
    end, n, total, squares = time.monotonic() + seconds, 0, {}, {}
    for seed in seeds:
        batch = reference(scene, 2 * spp, photons, batches=1, first_seed=seed)
        light = {name: batch[name][0] * scene.frame.exposure for name in CLASSES}
        light["Combined"] = sum(light.values())
        for name, picture in light.items():
            total[name] = total.get(name, 0.0) + picture
            squares[name] = squares.get(name, 0.0) + picture * picture
        n += 1
        if n > 1 and time.monotonic() > end:
            break
    return n, total, squares


def run(arguments):
    """Render and write; the number of batches."""
    from tests.oracle.images import Reference, write_reference

    options = parse(arguments)
    with tempfile.TemporaryDirectory() as folder:
        path = options.scene
        if path.suffix == ".blend":
            path = from_blend(path, options.resolution, folder)
        compile_scene(load_scene(path))  # what is wrong with it shows here, not in a child
        jobs = [
            (path, options.spp, options.photons, 60 * options.minutes, range(1 + k, 1 << 30, options.processes))
            for k in range(options.processes)
        ]
        context = multiprocessing.get_context("spawn")  # Blender, perhaps loaded here, does not survive a fork
        with ProcessPoolExecutor(options.processes, context) as pool:
            parts = list(pool.map(work, *zip(*jobs, strict=True)))
    n = sum(part[0] for part in parts)
    meta = {"renderer": "tests/brute", "batches": n, "spp": n * options.spp, "photons": n * options.photons}
    for name in ("Combined", *CLASSES):
        mean = sum(part[1][name] for part in parts) / n
        variance = np.maximum(sum(part[2][name] for part in parts) / n - mean * mean, 0.0)
        path = options.output if name == "Combined" else options.output.with_suffix(f".{name}.exr")
        error = np.sqrt(variance / (n - 1))
        write_reference(path, Reference(mean.astype(np.float32), error.astype(np.float32), {**meta, "class": name}))
    return n
