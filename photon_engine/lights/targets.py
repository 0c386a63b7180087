"""Spheres worth aiming photons at, which of them each light serves, and the aimed photons themselves."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..jit import inlined, kernel
from ..sampling.sobol import sobol
from ..sampling.warps import square_to_disk
from ..vec import dot, load3, luminance, madd, mul, scale, sub
from .aim import (
    area_toward,
    area_toward_pdf_w,
    beam_line_pdf,
    crosses,
    disk_line_pdf,
    distant_line,
    round_line,
    round_line_pdf,
    spot_is_narrower,
    spread_is_narrower,
    toward,
    toward_pdf_w,
)
from .area import area_gain, area_inside, area_local, area_point
from .beams import radiance_along
from .emit import area_origin, from_outside, round_surface
from .mesh import leave_mesh, mesh_origin, triangle_radiance
from .round import spot_falloff
from .select import pick
from .table import AREA, DELTA, MESH, SUN, WORLD, LightTable, make_cdf

MAX_TARGETS = 16
PILOT = 256  # photons with which the flux of a light into a sphere is estimated
FLOOR = 0.05  # of each light's photons is shared by all spheres, and of all photons by all lights
BLACK = (0.0, 0.0, 0.0)


class Targets(NamedTuple):
    """C spheres for L lights."""

    center: np.ndarray  # (C, 3) f64 [m]
    radius: np.ndarray  # (C,) f64 [m]
    pick: np.ndarray  # (L, C) f64, cumulative: which sphere a photon of a light is aimed at
    flux: np.ndarray  # (L, C) f64, estimated flux (luminance) of the light into the sphere [W]
    aimed_cdf: np.ndarray  # (L,) f64, cumulative: which light an aimed photon leaves, by flux into the spheres


def build_targets(lights: LightTable, centers: np.ndarray, radii: np.ndarray) -> Targets:
    """Targets from bounding spheres (n, 3), (n,) of what photons should reach, merged to at most MAX_TARGETS."""
    center, radius = merge_spheres(np.asarray(centers, np.float64), np.asarray(radii, np.float64))
    n_lights, n = len(lights.kind), len(radius)
    even = np.tile((np.arange(n) + 1.0) / max(n, 1), (n_lights, 1))
    blank = Targets(center, radius, even, np.zeros((n_lights, n)), np.zeros(n_lights))
    if n_lights == 0 or n == 0:
        return blank
    flux = np.zeros((n_lights, n))
    estimate_flux(lights, blank, pilot_numbers(PILOT), flux)
    cdf = np.array([make_cdf(shares(row)) for row in flux])
    return Targets(center, radius, cdf, flux, make_cdf(shares(flux.sum(axis=1))))


def shares(flux: np.ndarray) -> np.ndarray:
    """Probabilities by flux, (n,), of which FLOOR goes evenly to all; to all of it where there is no flux."""
    n, total = len(flux), flux.sum()
    return FLOOR / n + (1.0 - FLOOR) * (flux / total if total > 0.0 else np.full(n, 1.0 / n))


def pilot_numbers(n: int) -> np.ndarray:
    """(n, 4) well spread points of the unit cube: Sobol's sequence, moved off the corner; n a power of 2."""
    return sobol(n, 4) * 2.0**-32 + 0.5 / n


def merge_spheres(center: np.ndarray, radius: np.ndarray, limit: int = MAX_TARGETS) -> tuple[np.ndarray, np.ndarray]:
    """At most `limit` spheres (C, 3), (C,) that contain all of the given ones; a sphere within another is dropped."""
    spheres = [(c, float(r)) for c, r in _halve(center.reshape(-1, 3), radius.reshape(-1), 4 * limit)]
    while len(spheres) > 1:
        c = np.array([s[0] for s in spheres])
        r = np.array([s[1] for s in spheres])
        d = np.linalg.norm(c[:, None] - c[None], axis=2)
        joint = np.maximum(np.maximum(r[:, None], r[None]), 0.5 * (d + r[:, None] + r[None]))
        # what merging adds to the cross-sections that photons are spent on
        cost = joint**2 - r[:, None] ** 2 - r[None] ** 2
        cost[np.tril_indices(len(r))] = np.inf
        a, b = np.unravel_index(np.argmin(cost), cost.shape)
        if cost[a, b] > 0.0 and len(spheres) <= limit:
            break
        spheres[a] = _enclose(spheres[a], spheres[b])
        del spheres[b]
    return np.array([s[0] for s in spheres], np.float64).reshape(-1, 3), np.array([s[1] for s in spheres], np.float64)


