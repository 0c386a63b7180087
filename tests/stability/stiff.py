"""Very bright beside very dark, and glass that focuses everywhere: the claimed errors stay the true ones."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import PASSES, Finding, calibrated, case, shoot

SIZE = 32


def bright_and_dark(ratio: float):
    """A lens focuses a lamp into a spot on the floor; a wall keeps all but a dim lamp's light from the left half."""
    floor = s.quad((0, 0, 0), (2, 0, 0), (0, 2, 0), "floor")
    wall = s.box((-0.05, -2, 0.0), (0.05, 2, 3.0), name="wall")
    roof = s.quad((-1, 0, 3.0), (1.05, 0, 0), (0, 2, 0), "roof")
    ball = s.sphere((0.7, 0.0, 0.5), 0.35, 64)
    parts = [(floor, s.diffuse(0.5)), (wall, s.diffuse(0.3)), (roof, s.diffuse(0.3)), (ball, s.glass(1.5))]
    lamps = [s.point_lamp((0.7, 0.0, 2.5), 0.02, ratio), s.point_lamp((-0.9, -0.3, 1.0), 0.1, 1.0)]
    view = s.camera((0.0, -4.0, 4.0), (0.0, 0.0, 0.0), 0.35)
    return s.build(parts, lamps, view, picture=s.frame(SIZE))


@case("stiff mixes", "caustic 1e6 times brighter than the dark half", "claimed errors are true, in the dark half too")
def caustic_beside_dark() -> Finding:
    found = calibrated(bright_and_dark(1e5), ("Combined", "Caustic", "Diffuse"))
    shot = shoot(bright_and_dark(1e5), PASSES)
    alone = shoot(bright_and_dark(0.0), PASSES)
    part = slice(4, 28), slice(2, 12)
    both, dim = (x.mean("Direct")[part].mean() for x in (shot, alone))
    ratio = float(shot.mean("Caustic").max() / dim)
    good = found.good and abs(both / dim - 1.0) < 0.05 and ratio > 1e5
    return found._replace(good=good, figure=f"{found.figure}; dark half {both / dim:.3f} of alone, ratio {ratio:.0e}")


def waves(frequency: float, steepness: float, n: int = 64):
    """Water over a floor, its smooth normals waving: `frequency` waves over 2 m, slopes up to `steepness`."""
    x = np.linspace(-1.0, 1.0, n + 1)
    grid = np.stack([*np.meshgrid(x, x, indexing="ij"), np.full((n + 1, n + 1), 0.5)], -1)
    phase = np.pi * frequency * grid[..., :2]
    slope = steepness * np.cos(phase) * np.cos(phase[..., ::-1])
    normal = np.concatenate([-slope, np.ones((n + 1, n + 1, 1))], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    i = np.arange(n)[:, None] * (n + 1) + np.arange(n)[None]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in (
        (i, i + n + 1, i + n + 2), (i, i + n + 2, i + 1))])  # fmt: skip
    sheet = s.mesh(grid.reshape(-1, 3), triangles, normal.reshape(-1, 3)[triangles], "waves")
    floor = s.quad((0, 0, 0), (1, 0, 0), (0, 1, 0), "floor")
    sides = [s.quad((x, 0, 0.25), (0, 1, 0), (0, 0, 0.25), "side") for x in (-1.0, 1.0)]
    sides += [s.quad((0, y, 0.25), (1, 0, 0), (0, 0, 0.25), "side") for y in (-1.0, 1.0)]
    parts = [(sheet, s.glass(1.33)), (floor, s.diffuse(0.5)), *((side, s.diffuse(0.0)) for side in sides)]
    view = s.camera((0.3, -0.8, 4.0), (0, 0, 0), 0.2)
    return s.build(parts, [s.sun_lamp((0.2, 0.1, -1.0), 0.01, 3.0)], view, picture=s.frame(SIZE))


def _waves(frequency: float, short: bool = False) -> None:
    @case("stiff mixes", f"water with {frequency:g} waves in 2 m", "claimed errors are true", short)
    def check() -> Finding:
        return calibrated(waves(frequency, 0.3), ("Combined", "Caustic"))


for frequency in (4.0, 16.0, 31.0):
    _waves(frequency)
