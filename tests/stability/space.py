"""Scale, place and power: the picture does not depend on the unit of length, on the origin, or on the exposure."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, calibrated, case, same_randoms, shoot
from .transforms import brighter, moved, plain, scaled, with_mesh

VARIANTS = ("lamp", "mesh", "sphere", "sun", "world")
CACHE: dict[str, object] = {}


def reference(variant: str = "lamp"):
    """The plain room, rendered once."""
    if variant not in CACHE:
        CACHE[variant] = shoot(plain(variant))
    return CACHE[variant]


def _scale(variant: str, k: float, short: bool) -> None:
    @case("scale", f"{variant}, times {k:g}", "same picture, lights by the square", short)
    def check() -> Finding:
        return same_randoms(reference(variant), shoot(scaled(plain(variant), k)))


def _power(k: float, short: bool) -> None:
    @case("power", f"lights times {k:g}", "linear", short)
    def check() -> Finding:
        # single precision keeps 7 digits from 1e-38 to 1e38
        return same_randoms(reference(), shoot(brighter(plain(), k)), k, 1e-3)


for variant in VARIANTS:
    for k in (1e-4, 3.7e-2, 1e2, 1e4):
        _scale(variant, k, short=variant == "lamp" and k in (1e-4, 1e4))
for k in (1e-9, 1e-3, 1e6, 1e12):
    _power(k, short=k in (1e-9, 1e12))


@case("place", "moved by 1e5 m", "same picture", short=True)
def far_from_origin() -> Finding:
    return same_randoms(reference(), shoot(moved(plain(), (7e4, -1e5, 3e4))))


@case("place", "moved by 1e5 m, sun", "same picture")
def far_from_origin_sun() -> Finding:
    return same_randoms(reference("sun"), shoot(moved(plain("sun"), (7e4, -1e5, 3e4))))


@case("place", "another object 1e6 m away", "same picture", short=True)
def one_object_far_away() -> Finding:
    far = s.quad((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), "far")
    matrix = np.eye(4)
    matrix[:3, 3] = (3e5, 9e5, -4e5)
    return same_randoms(reference(), shoot(with_mesh(plain(), far, name="Far", matrix=matrix)))


def next_door(bright: float, mesh: bool):
    """Two closed boxes side by side, a lamp or a glowing square in each; the camera is in the dim one."""
    parts = [
        (s.box((-1, -1, -1), (1, 1, 1), inward=True), s.diffuse(0.5)),
        (s.box((1.5, -1, -1), (3.5, 1, 1), inward=True), s.diffuse(0.5)),
    ]
    lamps = []
    for x, power in ((0.0, 3.0), (2.5, 3.0 * bright)):
        if mesh and power:
            parts.append((s.quad((x, 0, 0.9), (0.2, 0, 0), (0, 0.2, 0), "glow"), s.emitter(power)))
        elif power:
            lamps.append(s.area_lamp((x, 0, 0.9), (x, 0, 0), 0.4, power))
    return s.build(parts, lamps, s.camera((0, -0.9, 0), (0, 1, 0), 0.8), picture=s.frame(24))


def _bright_neighbour(what: str, mesh: bool) -> None:
    name = f"a {what} 1e6 times brighter in the next room"

    @case("power", name, "the dim room as without it in each pass, claimed errors true", short=not mesh)
    def check() -> Finding:
        alone, both = shoot(next_door(0.0, mesh), 16), shoot(next_door(1e6, mesh), 16)
        sigmas, noises = 0.0, []
        for part in ("Direct", "Diffuse"):
            a, b = (shot.passes[part].mean(axis=(1, 2, 3)) for shot in (alone, both))
            errors = [x.std(ddof=1) / np.sqrt(len(x)) for x in (a, b)]
            sigmas = max(sigmas, abs(a.mean() - b.mean()) / np.hypot(*errors))
            noises.append(errors[1] / a.mean())
        told = calibrated(next_door(1e6, mesh), ("Direct", "Diffuse"))
        good = told.good and sigmas < 4.5 and max(noises) < 0.1
        figure = f"off by {sigmas:.1f} sigma, noise {noises[0]:.1%}, diffuse {noises[1]:.1%}; {told.figure}"
        return Finding(bool(good), figure, both.seconds)


_bright_neighbour("lamp", mesh=False)
_bright_neighbour("glowing square", mesh=True)
