"""`make bench`: how fast, as ratios taken in one run, printed and written as JSON with machine and commit.

- photon pass: rays a second against bare EmbreeScene.run on the very same rays, one thread
- threads: two against one, beside what Embree alone and numpy's sort gain by the second in the same minute
- error against time: relMSE of cornell_caustics (0.5 m light) at 256 x 256 against converged Cycles
- start: cold (empty kernel cache) and warm, to the first finished pass
- Blender's side: enabling the extension, reading a million triangles
- materials: microseconds a hit of 30 nodes, nanoseconds an image lookup beside OpenImageIO's
- plan: what leaving out the needless is worth (`python -m benchmarks.plan` for all samples)
- memory: bytes a stored photon in the map, peak of the process
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "benchmarks" / "cornell_caustics_soft_256.exr"
PROTOTYPE = [[1.2, 0.0206], [2.2, 0.0119], [4.0, 0.0076], [7.2, 0.0055]]  # one thread of a like machine
sys.path.insert(0, str(ROOT))


def load(name: str):
    """SceneData of a sample, saved as .npz by a process that has Blender."""
    from photon_engine.scene.io import load_scene

    target = Path(tempfile.gettempdir()) / f"photon_map_bench_{name}.npz"
    source = ROOT / "sample_blends" / f"{name}.blend"
    command = [sys.executable, "-m", "photon_engine", "extract", str(source), "-o", str(target)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return load_scene(target)


def photon_pass(renderer, mode: int, iteration: int, pool) -> tuple[float, int]:
    """Seconds and rays of one photon pass."""
    from photon_engine.transport.photon_pass import run_for, trace_photons

    start = time.perf_counter()
    run = run_for(renderer.settings, iteration, mode)
    _, _, rays = trace_photons(renderer.scene, pool, run, lambda: False, renderer.rooms)
    return time.perf_counter() - start, rays


def rays_of(renderer, mode: int, iteration: int, pool) -> list[tuple[np.ndarray, np.ndarray]]:
    """The batches of rays (o, d) that a photon pass traces."""
    batches = []
    closest = renderer.scene.intersector.closest

    def record(o, d, t_max=None):
        batches.append((o.copy(), d.copy()))
        return closest(o, d, t_max)

    renderer.scene.intersector.closest = record
    photon_pass(renderer, mode, iteration, pool)
    renderer.scene.intersector.closest = closest
    return batches


def seconds_of(pool, work, items) -> float:
    """Seconds in which the threads of a pool do work(item) for all items."""
    start = time.perf_counter()
    list(pool.map(work, items))
    return time.perf_counter() - start


def trace_speed(scene, settings, repeats: int = 25) -> dict:
    """Photon passes against bare Embree, and two threads against one.

    The second core of a shared machine is no whole core: what Embree alone and numpy's sort gain by a second thread is
    measured beside each pass.
    """
    from photon_engine.issues import IssueLog
    from photon_engine.transport.photon_rules import DIFFUSE
    from photon_engine.transport.renderer import Renderer

    renderer = Renderer(scene, settings, IssueLog())
    renderer.prepare(lambda text: None)
    raw = renderer.scene.intersector._scene
    unsorted = [np.random.default_rng(i).random(500_000, np.float32) for i in range(8)]
    pools = ThreadPoolExecutor(1), ThreadPoolExecutor(2)
    photon_pass(renderer, DIFFUSE, 0, pools[1])
    ours, bare, plain, rates = [], [], [], []  # seconds with one and with two threads
    for i in range(1, repeats + 1):
        ours.append([photon_pass(renderer, DIFFUSE, i, pool)[0] for pool in pools])
        plain.append([seconds_of(pool, np.sort, unsorted) for pool in pools])
        batches = rays_of(renderer, DIFFUSE, i, pools[0])  # last: they leave caches and heap to others
        bare.append([seconds_of(pool, lambda rays: raw.run(*rays, output=1), batches) for pool in pools])
        rates.append(sum(len(o) for o, _ in batches) / ours[-1][0])
    renderer.render_pass(0, lambda: False)
    stored = renderer.statistics["photons"]
    renderer.close()
    gains = {name: [one / two for one, two in times] for name, times in (("ours", ours), ("bare", bare))}
    return {
        "rays_per_second_1_thread": statistics.median(rates),
        "of_bare_embree": statistics.median(b[0] / o[0] for b, o in zip(bare, ours, strict=True)),
        "of_bare_embree_by_least_times": min(b[0] for b in bare) / min(o[0] for o in ours),
        "two_threads_over_one": statistics.median(gains["ours"]),
        "two_threads_over_one_bare_embree": statistics.median(gains["bare"]),
        "two_threads_over_one_numpy_sort": statistics.median(one / two for one, two in plain),
        "two_threads_ours_over_bare_embree": statistics.median(
            mine / its for mine, its in zip(gains["ours"], gains["bare"], strict=True)
        ),
        "photons_stored": stored,
        "map_bytes": renderer.statistics["map_bytes"],
    }


def start_up(npz_scene_name: str) -> dict:
    """Seconds from process start to the first pass, with an empty and with a filled kernel cache."""
    code = (
        "import time; t = time.perf_counter();"
        "from photon_engine.scene.io import load_scene; from photon_engine.settings import Settings;"
        "from photon_engine.issues import IssueLog; from photon_engine.transport.renderer import Renderer;"
        f"r = Renderer(load_scene(r'{npz_scene_name}'), Settings(), IssueLog()); r.prepare(lambda s: None);"
        "r.render_pass(0, lambda: False); print(time.perf_counter() - t)"
    )
    seconds = {}
    with tempfile.TemporaryDirectory() as cache:
        env = {**os.environ, "PHOTON_MAP_CACHE": cache}
        for name in ("cold", "warm"):
            done = subprocess.run(
                [sys.executable, "-c", code], cwd=ROOT, env=env, check=True, capture_output=True, text=True
            )
            seconds[name] = float(done.stdout.split()[-1])
    return seconds


def blender_side() -> dict:
    """Figures of blender_side.py, in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.blender_side"]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def relative_mse(picture: np.ndarray, reference: np.ndarray) -> float:
    """mean((x - ref)^2 / (ref^2 + 0.01))."""
    return float(np.mean((picture - reference) ** 2 / (reference**2 + 0.01)))


