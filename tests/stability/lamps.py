"""Lamps of every size and place: analytic where there is a formula, finite always."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter

from photon_engine.scene.data import Light
from tests.brute import scenes as s

from .lab import Finding, case, shoot, within
from .transforms import SIZE, lit_floor, plain

DIRECT = {"caustic_photons": 0, "diffuse_photons": 0, "light_samples": 16}
ALBEDO = 0.5


def _floor(lamp, expected: float | None, tolerance: float = 0.01, what: str = "radiance") -> Finding:
    """The floor under a lamp against a formula; None: only finite and not black."""
    shot = shoot(lit_floor(lamp), 8, **DIRECT)
    value = float(shot.mean("Direct")[..., 0].mean())
    if expected is None:
        return Finding(value > 0.0, f"{what} {value:.5g} > 0", shot.seconds)
    return within(value, expected, tolerance, shot.seconds, what)


def _down(kind: str, height: float = 1.0, **options) -> Light:
    """A lamp of 1 W over the origin that shines straight down."""
    options = {"strength": (1.0, 1.0, 1.0), "soft_falloff": False} | options
    return Light(kind, kind, s.look_at((0, 0, height), (0, 0, 0)), **options)


def _point(radius: float, short: bool = False) -> None:
    @case("lights", f"point of radius {radius:g} m", "E = S / (4 pi d^2)", short)
    def check() -> Finding:
        return _floor(_down("POINT", radius=radius), ALBEDO / (4.0 * np.pi**2))


for radius in (0.0, 1e-9, 1e-3, 0.5):
    _point(radius, short=radius in (0.0, 1e-9))


def _spot(degrees: float, short: bool = False) -> None:
    @case("lights", f"spot of {degrees:g} degrees", "E = S / (4 pi d^2) on its axis", short)
    def check() -> Finding:
        lamp = _down("SPOT", spot_size=np.radians(degrees))
        half = min(0.05, 0.4 * np.tan(np.radians(0.5 * min(degrees, 120.0))))
        scene = lit_floor(lamp, half_width=half)
        scene.camera.matrix = s.look_at((half, 0.0, 0.15), (0.0, 0.0, 0.0))
        shot = shoot(scene, 8, **DIRECT)
        value = float(shot.mean("Direct")[..., 0].mean())
        return within(value, ALBEDO / (4.0 * np.pi**2), 0.01, shot.seconds, "radiance")


for degrees in (0.1, 1.0, 180.0):
    _spot(degrees, short=degrees == 0.1)


def _sun(degrees: float, short: bool = False) -> None:
    @case("lights", f"sun of {degrees:g} degrees", "E = S where the disk is above the floor", short)
    def check() -> Finding:
        # normalised so that a small disk gives S; a wide one is seen under the cosine: E = S within the whole disk
        return _floor(_down("SUN", angle=np.radians(degrees)), ALBEDO / np.pi)


for degrees in (0.0, 1e-4, 90.0, 180.0):
    _sun(degrees, short=degrees == 0.0)


@case("lights", "area of size 0", "nothing, as in Cycles; the lamp beside it as without it")
def no_area() -> Finding:
    lamps = _down("POINT", radius=0.1), _down("AREA", size=(0.0, 0.0))
    alone, both = shoot(lit_floor(lamps[0]), 8, **DIRECT), shoot(lit_floor(*lamps), 8, **DIRECT)
    values = [float(shot.mean("Direct").mean()) for shot in (both, alone)]
    return within(values[0], values[1], 0.01, both.seconds, "radiance")


@case("lights", "area squashed to 1 m x 1e-6 m", "as a line of points: E = S / (pi A) integrated", short=True)
def line() -> Finding:
    lamp = _down("AREA", shape="RECTANGLE", size=(1.0, 1e-6))
    x = (np.arange(4000) + 0.5) / 4000 - 0.5
    irradiance = float((1.0 / np.pi / (1.0 + x**2) ** 2).mean())  # S / (pi A), cosines of both ends, over d^2
    return _floor(lamp, irradiance * ALBEDO / np.pi)


@case("lights", "area 1e-5 m above the floor", "the floor under it has the lamp's radiance times the albedo")
def touching() -> Finding:
    scene = lit_floor(_down("AREA", height=1e-5, size=(0.2, 0.2)), half_width=0.02)
    shot = shoot(scene, 8, **DIRECT)  # the camera looks through the back of the lamp
    radiance = 1.0 / (np.pi * 0.2**2)
    value = float(shot.mean("Direct")[..., 0].mean())
    return within(value, ALBEDO * radiance, 0.03, shot.seconds, "radiance")


def _fireflies(name: str, lamp, most: float, short: bool = False) -> None:
    law = f"99.99th percentile of a pass: {most:g} times the brightest true value near"

    @case("lights", f"fireflies by {name}", law, short)
    def check() -> Finding:
        """Of direct light in the plain room; true values by 64 other passes; dark pixels count as the mean."""
        scene = plain()
        scene.lights = [lamp]
        settings = {"light_samples": 4, "diffuse_photons": 0, "caustic_photons": 0}
        long, shot = shoot(scene, 64, seed=1, **settings), shoot(scene, 16, seed=2, **settings)
        truth = long.mean("Direct").mean(axis=2)
        truth = np.maximum(maximum_filter(truth, 3), truth.mean())
        ratio = float(np.quantile(shot.passes["Direct"].mean(axis=3) / truth, 0.9999))
        lit = truth.mean() > 0.0
        return Finding(lit and ratio <= most, f"{ratio:.1f}", shot.seconds)


for name, lamp, most in (
    ("an area lamp", s.area_lamp((0, 0, 0.95), (0, 0, 0), 0.5, 3.0), 5.0),
    ("a lamp that goes through a wall", s.area_lamp((0.99, 0, 0), (0.99, 0, -1.0), 0.5, 3.0), 10.0),
    ("a ball that sticks in the ceiling", s.point_lamp((0.0, 0.0, 1.0), 0.2, 3.0), 10.0),
    ("a sun of 1e-4 degrees", s.sun_lamp((0.3, 1.0, -0.7), 1e-4, 3.0), 5.0),
    ("a spot of 2 degrees", Light("Spot", "SPOT", s.look_at((0, 0, 0.9), (0, 0, -1)), (3.0, 3.0, 3.0),
                                  spot_size=np.radians(2.0)), 40.0),  # covers a thirtieth of a pixel
):  # fmt: skip
    _fireflies(name, lamp, most, short=name == "an area lamp")


@case("lights", "fireflies by a point 1 mm off a wall", "none above its foot's radiance; elsewhere as above, 10 times")
def near_a_wall() -> Finding:
    """The pixel of the foot is a thousand times brighter in its middle than in its mean, and one pass may meet that."""
    scene, height, power = plain(), 1e-3, 3.0
    scene.lights = [s.point_lamp((1.0 - height, 0.0, 0.0), 0.0, power)]
    settings = {"light_samples": 4, "diffuse_photons": 0, "caustic_photons": 0}
    long, shot = shoot(scene, 64, seed=1, **settings), shoot(scene, 16, seed=2, **settings)
    truth = long.mean("Direct").mean(axis=2)
    foot = np.zeros_like(truth)
    foot[np.unravel_index(truth.argmax(), truth.shape)] = 1.0
    away = maximum_filter(foot, 3) == 0.0
    truth = np.maximum(maximum_filter(np.where(away, truth, 0.0), 3), truth[away].mean())
    ratio = float((shot.passes["Direct"].mean(axis=3) / truth)[:, away].max())
    top = float(shot.passes["Direct"].max() / (power / (4.0 * np.pi * height**2) / np.pi))
    return Finding(ratio <= 10.0 and top <= 1.0, f"{ratio:.1f}; {top:.2f} of a white foot's radiance", shot.seconds)


@case("lights", "area through a wall", "no pixel of a pass above 4 times albedo times the lamp's radiance", short=True)
def crossing() -> Finding:
    scene = plain()
    scene.lights[0].matrix = s.look_at((0.99, 0.0, 0.0), (0.99, 0.0, -1.0))
    shot = shoot(scene, 8)
    ratio = float(shot.passes["Direct"].max() / (0.7 * 4.0))  # the lamp of the plain room has radiance 4
    return Finding(ratio < 4.0, f"brightest pixel of a pass {ratio:.2f} of it", shot.seconds)


@case("lights", "lamp in a closed box", "no light outside", short=True)
def boxed_in() -> Finding:
    floor = lit_floor(s.point_lamp((0, 0, 1), 0.05, 10.0))
    box = s.build([(s.box((-0.2, -0.2, 0.8), (0.2, 0.2, 1.2)), s.diffuse(0.8))])
    floor.meshes.append(box.meshes[0])
    floor.materials.append(box.materials[0])
    floor.instances.append(s.Instance(1, np.eye(4), [1], name="Box"))
    shot = shoot(floor, 4)
    value = float(shot.mean().max())
    return Finding(value == 0.0, f"brightest pixel {value:g}", shot.seconds)


@case("lights", "energy 0", "black, with a message", short=True)
def dark() -> Finding:
    scene = plain()
    scene.lights[0].strength = (0.0, 0.0, 0.0)
    shot = shoot(scene, 1)
    said = any("no light" in issue for issue in shot.issues)
    return Finding(said and not shot.mean().any(), f"brightest {shot.mean().max():g}, told: {said}", shot.seconds)


@case("lights", "negative energy or colour beside a lamp", "no light in the channels where it is negative", short=True)
def negative() -> Finding:
    half = shoot(lit_floor(_down("POINT"), _down("POINT", strength=(-5.0, 1.0, -1e3))), 8, **DIRECT)
    r, g, b = half.mean("Direct").mean(axis=(0, 1)) / (ALBEDO / (4.0 * np.pi**2))
    good = max(abs(r - 1.0), abs(g - 2.0), abs(b - 1.0)) < 0.01
    return Finding(good, f"{r:.3f} {g:.3f} {b:.3f} of the lamp beside it", half.seconds)


@case("lights", "emissive sphere of a million triangles", "as a ball lamp: E of a sphere, S/(4 pi d^2) at distance")
def many_emitters() -> Finding:
    scene = lit_floor(size=SIZE)
    ball = s.sphere((0, 0, 1.0), 0.3, 1024, smooth=False)
    scene.meshes.append(ball)
    scene.materials.append(s.emitter(2.0))
    scene.instances.append(s.Instance(1, np.eye(4), [1], name="Ball"))
    shot = shoot(scene, 4, **DIRECT)
    return within(float(shot.mean("Direct")[..., 0].mean()), 2.0 * 0.3**2 * ALBEDO, 0.02, shot.seconds, "radiance")
