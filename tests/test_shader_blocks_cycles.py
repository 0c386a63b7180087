"""Every shader node on a lit sphere and a plane against Cycles, through the whole engine: a block of pixels each."""

from __future__ import annotations

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
oiio = pytest.importorskip("OpenImageIO")

from photon_engine.blender.extract import extract_scene  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402
from photon_engine.transport.renderer import Renderer  # noqa: E402
from tests.oracle.cycles import write_float_exr  # noqa: E402
from tests.test_bsdf_cycles import CASES, FILMS, OLD_FILMS, build_material, set_cycles  # noqa: E402

COLUMNS = 8
CELL = 16  # pixels
PASSES = 64
SAMPLES, SEEDS = 192, 6  # of Cycles, in so many pictures
TOLERANCE = 0.01
SIGMAS = 3.5  # of 400 numbers one is beyond by chance in 5 tests
DARK = 0.05  # of the mean of all blocks: darker ones are held to a hundredth of that
# with a lobe below the Specular Threshold, which direct light does not see: their mirrors are compared elsewhere
SHARP = {
    name for name in CASES
    if name.endswith("_0.0")
    or name in {"principled_smooth", "principled_glass", "principled_coat", "principled_film_bubble",
                "principled_film_half", "principled_lamp", "principled_coated_glass", "principled_alpha",
                "principled_sheen_coat"}
}  # fmt: skip
# through one surface into a medium: there Cycles does not scale radiance by 1 / eta^2; bodies are compared elsewhere
BENDS = {
    name for name in CASES
    if name.startswith(("glass_", "refraction_")) or name in {"principled_frosted", "principled_film_glass",
                                                              "principled_film_water", "film_glass"}
}  # fmt: skip
NAMES = [name for name in CASES if name not in SHARP | BENDS]


def build() -> None:
    """A ball on a square for each material, seen from above, under a sun and above another."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    rows = -(-len(NAMES) // COLUMNS)
    for i, name in enumerate(NAMES):
        node, props, sockets, _ = CASES[name]
        x, y = i % COLUMNS - COLUMNS / 2 + 0.5, i // COLUMNS - rows / 2 + 0.5
        surface = build_material(name, node, props, sockets)
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(x + a, y + b, 0.0) for a, b in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))], [],
                         [(0, 1, 2, 3)])  # fmt: skip
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.3, location=(x, y, 0.35))
        bpy.ops.object.shade_smooth()
        square = bpy.data.objects.new(name, mesh)
        scene.collection.objects.link(square)
        for ob in (square, bpy.context.object):
            ob.data.materials.append(surface)
    for turn, color in (((0.5, 0.3, 0.0), (1.0, 0.9, 0.8)), ((math.pi - 0.4, 0.2, 0.0), (0.6, 0.8, 1.0))):
        sun = bpy.data.lights.new("Sun", "SUN")
        sun.energy, sun.angle, sun.color = 3.0, 1.6, color
        thing = bpy.data.objects.new("Sun", sun)
        thing.rotation_euler = turn
        scene.collection.objects.link(thing)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", max(COLUMNS, rows)
    thing = bpy.data.objects.new("Camera", camera)
    thing.location = (0.0, 0.0, 9.0)
    scene.collection.objects.link(thing)
    scene.camera = thing
    scene.render.resolution_x, scene.render.resolution_y = CELL * COLUMNS, CELL * rows
    set_cycles(scene)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    scene.cycles.max_bounces, scene.cycles.light_sampling_threshold = 0, 0.0
    write_float_exr(scene.render.image_settings)


def ours() -> tuple[np.ndarray, np.ndarray]:
    """Direct light of the blocks (n, 3), and its standard error."""
    issues = IssueLog()
    data = extract_scene(bpy.context.evaluated_depsgraph_get(), issues)
    settings = Settings(caustic_photons=0, diffuse_photons=0, max_bounces=8, light_samples=4)
    renderer = Renderer(data, settings, issues, frozenset({"Direct"}))
    renderer.prepare(lambda text: None)
    pictures = [renderer.render_pass(i, lambda: False)["Direct"] for i in range(PASSES)]
    renderer.close()
    return mean_and_error([blocks(picture) for picture in pictures])


def cycles(path) -> tuple[np.ndarray, np.ndarray]:
    """The same by Cycles, from pictures of several seeds."""
    scene, pictures = bpy.context.scene, []
    scene.render.filepath, scene.cycles.samples = str(path), SAMPLES // SEEDS
    for scene.cycles.seed in range(SEEDS):
        bpy.ops.render.render(write_still=True)
        pictures.append(blocks(oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[::-1, :, :3]))
    return mean_and_error(pictures)


def mean_and_error(pictures: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean of independent pictures, and its standard error."""
    return np.mean(pictures, axis=0), np.std(pictures, axis=0, ddof=1) / math.sqrt(len(pictures))


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of the cells (n, 3)."""
    cells = picture.astype(np.float64).reshape(-1, CELL, COLUMNS, CELL, 3).mean(axis=(1, 3))
    return cells.reshape(-1, 3)[: len(NAMES)]


def test_lit_sphere_and_plane(tmp_path):
    """Direct light within 1% and noise: 0.3% of half of the blocks, up to 3% of narrow lobes, seen in few pixels."""
    build()
    (found, mine), (expected, theirs) = ours(), cycles(tmp_path / "shelf.exr")
    noise = np.hypot(mine, theirs)
    value = np.maximum(expected, DARK * expected.mean())
    assert np.median(noise / value) < 0.004 and (noise / value).max() < 0.035
    old = bpy.app.version < (5, 0)
    wrong = []
    for i, name in enumerate(NAMES):
        allowed = (OLD_FILMS if name in FILMS and old else TOLERANCE) * value[i] + SIGMAS * noise[i]
        if (np.abs(found[i] - expected[i]) > allowed).any():
            wrong.append(f"{name}: ours {found[i].round(4)} Cycles {expected[i].round(4)} noise {noise[i].round(4)}")
    assert not wrong, "\n".join(wrong)
