"""Scale, place and power: the picture does not depend on the unit of length, on the origin, or on the exposure."""

from __future__ import annotations

import numpy as np

from tests.brute import scenes as s

from .lab import Finding, case, same_randoms, shoot
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


@case("power", "a lamp 1e6 times brighter in the next room", "the dim room as without it, and its error bar right")
def bright_neighbour() -> Finding:
    """Two closed boxes side by side; the camera is in the dim one, whose lamp must not be forgotten."""

    def boxes(bright: float):
        wall = s.diffuse(0.5)
        parts = [
            (s.box((-1, -1, -1), (1, 1, 1), inward=True), wall),
            (s.box((1.5, -1, -1), (3.5, 1, 1), inward=True), wall),
        ]
        lamps = [s.area_lamp((0, 0, 0.9), (0, 0, 0), 0.4, 3.0)]
        if bright:
            lamps.append(s.area_lamp((2.5, 0, 0.9), (2.5, 0, 0), 0.4, 3.0 * bright))
        return s.build(parts, lamps, s.camera((0, -0.9, 0), (0, 1, 0), 0.8), picture=s.frame(24))

    alone, both = shoot(boxes(0.0), 8), shoot(boxes(1e6), 8)
    (a, ea), (b, eb) = alone.blocks("Direct"), both.blocks("Direct")
    sigmas = float((np.abs(a - b) / np.sqrt(ea**2 + eb**2 + (0.01 * a.mean()) ** 2)).max())
    noise = float(eb.mean() / a.mean())
    good = sigmas < 5.0 and noise < 0.2
    return Finding(good, f"off by {sigmas:.1f} sigma, noise {noise:.1%} of the mean", both.seconds)
