"""Pictures with light focused by mirrors and glass, however small its source: where neither a path from the eye meets
the lamp nor one from the lamp meets the eye.

Every mirror and glass triangle, as the renderer sees it (its own corners, its interpolated normals), is cut finely;
each piece takes the light that lamps send to it, bends it on and lays it down where it first falls on a rough surface:
a map of irradiance over rough triangles. The piece is the first mirror or glass of its path, so each path counts once,
and the pieces divide the surface evenly, so the map converges faster than photons do. Paths from the eye then read the
map at each rough vertex, cast shadow rays for what lamps send straight, and meet the world by chance, but lamps never.

Shares with tests/brute its intersections, scattering and lamps; with the engine only the scene's records.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from photon_engine.issues import RenderError
from tests.brute.bvh import intersect
from tests.brute.compiled import Compiled, compile_scene
from tests.brute.film import eye_ray, filter_offset, make_view
from tests.brute.jit import kernel
from tests.brute.lamps import lamps_seen, toward_lamp
from tests.brute.materials import (
    ABSORBED,
    GLASS,
    LAMBERT,
    METAL,
    MIRROR,
    NULL,
    REFRACTION,
    ROUGH,
    SHARP,
    TRANSLUCENT,
    has_rough,
    scatter,
    summed_color,
)
from tests.brute.maths import dot, madd, mul, row, scale, uniform
from tests.brute.path_tracer import SAFETY_DEPTH, direct_light, place, roulette, shading_frame, transmittance

MOST_BOUNCES = 256
MOST_CELLS = 1024  # along a triangle's edge


class IrradianceMap(NamedTuple):
    """Irradiance [W/m^2] of rough triangles, in cells of their barycentric coordinates."""

    first: np.ndarray  # (T,) i64, first cell of each triangle; -1: not rough
    count: np.ndarray  # (T,) i32, cells along its edges
    area: np.ndarray  # (N,) f64 [m^2]
    light: np.ndarray  # (2, N, 3) f64, on the back and on the front


def empty_map(sc: Compiled, cell: float) -> IrradianceMap:
    """A black map with cells of about `cell` [m] along the edges."""
    kinds = sc.lobe_kind[sc.material]
    rough = (kinds == LAMBERT).any(axis=1)
    edge = np.sqrt(2.0 * sc.area)
    count = np.where(rough, np.clip(np.ceil(edge / cell), 1, MOST_CELLS), 0).astype(np.int32)
    size = count.astype(np.int64) ** 2
    first = np.where(rough, np.cumsum(size) - size, -1)
    area = np.repeat(2.0 * sc.area / np.maximum(size, 1), size)
    for i in np.flatnonzero(rough):
        n = count[i]
        diagonal = np.arange(n) * n + (n - 1 - np.arange(n))  # cells that the triangle's long edge halves
        area[first[i] + diagonal] *= 0.5
    return IrradianceMap(first, count, area, np.zeros((2, len(area), 3)))


@kernel
def cell_of(grid, i, u, v):
    """Cell of a point of rough triangle i."""
    n = grid.count[i]
    a, b = min(int(u * n), n - 1), min(int(v * n), n - 1)
    over = a + b - (n - 1)
    if over > 0:
        a -= min(over, a)
        b = min(b, n - 1 - a)
    return grid.first[i] + a * n + b


@kernel
def lay_beam(sc, grid, i, u, v, share, state, stack):
    """Carry what all lamps send to a piece of area `share` [m^2] around a point of sharp triangle i into the map."""
    w = 1.0 - u - v
    e1, e2 = row(sc.tree.e1, i), row(sc.tree.e2, i)
    p = madd(madd(row(sc.tree.v0, i), u, e1), v, e2)
    for lamp in range(len(sc.lamp_kind)):
        wi, distance, light = toward_lamp(sc, lamp, p, state)
        if distance <= 0.0 or max(light) <= 0.0 or w < 0.0:
            continue
        light = mul(light, transmittance(sc, p, wi, distance, i, stack))
        if max(light) <= 0.0:
            continue
        phi = scale(light, share * abs(dot(wi, row(sc.ng, i))))
        carry(sc, grid, i, u, v, p, scale(wi, -1.0), phi, state, stack)


@kernel
def carry(sc, grid, i, u, v, p, d, phi, state, stack):
    """Bend a beam of flux phi [W] that falls along d on sharp triangle i until it meets a rough surface."""
    largest = max(phi)
    sharp = 0
    for depth in range(MOST_BOUNCES):
        at = place(sc, i, u, v)
        ng, ns, front = shading_frame(sc, i, u, v, d)
        wo = scale(d, -1.0)
        if sharp > 0 and has_rough(sc, at):
            lit = dot(wo, ns) / dot(wo, ng)
            if lit > 0.0:
                k, side = cell_of(grid, i, u, v), 1 if front else 0
                for c in range(3):
                    grid.light[side, k, c] += phi[c] * lit / grid.area[k]
        event, wi, weight, _ = scatter(sc, at, wo, ng, ns, front, state)
        if event == ABSORBED or event == ROUGH or (event == NULL and sharp == 0):
            return
        phi = mul(phi, weight)
        if event == SHARP:
            # flux falls on the true surface, f integrates about the shading normal [Veach 1997, section 5.3]
            phi = scale(phi, abs(dot(ns, wo) * dot(ng, wi) / (dot(ng, wo) * dot(ns, wi))))
            sharp += 1
        q = min(1.0, max(phi) / largest) if depth > 3 else 1.0
        if q == 0.0 or uniform(state) >= q:
            return
        phi, d = scale(phi, 1.0 / q), wi
        i, t, u, v = intersect(sc.tree, p, d, np.inf, i, stack)
        if i < 0:
            return
        p = madd(p, t, d)


@kernel
def lay_beams(sc, grid, triangles, cuts, seed):
    """Add the light that `triangles` bend to the map; each is cut into cuts^2 pieces, lit at a random point of each."""
    stack, state = np.empty(256, np.int32), np.zeros(1, np.uint64)
    state[0] = np.uint64(seed) * np.uint64(0xE7037ED1A0B428DB) + np.uint64(0x8EBC6AF09C88C6E3)
    for k in range(len(triangles)):
        i, n = triangles[k], cuts[k]
        for a in range(n):
            for b in range(2 * (n - a) - 1):
                x, y = uniform(state), uniform(state)
                if x + y > 1.0:
                    x, y = 1.0 - x, 1.0 - y
                if b % 2:  # a piece that stands on its tip
                    x, y = 1.0 - x, 1.0 - y
                lay_beam(sc, grid, i, (a + x) / n, (b // 2 + y) / n, sc.area[i] / (n * n), state, stack)


@kernel
def light_seen(sc, grid, o, d, t_max, state, stack):
    """Radiance along a ray by paths with a rough vertex."""
    out, beta, growth = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 1.0
    rough, depth, skip = 0, 0, -1
    for _ in range(SAFETY_DEPTH):
        i, t, u, v = intersect(sc.tree, o, d, t_max, skip, stack)
        if i < 0:
            return madd(out, 1.0 if rough else 0.0, mul(beta, (sc.world[0], sc.world[1], sc.world[2])))
        at = place(sc, i, u, v)
        ng, ns, front = shading_frame(sc, i, u, v, d)
        wo = scale(d, -1.0)
        o, skip = madd(o, t, d), i
        if has_rough(sc, at):
            out = madd(out, 1.0, mul(beta, direct_light(sc, at, o, wo, ng, ns, i, False, stack, state)))
            light = row(grid.light[1 if front else 0], cell_of(grid, i, u, v))
            out = madd(out, 1.0 / math.pi, mul(mul(beta, summed_color(sc, at, LAMBERT)), light))
        event, d, weight, eta = scatter(sc, at, wo, ng, ns, front, state)
        beta = scale(mul(beta, weight), 1.0 / (eta * eta))
        if event == NULL:
            t_max -= t
            continue
        t_max, depth, growth = np.inf, depth + 1, growth * eta * eta
        if event == ABSORBED or depth > MOST_BOUNCES:
            return out
        rough += 1 if event == ROUGH else 0
        if depth > 3:
            beta = roulette(beta, growth, state)
            if max(beta) == 0.0:
                return out
    return out


@kernel
def lights_seen(sc, o, d, t_max, state, stack):
    """Radiance along a ray of lamps and world as mirrors and glass show them: no rough vertex."""
    out, beta, skip = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), -1
    by_camera = True
    for _ in range(MOST_BOUNCES):
        i, t, u, v = intersect(sc.tree, o, d, t_max, skip, stack)
        out = madd(out, 1.0, mul(beta, lamps_seen(sc, o, d, t if i >= 0 else np.inf, by_camera)))
        if i < 0:
            return madd(out, 1.0, mul(beta, (sc.world[0], sc.world[1], sc.world[2])))
        ng, ns, front = shading_frame(sc, i, u, v, d)
        o, skip = madd(o, t, d), i
        event, wi, weight, eta = scatter(sc, place(sc, i, u, v), scale(d, -1.0), ng, ns, front, state)
        if event == ABSORBED or event == ROUGH:
            return out
        d, beta = wi, scale(mul(beta, weight), 1.0 / (eta * eta))
        if event == NULL:
            t_max -= t
        else:
            t_max, by_camera = np.inf, False
    return out


@kernel
def look(sc, view, grid, spp, seed, out):
    """Add the mean over samples of each pixel to out (h, w, 3); spp: (paths that reach a rough vertex, others)."""
    stack, state = np.empty(256, np.int32), np.zeros(1, np.uint64)
    x0, y0, x1, y1 = view.border
    for y in range(y1 - y0):
        state[0] = np.uint64(seed) * np.uint64(0xD1342543DE82EF95) + np.uint64(y + 1) * np.uint64(0xA0761D6478BD642F)
        for x in range(x1 - x0):
            for kind in range(2):
                for _ in range(spp[kind]):
                    px = x0 + x + 0.5 + filter_offset(view, uniform(state))
                    py = y0 + y + 0.5 + filter_offset(view, uniform(state))
                    o, d, t_max = eye_ray(view, px, py)
                    if kind == 0:
                        light = light_seen(sc, grid, o, d, t_max, state, stack)
                    else:
                        light = lights_seen(sc, o, d, t_max, state, stack)
                    for c in range(3):
                        out[y, x, c] += light[c] / spp[kind]


def check(sc: Compiled) -> None:
    """Refuse what this tool does not know."""
    if len(sc.glow):
        raise RenderError("scene", "an emissive mesh", "the beams know lamps and a constant world")
    if (sc.lobe_kind == TRANSLUCENT).any():
        raise RenderError("scene", "a translucent material", "the beams know Lambert as the only rough surface")


def render(scene, spp: tuple[int, int], beams: int, cell: float, seed: int = 1, compiled: Compiled | None = None):
    """One batch: a picture (h, w, 3) f64 [W/m^2/sr], exposure applied, bottom row first.

    spp : eye paths a pixel for light from rough surfaces, and for lamps and world seen in mirrors and through glass
    beams : about how many pieces mirrors and glass are cut into;  cell : size of the map's cells [m].
    """
    sc, view = compiled or compile_scene(scene), make_view(scene)
    check(sc)
    sharp = np.isin(sc.lobe_kind, (MIRROR, GLASS, REFRACTION, METAL)).any(axis=1)[sc.material]
    triangles = np.flatnonzero(sharp)
    area = sc.area[triangles]
    cuts = np.maximum(1, np.round(np.sqrt(beams * area / max(area.sum(), 1e-300)))).astype(np.int64)
    grid = empty_map(sc, cell)
    lay_beams(sc, grid, triangles, cuts, seed)
    x0, y0, x1, y1 = view.border
    out = np.zeros((y1 - y0, x1 - x0, 3))
    look(sc, view, grid, spp, seed, out)
    return out * scene.frame.exposure
