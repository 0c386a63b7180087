"""The samples: small, complete, what their scripts build, and rendered like their references."""

from __future__ import annotations

import importlib
import os

import numpy as np
import pytest

from sample_blends import references
from sample_blends.builders import SAMPLES
from tests.oracle import cycles, images, ours

bpy = pytest.importorskip("bpy")

FAILED = cycles.ROOT / "out" / "agreement"
THOROUGH = os.environ.get("PHOTON_MAP_AGREEMENT") == "all"  # a verdict on every block: about an hour on two cores
MOST_TRIANGLES = 200_000
FROSTED = np.s_[40:64, 40:56]  # pixels of the rough glass ball of material_shelf
MOST_BYTES = 1_000_000
# part of the light in blocks with a verdict; the water of pool_soft would take Cycles hours (its mean: 1.0002)
LEAST_JUDGED = {"pool_soft": 0.25}


def triangles(scene) -> int:
    """Triangles of the meshes of a scene as they stand in the file."""
    total = 0
    for item in scene.objects:
        if item.type == "MESH":
            item.data.calc_loop_triangles()
            total += len(item.data.loop_triangles)
    return total


def open_sample(name: str):
    bpy.ops.wm.open_mainfile(filepath=str(references.HERE / f"{name}.blend"))
    return bpy.context.scene


@pytest.mark.parametrize("name", SAMPLES)
def test_sample_is_small_and_complete(name):
    assert (references.HERE / f"{name}.blend").stat().st_size < MOST_BYTES
    scene = open_sample(name)
    assert (scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage) == (256, 256, 100)
    assert scene.camera is not None
    assert not bpy.data.libraries
    for image in bpy.data.images:
        assert image.packed_file or image.type in ("RENDER_RESULT", "COMPOSITING"), f"{image.name} is not packed"
    count = triangles(scene)
    assert count <= MOST_TRIANGLES

    importlib.import_module(f"sample_blends.builders.{name}").build()
    assert triangles(bpy.context.scene) == count, "the .blend is not what its script builds: run sample_blends/build.py"


def test_every_sample_says_where_its_reference_comes_from():
    assert set(SAMPLES) <= {*references.CYCLES, *references.BEAMS}
    assert not set(references.CYCLES) & set(references.BEAMS)
    assert set(references.existing()) == {*references.CYCLES, *references.BEAMS}
    for name in references.CYCLES:
        reference = images.read_reference(references.path_of(name))
        assert reference.mean.shape == (references.SIZE, references.SIZE, 3)
        assert np.isfinite(reference.mean).all() and (reference.se >= 0.0).all()
        assert reference.meta["renderer"].startswith("Cycles") and reference.meta["spp"] >= 1000


def open_for(name: str) -> None:
    """Make the scene of a reference current, at the reference's size."""
    job = references.CYCLES.get(name)
    if job and job.builder:
        cycles.open_scene(job)
    else:
        open_sample(name)
    render = bpy.context.scene.render
    render.resolution_x = render.resolution_y = references.SIZE
    render.resolution_percentage = 100


@pytest.mark.slow
@pytest.mark.parametrize("name", references.existing())
def test_sample_agrees_with_its_reference(name):
    """16x16-block means within 1% outside noise; references of all kinds that exist."""
    open_for(name)
    reference = images.read_reference(references.path_of(name))
    picture = ours.render_current(max_passes=400 if THOROUGH else 24)
    report = ours.judge(picture, reference)
    print(f"{name}: {picture.passes} passes, {picture.seconds:.1f} s; {report}")
    judged = report.judged >= LEAST_JUDGED.get(name, 0.5)
    good = judged and not report.out if THOROUGH else agrees_so_far(report)
    if not good:
        difference = 0.5 + 4.0 * (picture.mean - reference.mean)
        images.write_png(FAILED / f"{name}.png", [picture.mean, reference.mean, difference], zoom=3)
    if name == "material_shelf":  # came out 1.08; 1.63 when the ball took the photons of the shelf that it lies on
        assert abs(picture.mean[FROSTED].mean() / reference.mean[FROSTED].mean() - 1.0) < 0.2
    assert good, f"{report}\nissues: {[str(issue) for issue in picture.issues]}"


def agrees_so_far(report) -> bool:
    """What 24 passes can tell: the picture's mean, and that no block is off by more than noise and 1%.

    Means came out between 0.9896 and 1.009 of the references; of the blocks, 2 of 192 were out in one sample whose
    reference has error bars of few batches.
    """
    return abs(report.mean_ratio - 1.0) < 0.02 and len(report.out) <= 0.02 * report.count
