"""Light that goes on for long: what comes out is the sum of its bounces, and what the cap cuts off is said."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, average, case, level, shoot, told, within
from .transforms import furnace

NO_PHOTONS = {"caustic_photons": 0, "diffuse_photons": 0}
INDEX = 1.5


def _room(wall):
    """The middle of a wall of a closed box: photon gathers near an edge miss what lies beyond it."""
    view = s.camera((0.1, -0.2, 0.1), (0.1, 1.0, 0.1), 0.3)
    return s.build([(s.box((-1, -1, -1), (1, 1, 1), inward=True), wall)], (), view, picture=s.frame(16))


def series(a: float, terms: int) -> float:
    """1 + a + a^2 + ... of so many terms."""
    return float(np.sum(a ** np.arange(terms)))


def _closed(albedo: float, bounces: int, short: bool = False) -> None:
    law = f"e (1 + a + ... + a^{bounces})" + ("" if albedo < 1.0 else ", bounded time")

    @case("long chains", f"closed box of albedo {albedo:g}, {bounces} bounces", law, short)
    def check() -> Finding:
        wall = s.mixed(s.diffuse(albedo), s.emitter(1.0), add=True)
        photons = min(20_000, int(2e6 / min(bounces, 1.0 / (1.0001 - albedo))))
        settings = {"max_bounces": bounces, "diffuse_bounces": bounces, "diffuse_photons": photons, "light_samples": 16}
        shot = shoot(_room(wall), 4, **settings)
        found = level(shot, series(albedo, bounces + 1), 0.01, most_noise=0.04)
        cut = albedo**bounces > 0.02  # that much is lost, and said to be
        said = told(shot, "bounces") == cut
        return found._replace(good=found.good and said, figure=found.figure + (", told" if cut and said else ""))


for albedo, bounces in ((0.9, 64), (0.99, 64), (0.99, 1024), (0.999, 1024), (1.0, 64), (1.0, 1024)):
    _closed(albedo, bounces, short=(albedo, bounces) == (0.99, 64))


def _mirrors(albedo: float, bounces: int, short: bool = False) -> None:
    @case("long chains", f"box of mirrors of {albedo:g}, {bounces} bounces", f"e (1 + ... + r^{bounces - 1})", short)
    def check() -> Finding:
        wall = s.mixed(s.mirror(albedo), s.emitter(1.0), add=True)
        return level(shoot(_room(wall), 32, max_bounces=bounces, **NO_PHOTONS), series(albedo, bounces), 1e-3)


for albedo, bounces in ((0.9, 64), (0.99, 64), (0.999, 1024), (1.0, 64), (1.0, 1024)):
    _mirrors(albedo, bounces, short=(albedo, bounces) == (1.0, 1024))


@case("long chains", "floor between two facing mirrors", "images of the lamp: E = sum r^k S h / (4 pi d_k^3)")
def facing() -> Finding:
    """Photons by up to dozens of reflections; the lamp hangs 1 m over the floor, images are 2 m apart."""
    r = 0.95
    mirrors = [s.quad((x, 0, 0.65), (0, 0, -0.65 * x), (0, 0.65, 0), "mirror") for x in (-1.0, 1.0)]
    floor = s.quad((0.0, 0.0, 0.0), (0.99, 0.0, 0.0), (0.0, 0.6, 0.0), "floor")
    parts = [*((m, s.mirror(r)) for m in mirrors), (floor, s.diffuse(0.5))]
    view = s.camera((0.2, 0.0, 0.15), (0, 0, 0), 0.05, kind="ORTHO")
    scene = s.build(parts, [s.point_lamp((0, 0, 1.0), 0.0, 1.0)], view, picture=s.frame(16))
    shot = shoot(scene, 32, caustic_photons=200_000, diffuse_photons=0, light_samples=1)
    k = np.arange(1, 64)
    expected = 2.0 * (r**k / (4.0 * np.pi * (1.0 + 4.0 * k**2) ** 1.5)).sum() * 0.5 / np.pi
    return average(shot, "Caustic", float(expected), 0.01)


def trapped_share(n: float) -> float:
    """Of light from inside a box of index n: what total reflection keeps in; its directions keep their cosines."""
    return 1.0 - 3.0 * (1.0 - np.sqrt(1.0 - 1.0 / n**2))


@case("long chains", "lamp in a block of glass", "1 - 3 (1 - cos theta_c) of it never leaves; flux is kept", short=True)
def trapped() -> Finding:
    lamp = s.point_lamp((0.1, -0.2, 0.05), 0.0, 1.0)
    scene = s.build([(s.box((-1, -1, -1), (1, 1, 1)), s.glass(INDEX))], [lamp], s.camera((0, -4, 0), (0, 0, 0), 0.3))
    shot = shoot(scene, 2, plan=False)
    emitted, absorbed, escaped, dropped = shot.flux["diffuse"][:, 0]
    balance = abs((absorbed + escaped + dropped) / emitted - 1.0)
    found = within(dropped / emitted, trapped_share(INDEX), 0.02, shot.seconds, "share under way at the cap")
    good = found.good and balance < 1e-5 and told(shot, "bounces")
    return found._replace(good=good, figure=f"{found.figure}, told; flux balance {balance:.0e}")


@case("long chains", "camera in a block of glass", "n^2 times the world within the critical angle, else 0", short=True)
def inside_block() -> Finding:
    block = s.box((-1, -1, -1), (1, 1, 1))
    straight = s.build([(block, s.glass(INDEX))], (), s.camera((0.1, 0.1, 0), (0.1, 1, 0), 0.2), (1, 1, 1), s.frame(16))
    corner = s.camera((0.1, 0.1, 0), (0.6, 0.6, 0.5), 0.05)
    dark = s.build([(block, s.glass(INDEX))], (), corner, (1, 1, 1), s.frame(16))
    found = level(shoot(straight, 8, max_bounces=1024), INDEX**2, 1e-3)
    left = float(shoot(dark, 1, max_bounces=1024).mean().max())
    return found._replace(good=found.good and left == 0.0, figure=f"{found.figure}; trapped {left:g}")


def shells(count: int):
    """Nested shells of glass with air between, all of the same facets."""
    balls = [s.sphere((0, 0, 0), 1.0 - 0.4 * k / (2 * count), 32, smooth=False) for k in range(2 * count)]
    parts = [(ball, s.glass(INDEX if k % 2 == 0 else 1.0 / INDEX)) for k, ball in enumerate(balls)]
    return furnace(parts)


@case("long chains", "8 nested shells of glass, 1024 bounces", "a white world stays white", short=True)
def few_shells() -> Finding:
    return level(shoot(shells(8), 8, max_bounces=1024, **NO_PHOTONS), 1.0, 0.005)


@case("long chains", "64 nested shells of glass, 1024 bounces", "white, less at most 12% still under way at the cap")
def many_shells() -> Finding:
    """Light wanders between 128 surfaces: 22%, 15% and 9% are left after 256, 512 and 1024 bounces."""
    shot = shoot(shells(64), 8, max_bounces=1024, **NO_PHOTONS)
    value, noise = float(shot.mean().mean()), float(shot.blocks()[1].max())
    return Finding(0.88 <= value <= 1.0 + 4.0 * noise and noise < 0.03, f"{value:.3f}, noise {noise:.3f}", shot.seconds)