def _halve(center: np.ndarray, radius: np.ndarray, limit: int) -> list[tuple[np.ndarray, float]]:
    """Enclosing spheres of at most `limit` groups, split at medians: quick for thousands of spheres."""
    if len(radius) <= 1 or limit <= 1:
        group = None
        for sphere in zip(center, radius, strict=True):
            group = sphere if group is None else _enclose(group, sphere)
        return [] if group is None else [group]
    if len(radius) <= limit:
        return list(zip(center, radius, strict=True))
    order = np.argsort(center[:, np.argmax(np.ptp(center, axis=0))])
    half = len(order) // 2
    parts = (order[:half], order[half:])
    return [sphere for part in parts for sphere in _halve(center[part], radius[part], limit // 2)]


def _enclose(a: tuple, b: tuple) -> tuple[np.ndarray, float]:
    """Smallest sphere around two spheres (center, radius)."""
    d = float(np.linalg.norm(b[0] - a[0]))
    if d + b[1] <= a[1]:
        return a
    if d + a[1] <= b[1]:
        return b
    r = 0.5 * (d + a[1] + b[1])
    return a[0] + (b[0] - a[0]) * ((r - a[1]) / d), r * (1.0 + 1e-12)


@inlined
def emit_aimed(lights, targets, l, u_pick, u0, u1, u2, u3):
    """A photon of light l aimed at one of the targets: (o, d, phi, m) as `emit_photon`.

    phi holds 1 / (the mixture's density over all targets), so that among the photons that hit any target the flux is
    that of `emit_photon`. phi = black: nothing leaves that way.
    """
    c, _, _ = pick(targets.pick[l], u_pick)
    kind = lights.kind[l]
    if kind == MESH:
        return _aimed_mesh(lights, targets, l, c, u0, u1, u2, u3)
    if kind == AREA:
        o, d, phi = _aimed_area(lights, targets, l, c, u0, u1, u2, u3)
        return o, d, phi, -1
    center = load3(targets.center, c)
    radius = targets.radius[c]
    if kind == SUN or kind == WORLD:
        o, d, phi = aim_distant(lights, targets, l, c, u0, u1, u2, u3)
        return o, d, phi, -1
    x, d = round_line(lights, l, center, radius, u0, u1, u2, u3)
    r = sub(load3(lights.position, l), x)
    o = madd(x, dot(r, d), d)
    off = sub(o, load3(lights.position, l))
    gain = spot_falloff(lights, l, d)
    if gain == 0.0 or dot(off, off) > lights.size[l, 0] * lights.size[l, 0]:
        return o, d, BLACK, -1
    if spot_is_narrower(lights, l, center, radius) and round_line_pdf(lights, l, center, radius, o, d) == 0.0:
        return o, d, BLACK, -1  # its beam misses the target
    density = round_mixture(lights, targets, l, o, d)
    if density <= 0.0:  # rounding left the target
        return o, d, BLACK, -1
    gain /= density
    return round_surface(lights, l, o, d), d, scale(radiance_along(lights, l, d), gain), -1


@inlined
def aim_distant(lights, targets, l, c, u0, u1, u2, u3):
    """A photon of a sun or the world through the disk of target c: (o, d, phi)."""
    x, d, le = distant_line(lights, l, load3(targets.center, c), targets.radius[c], u0, u1, u2, u3)
    density = disk_mixture(targets, l, x, d)
    phi = scale(le, 1.0 / density) if density > 0.0 else BLACK  # rounding left the target
    return from_outside(lights, x, d), d, phi


@inlined
def share(targets, l, c):
    """Probability with which a photon of light l is aimed at target c."""
    return targets.pick[l, c] - (targets.pick[l, c - 1] if c > 0 else 0.0)


@inlined
def cone_mixture(targets, l, o, d):
    """Density [1/sr] of direction d from o over all targets of light l."""
    total = 0.0
    for c in range(targets.radius.shape[0]):
        total += share(targets, l, c) * toward_pdf_w(o, load3(targets.center, c), targets.radius[c], d)
    return total


@inlined
def disk_mixture(targets, l, x, d):
    """Density [1/m^2] of the line (x, d) over the disks of all targets of light l."""
    total = 0.0
    for c in range(targets.radius.shape[0]):
        total += share(targets, l, c) * disk_line_pdf(load3(targets.center, c), targets.radius[c], x, d)
    return total


@inlined
def area_mixture(lights, targets, l, o, d):
    """Density [1/sr] of direction d from the point o of an area lamp over all targets."""
    total = 0.0
    for c in range(targets.radius.shape[0]):
        density = area_toward_pdf_w(lights, l, o, load3(targets.center, c), targets.radius[c], d)
        total += share(targets, l, c) * density
    return total


@inlined
def beam_mixture(lights, targets, l, x, d):
    """Density [1/m^2] of the line (x, d) of parallel rays over all targets."""
    total = 0.0
    for c in range(targets.radius.shape[0]):
        total += share(targets, l, c) * beam_line_pdf(lights, l, load3(targets.center, c), targets.radius[c], x, d)
    return total


@inlined
def round_mixture(lights, targets, l, x, d):
    """Density of the line (x, d) of a point or spot lamp over all targets, as `aim.round_line_pdf`."""
    total = 0.0
    for c in range(targets.radius.shape[0]):
        total += share(targets, l, c) * round_line_pdf(lights, l, load3(targets.center, c), targets.radius[c], x, d)
    return total


@inlined
def _aimed_area(lights, targets, l, c, u0, u1, u2, u3):
    """From a uniform point of the lamp into the cone of target c; parallel rays through the target's disk."""
    center = load3(targets.center, c)
    radius = targets.radius[c]
    normal = load3(lights.normal, l)
    if lights.flags[l] & DELTA:
        return _aimed_beam(lights, targets, l, c, u0, u1)
    o = area_origin(lights, l, u0, u1)
    d = area_toward(lights, l, o, center, radius, u2, u3)
    cosine = dot(normal, d)
    gain = area_gain(lights, l, cosine)
    density = area_mixture(lights, targets, l, o, d)
    missed = spread_is_narrower(lights, l, o, center, radius) and toward_pdf_w(o, center, radius, d) == 0.0
    if gain == 0.0 or missed or density <= 0.0:
        return o, d, BLACK
    return o, d, scale(radiance_along(lights, l, d), gain * cosine * lights.size[l, 2] / density)


@inlined
def _aimed_beam(lights, targets, l, c, u0, u1):
    """Parallel rays: from a point of the lamp, or of target c's disk in the lamp's plane, whichever is smaller."""
    center, radius = load3(targets.center, c), targets.radius[c]
    normal = load3(lights.normal, l)
    x, y, height = area_local(lights, l, center)
    if lights.size[l, 2] < math.pi * radius * radius:
        o = area_origin(lights, l, u0, u1)
        lit = crosses(o, normal, center, radius)
    else:
        a, b = square_to_disk(u0, u1)
        a, b = x + radius * a, y + radius * b
        o = area_point(lights, l, a, b)
        lit = area_inside(lights, l, a, b)
    density = beam_mixture(lights, targets, l, o, normal) if lit else 0.0  # 0 too where rounding leaves the disk
    if height + radius < 0.0 or density <= 0.0:
        return o, normal, BLACK
    return o, normal, scale(radiance_along(lights, l, normal), 1.0 / density)


@inlined
def _aimed_mesh(lights, targets, l, c, u0, u1, u2, u3):
    """From a point of the emissive triangles, by flux, into the cone of target c; both sides radiate."""
    m, o, normal, density = mesh_origin(lights, u0, u1)
    d = toward(o, load3(targets.center, c), targets.radius[c], u2, u3)
    density *= cone_mixture(targets, l, o, d)
    gain = abs(dot(normal, d)) / density if density > 0.0 else 0.0  # rounding left the target
    return leave_mesh(lights, m, o, normal, d), d, scale(triangle_radiance(lights, m), gain), m


@kernel
def estimate_flux(lights, targets, numbers, flux):
    """Luminance of each light's flux into the cone of each target -> flux (L, C); numbers (n, 4) in [0, 1)."""
    n = numbers.shape[0]
    count = targets.radius.shape[0]
    for l in range(lights.kind.shape[0]):
        for c in range(count):
            # aim at c; the mixture's density with even shares is undone below, so that overlaps are shared out
            u_pick = (c + 0.5) / count
            total = 0.0
            for i in range(n):
                u0, u1, u2, u3 = numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3]
                _, _, phi, m = emit_aimed(lights, targets, l, u_pick, u0, u1, u2, u3)
                if m >= 0 and lights.tri_shaded[m]:
                    phi = mul(phi, load3(lights.tri_radiance, m))
                total += luminance(phi)
            flux[l, c] = total / (n * count)
