"""Light and views along surfaces, coarse smooth meshes, normals beyond the horizon: no leaks, no energy gained."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, case, level, shoot, within
from .transforms import furnace, lit_floor

ALBEDO = 0.5
NO_PHOTONS = {"caustic_photons": 0, "diffuse_photons": 0}


def _sun(degrees: float, short: bool = False) -> None:
    @case("grazing", f"sun at {degrees:g} degrees", "E = S cos", short)
    def check() -> Finding:
        a = np.radians(degrees)
        scene = lit_floor(s.sun_lamp((np.sin(a), 0.0, -np.cos(a)), 0.0, 1.0))
        shot = shoot(scene, 2, **NO_PHOTONS)
        return within(float(shot.mean("Direct").mean()), ALBEDO / np.pi * np.cos(a), 1e-3, shot.seconds, "radiance")


for degrees in (89.0, 89.99, 89.9999):
    _sun(degrees, short=degrees == 89.99)


@case("grazing", "sun at 90.01 degrees", "nothing from below the floor's plane", short=True)
def below() -> Finding:
    a = np.radians(90.01)
    shot = shoot(lit_floor(s.sun_lamp((np.sin(a), 0.0, -np.cos(a)), 0.0, 1.0)), 2, **NO_PHOTONS)
    return Finding(not shot.mean().any(), f"brightest {shot.mean().max():g}", shot.seconds)


def _eye(degrees: float, allowed: float, short: bool = False) -> None:
    @case("grazing", f"eye at {degrees:g} degrees", "the furnace's radiance 1.4, whatever the angle", short)
    def check() -> Finding:
        """Of all passes: footprints of pixels are stretched a thousand times."""
        wall = s.mixed(s.diffuse(0.5), s.emitter(0.7), add=True)
        a = np.radians(degrees)
        out = np.array([np.sin(a), 0.0, np.cos(a)])
        view = s.camera((0.3 * out[0], 0.0, -1.0 + 0.3 * out[2]), (0, 0, -1), 0.05, kind="ORTHO")
        view.window = (-0.05, 0.05, -0.05 * np.cos(a), 0.05 * np.cos(a))  # a square of the floor
        scene = s.build([(s.box((-1, -1, -1), (1, 1, 1), inward=True), wall)], (), view, picture=s.frame(16))
        shot = shoot(scene, 16, light_samples=16, diffuse_photons=200_000)
        return level(shot, 1.4, allowed, most_noise=0.05)


for degrees in (80.0, 89.0, 89.9, 89.99):
    _eye(degrees, 0.02, short=degrees == 89.0)


def _coarse(segments: int, short: bool = False) -> None:
    @case("grazing", f"white smooth ball of {segments} segments", "no brighter than the world", short)
    def check() -> Finding:
        scene = furnace([(s.sphere((0, 0, 0), 1.0, segments), s.diffuse(1.0))], half_width=0.4, size=24)
        shot = shoot(scene, 16, light_samples=16, diffuse_photons=50_000)
        means, errors = shot.blocks()
        most = float((means - 4.0 * errors).max())
        return Finding(0.5 < float(means.mean()) and most <= 1.02, f"brightest block {means.max():.3f}", shot.seconds)


for segments in (6, 8, 16):
    _coarse(segments, short=segments == 8)


def _shell(segments: int, inside: bool, short: bool = False) -> None:
    name = f"closed smooth ball of {segments} segments, {'eye' if inside else 'lamp'} inside"

    @case("grazing", name, "nothing comes through", short)
    def check() -> Finding:
        ball = s.sphere((0, 0, 0), 1.0, segments)
        floor = s.quad((0, 0, -2), (5, 0, 0), (0, 5, 0), "floor")
        near, far = (0.2, 0.1, 0.1), (2.0, -2.5, 1.0)
        eye, lamp = (near, far) if inside else (far, near)
        view = s.camera(eye, (0, 0, -0.5), 0.8)
        parts = [(ball, s.diffuse(0.9)), (floor, s.diffuse(0.9))]
        scene = s.build(parts, [s.point_lamp(lamp, 0.05, 100.0)], view, picture=s.frame(24))
        shot = shoot(scene, 4, light_samples=8)
        return Finding(not shot.mean().any(), f"brightest {shot.mean().max():g}", shot.seconds)


for segments in (6, 16):
    for inside in (False, True):
        _shell(segments, inside, short=segments == 6)


def tilted(degrees: float):
    """A floor whose corner normals lean toward +x by that angle: a bump as steep as can be."""
    floor = s.quad((0, 0, 0), (50, 0, 0), (0, 50, 0), "floor")
    a = np.radians(degrees)
    floor.normals = np.tile(np.float32([np.sin(a), 0.0, np.cos(a)]), (2, 3, 1))
    return floor


def _bump(degrees: float, material, name: str, short: bool = False) -> None:
    @case("grazing", f"{name}, normals leaning {degrees:g} degrees", "no brighter than the world", short)
    def check() -> Finding:
        view = s.camera((0.5, 0.0, 0.6), (0, 0, 0), 0.05, kind="ORTHO")
        scene = s.build([(tilted(degrees), material)], (), view, (1, 1, 1), s.frame(16))
        shot = shoot(scene, 16, light_samples=16)
        means, errors = shot.blocks()
        good = float((means - 4.0 * errors).max()) <= 1.01 and errors.max() < 0.05
        return Finding(good, f"brightest block {means.max():.3f}", shot.seconds)


for degrees in (30.0, 60.0, 85.0, 95.0):
    _bump(degrees, s.diffuse(1.0), "white floor", short=degrees == 85.0)
    _bump(degrees, s.mirror(1.0), "mirror")
    _bump(degrees, s.material("BsdfAnisotropic", 1.0, Roughness=0.3), "rough mirror")


@case("grazing", "sun below a floor whose normals lean to it", "the floor's own plane hides it", short=True)
def behind_the_horizon() -> Finding:
    a = np.radians(95.0)
    lamp = s.sun_lamp((-np.sin(a), 0.0, -np.cos(a)), 0.0, 1.0)
    view = s.camera((0.2, 0.0, 0.15), (0, 0, 0), 0.05, kind="ORTHO")
    scene = s.build([(tilted(60.0), s.diffuse(0.5))], [lamp], view, picture=s.frame(16))
    scene.instances[0].terminator_offset = 0.0  # the offset's surface through these normals would be 80 m high
    shot = shoot(scene, 2)
    return Finding(not shot.mean().any(), f"brightest {shot.mean().max():g}", shot.seconds)
