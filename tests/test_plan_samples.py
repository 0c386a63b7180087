"""Every sample has the same pictures with and without the plan, pass by pass.

To the bit, but for Direct under a narrow sun and the sky: there the plan gives the sky more of the shadow rays.
"""

from pathlib import Path

import numpy as np
import pytest

from photon_engine.blender.load import Options, load_blend
from photon_engine.film.passes import usual_outputs
from photon_engine.issues import IssueLog
from photon_engine.settings import Settings
from photon_engine.shading.material import compile_material
from photon_engine.transport import materials
from photon_engine.transport.renderer import Renderer

SAMPLES = Path(__file__).resolve().parent.parent / "sample_blends"
NAMES = ("cornell_caustics", "diffuse_room", "material_shelf", "pool", "ring_cardioid", "wine_glass")
OTHER_NUMBERS = {"diffuse_room": "Direct", "pool": "Direct"}
NEEDS_ALL_RAYS = {"cornell_caustics"}  # too few of its photons fly past all boxes to be worth a look
USUAL = usual_outputs("OFF")
LIGHT = ("Direct", "Caustic", "Diffuse", "Emission", "Environment")


@pytest.fixture(scope="module")
def scenes():
    """All samples, 24 x 24 pixels."""
    return {
        name: load_blend(SAMPLES / f"{name}.blend", Options(resolution=(24, 24)), IssueLog())[0] for name in NAMES
    }


def passes_of(scene, plan, outputs=USUAL, count=1):
    """Some passes, and the renderer that made them."""
    settings = Settings(plan=plan, threads=1, caustic_photons=4000, diffuse_photons=4000)
    renderer = Renderer(scene, settings, IssueLog(), frozenset(outputs))
    renderer.prepare(lambda _text: None)
    pictures = [renderer.render_pass(i, lambda: False) for i in range(count)]
    renderer.close()
    return pictures, renderer


@pytest.mark.parametrize("name", NAMES)
def test_a_sample_is_the_same_picture(scenes, name):
    (planned,), renderer = passes_of(scenes[name], plan=True)
    (whole,), off = passes_of(scenes[name], plan=False)
    assert renderer.plan.sun_rays.runs == (name not in OTHER_NUMBERS)
    for key in (*LIGHT, "Alpha", "Depth", "Normal", "Albedo"):
        if key != OTHER_NUMBERS.get(name):
            np.testing.assert_array_equal(planned[key], whole[key], err_msg=f"{key}: {renderer.plan}")
    spared = sum(off.statistics["rays"].values()) - sum(renderer.statistics["rays"].values())
    assert whole["Direct"].any()
    assert spared > 0 or (spared == 0 and name in NEEDS_ALL_RAYS)


def test_samples_without_textures_have_no_uvs_and_look_nothing_up(scenes, monkeypatch):
    """Nor tangents, attributes, generated coordinates; diffuse_room's .blend has 23 UV layers to ask for."""

    def looked_up(*_arguments):
        raise AssertionError("hits were looked up")

    plain = []
    for name in NAMES:
        needs = frozenset().union(
            *(compile_material(m, scenes[name].images, IssueLog()).needs for m in scenes[name].materials)
        )
        if any(need.partition(":")[0] in ("uv", "tangent", "attribute", "generated", "island") for need in needs):
            continue
        plain.append(name)
        for mesh in scenes[name].meshes:
            assert (mesh.uvs, mesh.tangents, mesh.attributes) == ({}, {}, {})
            assert mesh.generated is None and mesh.island_random is None
    assert {"diffuse_room", "ring_cardioid", "wine_glass"} <= set(plain)
    monkeypatch.setattr(materials, "fill_attributes", looked_up)
    (picture,), renderer = passes_of(scenes["diffuse_room"], True)
    assert not renderer.plan.textures and picture["Direct"].any()
    assert renderer.scene.materials.objects is None and renderer.scene.materials.varying == []


@pytest.mark.parametrize("name", OTHER_NUMBERS)
def test_direct_light_of_sun_and_sky_is_the_same_within_its_noise(scenes, name):
    count = 24
    planned, whole = (
        np.stack([image["Direct"].mean(axis=2) for image in passes_of(scenes[name], plan, {"Direct"}, count)[0]])
        for plan in (True, False)
    )
    mean, noise = planned.mean(axis=(1, 2)), whole.mean(axis=(1, 2))
    error = np.sqrt((mean.var(ddof=1) + noise.var(ddof=1)) / count)
    assert abs(mean.mean() - noise.mean()) < 3.5 * error and error < 0.04 * noise.mean()
    if name == "diffuse_room":  # relative variance, 0.71 of 256 x 256 pixels: most of it is of the sky
        weight = 1.0 / (whole.mean(axis=0) ** 2 + 0.01)
        assert (planned.var(axis=0) * weight).mean() < 0.9 * (whole.var(axis=0) * weight).mean()


@pytest.mark.parametrize("only", LIGHT)
def test_one_picture_alone_is_that_of_the_whole_render(scenes, only):
    (alone,), _ = passes_of(scenes["material_shelf"], True, {only})
    (whole,), _ = passes_of(scenes["material_shelf"], True)
    np.testing.assert_array_equal(alone[only], whole[only])