def error_curve(scene, settings, reference: np.ndarray, marks=(1, 2, 4, 8, 16, 32)) -> list[dict]:
    """relMSE of the mean of the first passes against seconds."""
    from photon_engine.issues import IssueLog
    from photon_engine.transport.renderer import Renderer

    renderer = Renderer(scene, settings, IssueLog())
    renderer.prepare(lambda text: None)
    renderer.render_pass(10_000, lambda: False)  # kernels are loaded before the clock starts
    total = np.zeros(reference.shape)
    curve, seconds = [], 0.0
    for i in range(max(marks)):
        start = time.perf_counter()
        image = renderer.render_pass(i, lambda: False)
        total += sum(image[name] for name in ("Direct", "Caustic", "Diffuse", "Emission", "Environment"))
        seconds += time.perf_counter() - start
        if i + 1 in marks:
            curve.append({"passes": i + 1, "seconds": seconds, "relMSE": relative_mse(total / (i + 1), reference)})
    stages = {k: round(v, 3) for k, v in renderer.statistics["seconds"].items()}
    renderer.close()
    return [*curve, {"stages": stages}]


def reference_curve() -> dict:
    """Our error on the box with the 0.5 m light, beside the figures of the prototype that the engine must beat."""
    import OpenImageIO as oiio

    scene = load("cornell_caustics")
    scene.lights[0].size = (0.5, 0.5)
    source = oiio.ImageInput.open(str(REFERENCE))
    spec = source.spec()
    pixels = np.array(source.read_image(format="float")).reshape(spec.height, spec.width, -1)[::-1, :, :3]
    from photon_engine.settings import Settings

    return {"ours": error_curve(scene, Settings(), pixels), "prototype_seconds_relMSE": PROTOTYPE}


def main() -> None:
    """Run everything and write out/bench.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default=str(ROOT / "out" / "bench.json"))
    target = Path(parser.parse_args().output)
    from benchmarks import materials
    from benchmarks.plan import worth
    from photon_engine.settings import Settings

    scene = load("cornell_caustics")
    result = {
        "machine": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "commit": subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip(),
        "trace": trace_speed(scene, Settings(diffuse_photons=400_000)),
        "start": start_up(str(Path(tempfile.gettempdir()) / "photon_map_bench_cornell_caustics.npz")),
        "blender": blender_side(),
        "materials": materials.measure(),
        "error": reference_curve(),
        "plan": worth(("diffuse_room", "pool"), repeats=1, passes=4),
        "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(result, indent=1, default=float))
    print(json.dumps(result, indent=1, default=float))


if __name__ == "__main__":
    main()
