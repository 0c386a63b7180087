"""Enabling the extension costs Blender little, and a process of low priority compiles the kernels."""

import json
import os
import subprocess
import sys
from pathlib import Path

from photon_engine.blender import warm

ROOT = Path(__file__).resolve().parent.parent
ENABLING = """
import os, sys
import bpy
import photon_engine
photon_engine.register()
print("loaded", *(name for name in ("numba", "llvmlite", "scipy", "embreex") if name in sys.modules))
sys.stdout.flush()
os._exit(0)
"""
COMPILED = """
import gc, sys
from numba.core.dispatcher import Dispatcher
from photon_engine.transport.warm import warm_up
def signatures():
    return {(d.py_func.__module__, d.py_func.__name__, str(s)) for d in gc.get_objects() if isinstance(d, Dispatcher)
            for s in d.signatures if d.py_func.__module__.startswith("photon_engine")}
warm_up()
slow = [name for name in ("linalg", "ndimage", "optimize", "spatial", "stats") if f"scipy.{name}" in sys.modules]
import scipy.linalg.cython_blas  # it was hidden from numba
from photon_engine.transport.tests.plan_scenes import scene
from photon_engine.transport.tests.test_plan import render
before = signatures()
lamps = ["Spot", "Soft Sun", "Beam"]
render(scene("Painted", "Polished", "Plastic", lamps=lamps, sky=0.5, aperture=0.1), final_gather="ALL")
render(scene("Matte", "Half", "Glow", lamps=["Point"], ghost=True), {"Caustic", "Direct"})
print(slow, len(before), sorted(signatures() - before))
"""

# what each render of a matte scene under a point lamp adds, and the kernels that it is the first to call
FEATURES = [
    ({}, {"Depth"}, {"camera_kernels.camera_rays", "eye_kernels.eye_step", "materials.look_up", "rng.stream_key"}),
    ({}, {"Direct"}, {"direct_kernels.sample_lights", "direct_kernels.add_unoccluded"}),
    ({"lamps": ["Bulb"]}, {"Direct"}, {"direct_kernels.sample_lobes", "second_kernels.second_step"}),
    ({"lamps": ["Bulb"]}, {"Emission"}, {"camera_kernels.further_rays", "camera_kernels.draw_points",
                                         "glints.mixture"}),
    ({"sky": 0.5, "aperture": 0.1}, {"Environment"}, set()),
    ({"pane": "Half"}, {"Direct"}, {"direct_kernels.attenuate_shadows"}),
    ({}, {"Diffuse"}, {"clearing_kernels", "cull.compact", "gather_kernels.gather", "map._count_sort", "map.row_hash",
                       "photon_kernels.add_up", "photon_kernels.emit_everywhere", "photon_kernels.photon_step",
                       "radius.nearest_in_order"}),
    ({"wall": "Polished"}, {"Diffuse"}, {"second_kernels.narrow_points"}),
    ({"pane": "Glass"}, {"Caustic"}, {"islands.join_edges", "photon_kernels.emit_at_targets", "targets.estimate_flux"}),
    ({"pane": "Ink"}, {"Caustic"}, {"media.absorb"}),
    ({"pane": "Painted"}, {"Direct"}, {"surface.surface_points"}),
    ({"pane": "Wax"}, {"Direct"}, {"deep_kernels.draw_all", "deep_kernels.eyes_below", "walk_kernels.aim",
                                   "walk_kernels.advance"}),
    ({"pane": "Wax"}, {"Diffuse"}, {"deep_kernels.landings_below", "deep_kernels.photons_below",
                                    "deep_kernels.photons_out"}),
]  # fmt: skip
CALLED = """
import gc, json, sys
from numba.core.dispatcher import Dispatcher
from photon_engine.linkage import Part
from photon_engine.transport.tests.plan_scenes import scene
from photon_engine.transport.tests.test_plan import render
def called():
    found = [d for d in gc.get_objects() if isinstance(d, Dispatcher) and not isinstance(d, Part) and d.signatures]
    names = [(d.py_func.__module__.split("."), d.py_func.__name__) for d in found]
    names = [(module[-1], name) for module, name in names if module[0] == "photon_engine"]
    return {module if module == "clearing_kernels" else f"{module}.{name}" for module, name in names}
before, out = set(), []
for more, outputs in json.loads(sys.argv[1]):
    render(scene(**{"pane": "Matte", "lamps": ["Point"], **more}), outputs)
    out.append(sorted(called() - before))
    before = called()
print(json.dumps(out))
"""


def run(code, *arguments):
    """What a process of this tree prints at the end."""
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, env=env, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def test_enabling_is_quick_and_loads_nothing_heavy():
    """`make bench` times it."""
    assert run(ENABLING) == "loaded"


def test_after_warming_up_no_scene_compiles_anything():
    """Nor has it loaded the parts of scipy that take longer to import than a first pass takes."""
    slow, count, new = run(COMPILED).split(" ", 2)
    assert slow == "[]" and int(count) > 10 and new == "[]"


def test_no_kernel_is_compiled_for_what_a_scene_does_not_have():
    told = json.loads(run(CALLED, json.dumps([(more, sorted(outputs)) for more, outputs, _ in FEATURES])))
    assert [set(names) for names in told] == [names for _, _, names in FEATURES]


def test_warming_runs_once_under_blenders_name_for_the_extension(tmp_path, monkeypatch):
    monkeypatch.setenv("PHOTON_MAP_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "repository" / "extension" / "photon_engine"
    (folder / "transport").mkdir(parents=True)
    for path in (folder, folder / "transport"):
        (path / "__init__.py").write_text("")
    (folder / "__init__.py").write_text("MARK = 7\n")
    told = tmp_path / "told"
    code = (
        "import os, pathlib\nfrom .. import MARK\ndef warm_up():\n"
        f"    pathlib.Path({str(told)!r}).write_text(f'{{__name__}} {{MARK}} {{os.nice(0)}}')\n"
    )
    (folder / "transport" / "warm.py").write_text(code)
    package = "bl_ext.repository.extension.photon_engine"
    child = warm.start(package, folder)
    assert child.wait(280) == 0
    name, mark, nice = told.read_text().split()
    assert name == f"{package}.transport.warm" and mark == "7" and int(nice) == 19
    assert warm.start(package, folder) is None
    (folder / "transport" / "warm.py").write_text(code + "# another version\n")
    assert warm.mark(folder).exists() is False


def test_warming_that_fails_is_tried_again(tmp_path, monkeypatch):
    monkeypatch.setenv("PHOTON_MAP_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "without_a_warm_module"
    folder.mkdir()
    assert warm.start(folder.name, folder).wait(280) != 0
    again = warm.start(folder.name, folder)
    assert again is not None and again.wait(280) != 0
