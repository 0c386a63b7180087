"""Photon maps that hold nothing, next to nothing, all in one place, or more than fits."""

from __future__ import annotations

import resource

import numpy as np

from photon_engine.scene.data import Light
from tests.brute import scenes as s

from .lab import Finding, case, shoot, told, within
from .space import reference
from .transforms import lit_floor, plain


@case("photons", "none stored: nothing but a plane", "direct light by the formula, Diffuse 0", short=True)
def none_stored() -> Finding:
    """Every photon leaves after its first bounce."""
    shot = shoot(lit_floor(s.point_lamp((0, 0, 1), 0.0, 1.0), albedo=0.5), 4, light_samples=16)
    found = within(float(shot.mean("Direct")[..., 0].mean()), 0.5 / (4.0 * np.pi**2), 0.01, shot.seconds, "radiance")
    rest = shot.mean("Diffuse").max() + shot.mean("Caustic").max()
    return Finding(found.good and rest == 0.0, f"{found.figure}, the rest {rest:g}", shot.seconds)


@case("photons", "none sent", "direct light as in the plain render, bit for bit", short=True)
def none_sent() -> Finding:
    shot = shoot(plain(), caustic_photons=0, diffuse_photons=0)
    gap = float(np.abs(shot.mean("Direct") - reference().mean("Direct")).max())
    rest = float(shot.mean("Diffuse").max() + shot.mean("Caustic").max())
    return Finding(gap == 0.0 and rest == 0.0, f"differs by {gap:g}, the rest {rest:g}", shot.seconds)


@case("photons", "one in each pass", "the mean of many passes is that of one with as many photons")
def one_stored() -> Finding:
    """Half a pixel wide, so that hardly any of a lone photon falls past an edge of the room."""
    scene = plain()
    scene.frame.width = scene.frame.height = scene.frame.x1 = scene.frame.y1 = 8
    options = {"caustic_photons": 0, "light_samples": 1, "diffuse_radius": 0.5, "alpha": 1.0}
    many = shoot(scene, 16, diffuse_photons=20_000, **options)
    lone = shoot(scene, 4000, diffuse_photons=1, **options)
    sums = lone.passes["Diffuse"].mean(axis=(1, 2, 3))
    expected = float(many.mean("Diffuse").mean())
    noise = 4.0 * sums.std(ddof=1) / np.sqrt(len(sums)) / expected
    return within(float(sums.mean()), expected, noise, lone.seconds, "diffuse light")


HALF = 5e-3  # [m] of the picture


def thrown(beam: float, half: float):
    """A parallel beam that a tilted mirror throws onto the floor, which a parallel camera sees from above."""
    mirror = s.quad((0.0, 0.0, 2.0), (half, 0.0, -half), (0.0, half, 0.0), "mirror")
    floor = s.quad((0.0, 0.0, 0.0), (5.0, 0.0, 0.0), (0.0, 5.0, 0.0), "floor")
    lamp = s.area_lamp((-3.0, 0.0, 2.0), (0.0, 0.0, 2.0), beam, 1.0, spread=0.0)
    view = s.camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), HALF, kind="ORTHO")
    return s.build([(floor, s.diffuse(0.5)), (mirror, s.mirror(0.9))], [lamp], view, picture=s.frame(24))


def flux_in(shot) -> float:
    """All radiance times area times pi over the albedo [W]."""
    return float(shot.mean("Caustic").mean()) * (2.0 * HALF) ** 2 * np.pi / 0.5


@case("photons", "a million in one cell: sunbeam on a mirror of 2 mm", "its flux; bounded time", short=True)
def million_in_one_cell() -> Finding:
    """40% of the photons aimed at the mirror's ball hit it; within a pixel's 8 radii there are 200 000 of them."""
    half, beam = 1e-3, 0.3
    few, many = (shoot(thrown(beam, half), 4, caustic_photons=n, diffuse_photons=0) for n in (100_000, 1_000_000))
    expected = 0.9 * (2.0 * half / beam) ** 2
    # the rim of the spot, 20 pixels long, is seen by 4 samples of each: 5%
    found = within(flux_in(many), expected, 0.06, many.seconds, "flux")
    slower = many.seconds / few.seconds
    figure = f"{found.figure}; {slower:.1f} times as long for 10 times"
    return Finding(found.good and slower < 30.0, figure, many.seconds)


@case("photons", "a laser of 1 mm on a mirror of 1 m", "its flux", short=True)
def thin_beam() -> Finding:
    shot = shoot(thrown(1e-3, 0.5), 4, caustic_photons=100_000, diffuse_photons=0)
    return within(flux_in(shot), 0.9, 0.05, shot.seconds, "flux")


def _beam(name: str, lamp) -> None:
    @case("photons", f"{name} on a mirror of 1 m", "its flux")
    def check() -> Finding:
        scene = thrown(1e-3, 0.5)
        scene.lights = [lamp]
        shot = shoot(scene, 16, caustic_photons=100_000, diffuse_photons=0)
        return within(flux_in(shot), 0.9, 0.03, shot.seconds, "flux")  # the spot's rim is seen by few samples


BEAM = s.look_at((-3.0, 0.0, 2.0), (0.0, 0.0, 2.0))  # 5 m to the floor, where all is within 2 mm of its axis
_beam("an area lamp of 1 mm and 0.03 degrees", Light("Area", "AREA", BEAM, (1.0, 1.0, 1.0), size=(1e-3, 1e-3),
                                                     spread=np.radians(0.03)))  # fmt: skip
# a spot's power is that of the whole ball: its cone has (1 - cos) / 2 of it, less half of the rim's blend
HALF_CONE = np.radians(0.01)
_beam("a spot of 0.02 degrees", Light("Spot", "SPOT", BEAM, (2.0 / (1.0 - np.cos(HALF_CONE)),) * 3,
                                      spot_size=2.0 * HALF_CONE, spot_blend=0.0))  # fmt: skip


@case("photons", "10 million in a pass", "parts of it one after the other: less than 1 GB more; same caustic")
def more_than_memory() -> Finding:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    options = {"diffuse_photons": 0, "caustic_radius": 0.1, "threads": 2}  # below what the photons of either allow
    shot = shoot(plain(), 2, caustic_photons=10_000_000, **options)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 2**20
    few = shoot(plain(), 2, caustic_photons=2_000_000, **options)  # seen by the same eye paths
    caustic, expected = float(shot.mean("Caustic").mean()), float(few.mean("Caustic").mean())
    found = within(caustic, expected, 0.02, shot.seconds, "caustic")
    good = found.good and grown < 1.0 and told(shot, "Caustic Photons", "3 parts")
    return Finding(good, f"{found.figure}; {grown:.2f} GB more, told", shot.seconds)
