"""What leaving out the needless is worth: `python -m benchmarks.plan` prints a table and figures, and writes JSON.

Each sample is rendered with the plan, with plan=off, and (pool) for Caustic alone, each in a process of its own, in
turn. Seconds are processor time of one thread: other programs on the machine count little. To equal error: seconds
times the relative variance of a pass, mean over pixels of var / (mean^2 + 0.01); most pictures have the same bits.
With --cold, also the processor time from an empty kernel cache to the first pass. The second frame is the same scene in
new objects, its camera moved, with what the first left.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SAMPLES = ("cornell_caustics", "diffuse_room", "material_shelf", "pool", "ring_cardioid", "wine_glass")
CHILD = """
import copy, json, resource, sys, time
import numpy as np
from photon_engine.film.passes import LIGHT_NAMES, usual_outputs
from photon_engine.issues import IssueLog
from photon_engine.scene.io import load_scene
from photon_engine.settings import Settings
from photon_engine.transport.renderer import Renderer
path, plan, only, passes, size = sys.argv[1], sys.argv[2] == "on", sys.argv[3], int(sys.argv[4]), int(sys.argv[5])
scene = load_scene(path)
if size:
    scene.frame.width = scene.frame.height = scene.frame.x1 = scene.frame.y1 = size
outputs = frozenset(only.split(",")) if only else usual_outputs("OFF")
renderer = Renderer(scene, Settings(plan=plan, threads=1), IssueLog(), outputs)
start = time.process_time()
renderer.prepare(lambda text: None)
prepared = time.process_time() - start
seconds, lights = [], []
for i in range(passes):
    start = time.process_time()
    image = renderer.render_pass(i, lambda: False)
    seconds.append(time.process_time() - start)
    lights.append(sum(image[name] for name in LIGHT_NAMES))
lights = np.array(lights)
first = time.process_time()
noise = float((lights.var(axis=0) / (lights.mean(axis=0) ** 2 + 0.01)).mean())
uvs = sum(uv.nbytes for mesh in scene.meshes for uv in mesh.uvs.values())
statistics = renderer.statistics
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
renderer.close()
moved = copy.deepcopy(scene)
moved.camera.matrix[:3, 3] += 0.01
again = Renderer(moved, Settings(plan=plan, threads=1), IssueLog(), outputs, renderer.kept)
start = time.process_time()
again.prepare(lambda text: None)
second = time.process_time() - start
again.close()
print(json.dumps({
    "second_prepare": second, "flattened": renderer.kept.flattened, "trees": renderer.kept.built,
    "variance": noise, "first": first, "prepare": prepared, "pass": min(seconds[1:] or seconds),
    "rays": sum(statistics["rays"].values()) / passes, "photons": sum(statistics["photons"].values()) / passes,
    "map_MB": statistics["map_bytes"] / 2**20, "peak_MB": peak,
    "uv_MB": uvs / 2**20,
}))
"""


def extract(name: str, folder: Path) -> Path:
    """The sample as SceneData, by a process that has Blender."""
    target = folder / f"{name}.npz"
    command = [sys.executable, "-m", "photon_engine", "extract", f"sample_blends/{name}.blend", "-o", str(target)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return target


def run(scene: Path, plan: str, only: str = "", passes: int = 1, size: int = 0, cache: str | None = None) -> dict:
    """One render in a process of its own."""
    env = {**os.environ, "PYTHONPATH": str(ROOT), **({"PHOTON_MAP_CACHE": cache} if cache else {})}
    command = [sys.executable, "-c", CHILD, str(scene), plan, only, str(passes), str(size)]
    done = subprocess.run(command, cwd=ROOT, env=env, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def measure(scene: Path, ways: dict[str, tuple[str, str]], repeats: int, passes: int) -> dict[str, dict]:
    """Medians over repeats of each way (plan, only), in turn."""
    runs: dict[str, list[dict]] = {way: [] for way in ways}
    for _ in range(repeats):
        for way, (plan, only) in ways.items():
            runs[way].append(run(scene, plan, only, passes))
    return {
        way: {key: statistics.median(item[key] for item in items) for key in items[0]} for way, items in runs.items()
    }


def cold(scene: Path, ways: dict[str, tuple[str, str]]) -> dict[str, float]:
    """Processor seconds from an empty cache to the first pass, of a small picture."""
    out = {}
    for way, (plan, only) in ways.items():
        with tempfile.TemporaryDirectory() as cache:
            out[way] = run(scene, plan, only, size=16, cache=cache)["first"]
    return out


def table(results: dict[str, dict]) -> str:
    """The README's table: with the plan, and without it in brackets."""
    lines = [
        "| sample | s a pass | times faster | to equal error | rays | photons stored | map MB | peak MB | cold s |",
        "|---" * 9 + "|",
    ]
    for name, ways in results.items():
        off = ways["off"]
        for way, on in ways.items():
            if way == "off":
                continue
            label = name if way == "on" else f"{name}, {way}"
            cells = [f"{on[key] * scale:.{digits}f} ({off[key] * scale:.{digits}f})" for key, scale, digits in (
                ("rays", 1e-3, 0), ("photons", 1e-3, 0), ("map_MB", 1, 1), ("peak_MB", 1, 0))]  # fmt: skip
            cells[0], cells[1] = f"{cells[0]} k", f"{cells[1]} k"
            equal = f"{off['pass'] * off['variance'] / (on['pass'] * on['variance']):.2f}" if way == "on" else "-"
            start = f"{on['cold']:.0f} ({off['cold']:.0f})" if "cold" in on else "-"
            lines.append(f"| {label} | {on['pass']:.2f} ({off['pass']:.2f}) | {off['pass'] / on['pass']:.2f} | "
                         + f"{equal} | " + " | ".join(cells) + f" | {start} |")  # fmt: skip
    return "\n".join(lines)


