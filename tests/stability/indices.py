"""Refraction of every index, and surfaces that overlap, touch and coincide: no light is made or lost."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, average, case, level, same_randoms, shoot
from .space import reference
from .transforms import furnace, lit_floor, plain, with_mesh

NO_PHOTONS = {"caustic_photons": 0, "diffuse_photons": 0}
WATER, GLASS = 1.33, 1.5
ALBEDO = 0.5


def _white(name: str, parts, allowed: float = 2e-3, short: bool = False) -> None:
    @case("index", name, "a white world stays white: L / n^2 is kept", short)
    def check() -> Finding:
        return level(shoot(furnace(parts()), 16, max_bounces=1024, **NO_PHOTONS), 1.0, allowed)


def _ball(index: float, smooth: bool):
    return lambda: [(s.sphere((0, 0, 0), 1.0, 48, smooth=smooth), s.glass(index))]


for index in (0.5, 0.75, 1.0, 1.0001, 1.5, 3.0):
    _white(f"ball of index {index:g}", _ball(index, False), 2e-3 if index < 2.0 else 0.02, short=index == 1.0001)
# facets' normals bend what the smooth ones let pass: light at the rim has nowhere to go
_white("smooth-shaded ball of index 1.5", _ball(1.5, True), 5e-3)
# 0.4% enter, and leave only at right angles
_white("ball of index 1000", _ball(1000.0, False), 0.005)


def _block(lo, hi, index):
    return s.box(lo, hi), s.glass(index)


_white("glass in water in glass", lambda: [
    _block((-1, -1, -1), (1, 1, 1), GLASS), _block((-0.8, -0.8, -0.8), (0.8, 0.8, 0.8), WATER / GLASS),
    _block((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), GLASS / WATER),
])  # fmt: skip
_white("glass and water overlap", lambda: [
    _block((-1, -1, -1), (0.1, 1, 1), GLASS), _block((-0.1, -1, -1), (1, 1, 1), WATER),
])  # fmt: skip
_white("glass and water touch", lambda: [
    _block((-1, -1, -1), (0, 1, 1), GLASS), _block((0, -1, -1), (1, 1, 1), WATER),
], short=True)  # fmt: skip
_white("water stands in glass, its walls in one place", lambda: [
    _block((-1, -1, -1), (1, 1, 1), GLASS), _block((-0.9, -0.9, -0.9), (0.9, 0.9, 0.5), 1.0 / GLASS),
    _block((-0.9, -0.9, -0.9), (0.9, 0.9, 0.5), WATER),
])  # fmt: skip
_white("two blocks in one place", lambda: [
    _block((-1, -1, -1), (1, 1, 1), GLASS), _block((-1, -1, -1), (1, 1, 1), WATER),
])  # fmt: skip


@case("index", "a block of glass stands on a table", "no ray falls through the table", short=True)
def on_a_table() -> Finding:
    """Seen from above under a white sky; what lies below the table shines red."""
    table = s.quad((0, 0, -1), (3, 0, 0), (0, 3, 0), "table")
    below = s.quad((0, 0, -2), (9, 0, 0), (0, 9, 0), "below")
    red = s.emitter(100.0, (1.0, 0.0, 0.0))
    parts = [_block((-1, -1, -1), (1, 1, 1), GLASS), (table, s.diffuse(0.5)), (below, red)]
    view = s.camera((1.2, -1.5, 3.5), (0, 0, -1), 0.15)
    shot = shoot(s.build(parts, (), view, (1, 1, 1), s.frame(16)), 8, **NO_PHOTONS)
    most = float((shot.mean()[..., 0] - shot.mean()[..., 1]).max())
    return Finding(most < 1e-3, f"most red {most:.2g}", shot.seconds)


@case("index", "ball and pane of index 1", "as if they were not there", short=True)
def invisible() -> Finding:
    scene = with_mesh(plain(), s.sphere((-0.1, -0.4, 0.3), 0.4), s.glass(1.0))
    scene = with_mesh(scene, s.box((-0.9, -0.9, 0.8), (0.9, 0.9, 0.82)), s.glass(1.0), name="Pane")
    shot = shoot(scene)
    found = same_randoms(reference(), shot)
    shadow = shot.mean("Direct").mean() / reference().mean("Direct").mean()  # what falls through is direct light
    return found._replace(good=found.good and abs(shadow - 1.0) < 0.02, figure=f"{found.figure}, direct {shadow:.3f}")


def fresnel(cos_i: float, n: float) -> float:
    """Reflectance of unpolarised light [Hecht, Optics, 4.6]; n = n_t / n_i."""
    sin2_t = (1.0 - cos_i**2) / n**2
    if sin2_t >= 1.0:
        return 1.0
    cos_t = np.sqrt(1.0 - sin2_t)
    rs, rp = (cos_i - n * cos_t) / (cos_i + n * cos_t), (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return float(0.5 * (rs**2 + rp**2))


def _surface(index: float, degrees: float, short: bool = False) -> None:
    @case("index", f"surface of index {index:g} at {degrees:g} degrees", "reflects Fresnel's share of the world", short)
    def check() -> Finding:
        a = np.radians(degrees)
        water = s.quad((0, 0, 0), (5, 0, 0), (0, 5, 0), "surface")
        black = s.box((-5, -5, -5), (5, 5, -0.01), name="bottom")
        view = s.camera((np.sin(a), 0.0, np.cos(a)), (0, 0, 0), 0.01 * np.cos(a), kind="ORTHO")
        parts = [(water, s.glass(index)), (black, s.diffuse(0.0))]
        shot = shoot(s.build(parts, (), view, (1, 1, 1), s.frame(16)), 16, **NO_PHOTONS)
        expected = fresnel(np.cos(a), index)
        value = float(shot.mean().mean())
        return Finding(abs(value - expected) <= 1e-3 * expected + 1e-6, f"{value:.6g}, {expected:.6g}", shot.seconds)


for index in (0.5, 1.0001, 1.5, 3.0, 1000.0):
    for degrees in (0.0, 60.0, 89.99):
        _surface(index, degrees, short=(index, degrees) == (1.5, 89.99))


def _pane(index: float, thickness: float = 0.02, family: str = "index", short: bool = False) -> None:
    name = f"sun through a pane of index {index:g}, {thickness:g} m thick"

    @case(family, name, "passes 2 n / (n^2 + 1)", short)
    def check() -> Finding:
        scene = lit_floor(s.sun_lamp((0, 0, -1), 0.0, 1.0))
        pane = s.box((-0.15, -0.15, 0.5), (0.15, 0.15, 0.5 + thickness), name="pane")
        counts = {"diffuse_photons": 0, "caustic_photons": 50_000, "max_bounces": 1024}
        shot = shoot(with_mesh(scene, pane, s.glass(index)), 8, **counts)
        expected = 2.0 * index / (index**2 + 1.0) * ALBEDO / np.pi
        found = average(shot, "Caustic", expected, 0.01, most_noise=0.05)
        return found._replace(good=found.good and not shot.mean("Direct").any())


for index in (0.5, 1.0002, 1.5, 3.0, 100.0):
    _pane(index, short=index == 3.0)
# the floor is 100 m wide, and the sun's photons come from 70 m away, where single precision has steps of 8 micrometres
for thickness in (1e-3, 1e-4, 2e-5, 1e-5):
    _pane(1.5, thickness, "stiff mixes", short=thickness == 1e-5)


@case("stiff mixes", "lamp through a pane of 1 micrometre, floor of 100 m", "passes 2 n / (n^2 + 1)", short=True)
def film_of_glass() -> Finding:
    scene = lit_floor(s.point_lamp((0, 0, 1), 0.0, 1.0))
    pane = s.box((-0.15, -0.15, 0.5), (0.15, 0.15, 0.5 + 1e-6), name="pane")
    shot = shoot(with_mesh(scene, pane, s.glass(1.5)), 8, diffuse_photons=0, caustic_photons=100_000, max_bounces=256)
    return average(shot, "Caustic", 12.0 / 13.0 * ALBEDO / (4.0 * np.pi**2), 0.01)


@case("index", "lamp in the middle of a glass ball", "E = S / (4 pi d^2), as without the ball")
def lamp_inside() -> Finding:
    scene = lit_floor(s.point_lamp((0, 0, 1), 0.0, 1.0))
    ball = s.sphere((0, 0, 1), 0.3, 256)
    shot = shoot(with_mesh(scene, ball, s.glass(1.5)), 8, diffuse_photons=0, caustic_photons=400_000)
    return average(shot, "Caustic", ALBEDO / (4.0 * np.pi**2), 0.01)
