"""Our pictures against converged Cycles: one scene for each light, material, texture, camera option and shape.

Means over blocks of 16x16 pixels agree within 1% outside noise (see oracle/compare.py). The references are stored in
tests/references/ (``python -m tests.oracle.references`` makes them), so that no Cycles time is needed here.
"""

from __future__ import annotations

import os

import pytest

from tests import scenes
from tests.oracle import images, ours, references, shared

bpy = pytest.importorskip("bpy")

ALL = sorted(scenes.all_scenes())
# the scenes of `make test`; PHOTON_MAP_AGREEMENT=all runs every one (about half an hour on two cores)
QUICK = (
    "area_disk area_spread area_square curve_and_text depth_of_field diffuse_rough displacement_true fresnel_mix "
    "glass_clear glass_rough glossy_02 glossy_multiscatter hidden_and_holdout image_linear many mirrored_glass "
    "normal_map point_soft point_sphere principled_alpha principled_coat principled_default principled_metal "
    "principled_transmission smooth_and_flat spot_ellipse spot_soft subsurface sun_delta sun_wide "
    "textured_glow through_veil translucent world_sky world_sun"
).split()
CHOSEN = ALL if os.environ.get("PHOTON_MAP_AGREEMENT") == "all" else QUICK
FAILED = references.cycles.ROOT / "out" / "agreement"  # pictures of what failed: ours, Cycles', 4 x difference
PASSES = int(os.environ.get("PHOTON_MAP_AGREEMENT_PASSES", "96"))  # for each scene, unless low noise ends it earlier
# half of the light must be known well enough for a verdict
MORE = {
    "emissive_ball": {"light_samples": 12}, "textured_glow": {"light_samples": 12},
    # few photons of a ground of 48 m fall where the camera looks: rays collect them from farther around
    "clevr_objects": {"final_gather": "ALL", "diffuse_photons": 200_000},
}
# Cycles needs hours for a verdict on single blocks: none may be out of its noise, and the whole picture is judged,
# whose mean it knows to 0.2% (8768 samples a pixel, blocks to 5%)
WHOLE = {"blenderdiplom_glass"}


def check(name: str, passes: int = PASSES) -> None:
    """Render the current scene and compare it with the stored reference."""
    reference = images.read_reference(references.path_of(name))
    picture = ours.render_current(ours.SETTINGS.replace(**MORE.get(name, {})), max_passes=passes)
    report = ours.judge(picture, reference)
    print(f"{name}: {picture.passes} passes, {picture.seconds:.1f} s; {report}")
    agrees = report.agrees
    if name in WHOLE:
        agrees = not report.out and abs(report.mean_ratio - 1.0) < 0.01
    if not agrees:
        difference = 0.5 + 4.0 * (picture.mean - reference.mean)
        images.write_png(FAILED / f"{name}.png", [picture.mean, reference.mean, difference], zoom=4)
    assert agrees, f"{report}\nissues: {[str(issue) for issue in picture.issues]}"


@pytest.mark.slow
@pytest.mark.parametrize("name", CHOSEN)
def test_small_scene(name):
    scenes.build(name)
    check(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(references.SHARED_JOBS))
def test_shared_scene(name):
    if not shared.path_of(name).is_file():
        pytest.skip("../shared/scenes is not beside this clone")
    shared.build(name)
    check(name)


def test_every_scene_has_a_reference():
    missing = [name for name in (*ALL, *references.SHARED_JOBS) if not references.path_of(name).is_file()]
    assert not missing, f"run python -m tests.oracle.references {' '.join(missing)}"