def figures(results: dict[str, dict]) -> str:
    """What the plan promises, one line each, of the samples that were measured."""
    lines = []
    if room := results.get("diffuse_room"):
        on, off = room["on"], room["off"]
        gain = off["pass"] * off["variance"] / (on["pass"] * on["variance"])
        lines.append(f"diffuse_room: {gain:.2f} times faster to equal error than with plan=off")
    if pool := results.get("pool"):
        alone = pool["Caustic only"]["pass"]
        lines.append(f"pool: Caustic alone is {pool['on']['pass'] / alone:.2f} times faster than all passes, "
                     f"{pool['off']['pass'] / alone:.2f} times than all with plan=off")  # fmt: skip
    bare = [name for name, ways in results.items() if ways["on"]["uv_MB"] == 0.0]
    lines.append(f"no UVs are allocated in: {', '.join(bare) or 'none'}")
    for name, ways in results.items():
        on = ways["on"]
        lines.append(f"{name}: {on['prepare']:.2f} s before the first pass, {on['second_prepare']:.2f} s where only "
                     f"the camera has moved; triangles and tree made {on['flattened']:.0f} and {on['trees']:.0f} times")
        if "cold" in on:
            lines.append(f"{name}: {on['cold']:.1f} s from an empty cache, {ways['off']['cold']:.1f} with plan=off")
    return "\n".join(lines)


def worth(samples: Iterable[str], repeats: int, passes: int, from_empty: bool = False) -> dict[str, dict]:
    """Figures by sample and way; from_empty: with the times from an empty kernel cache, minutes each."""
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in samples:
            scene = extract(name, Path(folder))
            ways = {"on": ("on", ""), "off": ("off", "")}
            if name == "pool":
                ways["Caustic only"] = ("on", "Caustic")
            run(scene, "off", size=16)  # kernels are compiled before anything is timed
            results[name] = measure(scene, ways, repeats, passes)
            if from_empty:
                for way, seconds in cold(scene, ways).items():
                    results[name][way]["cold"] = seconds
    return results


def main() -> None:
    """Measure, print the table, write JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("samples", nargs="*", default=list(SAMPLES))
    parser.add_argument("--cold", action="store_true")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--passes", type=int, default=6)
    parser.add_argument("-o", "--output", default=str(ROOT / "out" / "plan.json"))
    arguments = parser.parse_args()
    results = {}
    for name in arguments.samples:
        results |= worth([name], arguments.repeats, arguments.passes, arguments.cold)
        print(table({name: results[name]}), flush=True)
    target = Path(arguments.output)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(results, indent=1))
    print(table(results))
    print(figures(results))


if __name__ == "__main__":
    main()
