"""Cameras and frames of every kind: as a crop of a plain render where it is one."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, case, shoot, within
from .space import reference
from .transforms import SIZE, plain


def _whole(scene) -> np.ndarray:
    return shoot(scene, 2).mean()


@case("camera", "border of one pixel", "that pixel of the full frame, bit for bit", short=True)
def one_pixel() -> Finding:
    """Without photons a pixel depends on itself alone; the pilot, which bounds gather radii, looks at the border."""
    settings = {"caustic_photons": 0, "diffuse_photons": 0}
    whole = shoot(plain(), 2, **settings)
    scene = plain()
    scene.frame.x0, scene.frame.y0, scene.frame.x1, scene.frame.y1 = 9, 13, 10, 14
    part = shoot(scene, 2, **settings)
    gap = float(np.abs(part.mean()[0, 0] - whole.mean()[13, 9]).max())
    return Finding(gap == 0.0, f"differs by {gap:g}", part.seconds)


def _size(width: int, height: int, short: bool = False) -> None:
    @case("camera", f"{width} x {height} pixels", "mean of direct light as in the plain render", short)
    def check() -> Finding:
        scene = plain()
        frame, half = scene.frame, 0.34
        frame.width, frame.height, frame.x1, frame.y1 = width, height, width, height
        scene.camera.window = (-half, half, -half, half)  # pixels that are not square
        passes = 64 if width * height == 1 else 8  # a single pixel sees little of the picture in each
        shot = shoot(scene, passes)
        plainly = reference().mean("Direct").mean()  # caustics met by one pixel are rare and bright: no law to be seen
        noise = 4.0 * shot.passes["Direct"].mean(axis=(1, 2, 3)).std(ddof=1) / np.sqrt(passes) / plainly
        return within(float(shot.mean("Direct").mean()), plainly, 0.02 + noise, shot.seconds, "direct light")


for width, height in ((1, 1), (1, 4096), (4096, 1), (3, 200)):
    _size(width, height, short=width == height)


@case("camera", "pixel aspect 10", "rows of ten of a plain render's pixels: the same light", short=True)
def tall_pixels() -> Finding:
    """A tenth of the rows over the same view."""
    scenes = [plain() for _ in range(2)]
    for scene, height in zip(scenes, (SIZE, SIZE // 10 + 1), strict=True):
        scene.frame.height = scene.frame.y1 = height
        scene.camera.window = (-0.34, 0.34, -0.34, 0.34)
    square, tall = (shoot(scene, 16, light_samples=4) for scene in scenes)
    names = ("Direct", "Diffuse")
    a, b = (sum(shot.passes[name].mean(axis=(1, 2, 3)) for name in names) for shot in (square, tall))
    noise = 4.0 * np.hypot(a.std(ddof=1), b.std(ddof=1)) / np.sqrt(len(a)) / a.mean()
    return within(float(b.mean()), float(a.mean()), 0.02 + noise, tall.seconds, "light")


def _lens(millimetres: float) -> None:
    @case("camera", f"{millimetres:g} mm", "the floor's radiance does not depend on the lens")
    def check() -> Finding:
        half = 18.0 / millimetres
        wall = s.mixed(s.diffuse(0.5), s.emitter(0.7), add=True)
        room = s.box((-1, -1, -1), (1, 1, 1), inward=True)
        scene = s.build([(room, wall)], (), s.camera((0.1, -0.2, 0.1), (0.1, 1.0, 0.1), half), picture=s.frame(SIZE))
        shot = shoot(scene, 8, light_samples=16, diffuse_photons=100_000)
        return within(float(shot.mean().mean()), 1.4, 0.06, shot.seconds, "furnace")


for millimetres in (1.0, 50.0, 5000.0):
    _lens(millimetres)


def _ortho(width: float, gather: str) -> None:
    @case("camera", f"orthographic, {width:g} m wide, final gather {gather}", "the furnace's radiance 1.4")
    def check() -> Finding:
        wall = s.mixed(s.diffuse(0.5), s.emitter(0.7), add=True)
        room = s.box((-1, -1, -1), (1, 1, 1), inward=True)
        view = s.camera((0.1, -0.2, 0.1), (0.1, 1.0, 0.1), 0.5 * width, kind="ORTHO")
        scene = s.build([(room, wall)], (), view, picture=s.frame(16))
        # a picture within one radius sees the same few photons everywhere, 20 in a pass: 2% of the furnace's light
        shot = shoot(scene, 16, light_samples=16, diffuse_photons=100_000, final_gather=gather)
        return within(float(shot.mean().mean()), 1.4, 0.03 if gather == "ALL" else 0.06, shot.seconds, "furnace")


for width in (1.0, 1e-4):
    for gather in ("ALL", "OFF"):
        _ortho(width, gather)


@case("camera", "on a surface", "the wall as from 1 mm above it")
def on_a_surface() -> Finding:
    means = []
    for height in (0.0, 1e-3):
        scene = plain()
        scene.camera.matrix = s.look_at((0.0, 0.0, -1.0 + height), (0.0, 1.0, -0.8))
        shot = shoot(scene, 8)
        means.append(float(shot.mean("Direct")[SIZE // 2 :].mean()))  # the upper half: the floor is on edge
    return within(means[0], means[1], 0.03, shot.seconds, "direct light of the wall")


@case("camera", "aperture of 10 m", "in a closed furnace every lens sees 1.4")
def huge_aperture() -> Finding:
    wall = s.mixed(s.diffuse(0.5), s.emitter(0.7), add=True)
    view = s.camera((0.0, -0.2, 0.0), (0.0, 1.0, 0.0), 0.3, aperture_radius=10.0, focus_distance=4.0)
    scene = s.build([(s.box((-20, -20, -20), (20, 20, 20), inward=True), wall)], (), view, picture=s.frame(16))
    shot = shoot(scene, 8, light_samples=16, diffuse_photons=100_000)
    return within(float(shot.mean().mean()), 1.4, 0.04, shot.seconds, "furnace")
