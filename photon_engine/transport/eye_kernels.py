"""One step of a batch of eye paths: from hit to what is seen there, to a visible point or the next ray."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..bsdf.layout import CLASS_NULL, CLASS_ROUGH, CLASS_SHARP, HOLDOUT, NONE
from ..bsdf.surface import emission, prepare, sample
from ..camera.rays import generate_ray
from ..geometry.surface import offset_origin, surface_point
from ..jit import kernel
from ..lights.sample import lamps_along_ray, suns_along_ray, world_radiance
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, path_key, uniform
from ..vec import add, dot, load3, luminance, madd, max3, mul, scale, store3
from .media import after_surface, no_bits
from .photon_kernels import choose_class


class EyePaths(NamedTuple):
    """Eye paths in flight; kernels compact them in place."""

    o: np.ndarray  # (n, 3) f32, origin of the next ray [m]
    d: np.ndarray  # (n, 3) f32, unit
    beta: np.ndarray  # (n, 3) f32, throughput
    key: np.ndarray  # (n,) u64, random numbers
    pixel: np.ndarray  # (n,) i32, index into the tile
    width: np.ndarray  # (n,) f32, radius of half a pixel's footprint at o [m]
    spread: np.ndarray  # (n,) f32, its growth per metre
    t_max: np.ndarray  # (n,) f32, far clipping along the ray [m]
    bare: np.ndarray  # (n,) bool, only straight passes so far
    unguided: np.ndarray  # (n,) bool, nothing rough met yet: what is seen next guides the denoiser
    inside: np.ndarray  # (n,) i64, bits of the absorbing media it is in; (0,) in a scene without
    sky: np.ndarray  # (n, 3) f32, exact radiance of a varying world where this leg escapes; (0, 3): the lights tell it


class VisiblePoints(NamedTuple):
    """Where eye paths end at a rough lobe."""

    hit: np.ndarray  # (m,) i32, index of the hit in the batch of surfaces
    wo: np.ndarray  # (m, 3) f32
    beta: np.ndarray  # (m, 3) f32, throughput over the probability of ending here
    key: np.ndarray  # (m,) u64
    pixel: np.ndarray  # (m,) i32
    footprint: np.ndarray  # (m,) f32, radius of a pixel on the surface [m]
    inside: np.ndarray  # (m,) i64, as in EyePaths, on the side that is seen


class Tile(NamedTuple):
    """The picture of a run of pixels; float32 (n, channels)."""

    direct: np.ndarray
    caustic: np.ndarray
    diffuse: np.ndarray
    emission: np.ndarray
    environment: np.ndarray
    alpha: np.ndarray
    depth: np.ndarray
    normal: np.ndarray
    albedo: np.ndarray
    caustic_bias: np.ndarray  # see gather_kernels.gather
    diffuse_bias: np.ndarray
    guide_albedo: np.ndarray  # for the denoiser: of the first rough surface, also through glass and in mirrors
    guide_normal: np.ndarray


class EyeRules(NamedTuple):
    """What the camera sees of the world behind things."""

    transparent: bool  # the world is not drawn where nothing else is
    visible: np.ndarray  # (instances,) bool, seen by camera rays
    holdout: np.ndarray  # (instances,) bool, a hole in the picture where the camera sees it straight
    forward: np.ndarray  # (3,) f64, view axis
    eye: np.ndarray  # (3,) f64, the camera's position, recentred [m]


def empty_paths(n: int, media: bool = False) -> EyePaths:
    """Room for n eye paths; media: where something absorbs."""
    f3 = [np.empty((n, 3), np.float32) for _ in range(3)]
    f1 = [np.empty(n, np.float32) for _ in range(3)]
    flags = [np.ones(n, bool) for _ in range(2)]
    return EyePaths(*f3, np.empty(n, np.uint64), np.empty(n, np.int32), *f1, *flags, no_bits(n, media), no_sky())


def no_sky() -> np.ndarray:
    """No exact radiance of the world."""
    return np.zeros((0, 3), np.float32)


def empty_tile(n: int) -> Tile:
    """A black tile of n pixels."""
    rgb = [np.zeros((n, 3), np.float32) for _ in range(5)]
    return Tile(
        *rgb,
        np.ones((n, 1), np.float32),
        np.zeros((n, 1), np.float32),
        *(np.zeros((n, 3), np.float32) for _ in range(6)),
    )


def empty_points(n: int, media: bool = False) -> VisiblePoints:
    """Room for n visible points; media: where something absorbs."""
    return VisiblePoints(
        np.empty(n, np.int32),
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.uint64),
        np.empty(n, np.int32),
        np.empty(n, np.float32),
        no_bits(n, media),
    )


@kernel
def camera_rays(camera, key, region, first, paths):
    """Eye paths of pixels first, first + stride, ... of a region, row by row.

    region : (x0, y0, width, full width of the frame, stride) [px]
    """
    for i in range(len(paths.key)):
        index = first + i * region[4]
        x = region[0] + index % region[2]
        y = region[1] + index // region[2]
        k = path_key(key, y * region[3] + x)
        o, d, t_near, t_far, spread, width = generate_ray(
            camera, x, y, uniform(k, 0), uniform(k, 1), uniform(k, 2), uniform(k, 3)
        )
        store3(paths.o, i, madd(o, t_near, d))
        store3(paths.d, i, d)
        store3(paths.beta, i, (1.0, 1.0, 1.0))
        paths.key[i] = k
        paths.pixel[i] = i
        paths.width[i] = width + spread * t_near
        paths.spread[i] = spread
        paths.t_max[i] = t_far - t_near
        paths.bare[i] = True
        paths.unguided[i] = True


@kernel
def add3(a, i, v):
    """Add a colour to row i."""
    a[i, 0] += v[0]
    a[i, 1] += v[1]
    a[i, 2] += v[2]


@kernel
def _escape(radiance, rules, beta, bare, unguided, pixel, tile):
    """A path that left the scene: the world, unless the film is transparent there."""
    if bare and rules.transparent:
        tile.alpha[pixel, 0] -= (beta[0] + beta[1] + beta[2]) / 3.0
        return
    light = mul(beta, radiance)
    add3(tile.environment, pixel, light)
    if unguided:
        add3(tile.guide_albedo, pixel, clamp01(light))


@kernel
def clamp01(v):
    """A colour held to [0, 1]: what the denoiser takes for an albedo."""
    return (min(max(v[0], 0.0), 1.0), min(max(v[1], 0.0), 1.0), min(max(v[2], 0.0), 1.0))


@kernel
def _albedo(scratch, kinds, lowest):
    """What the lobes of the classes from `lowest` on reflect and transmit; after prepare."""
    out = (0.0, 0.0, 0.0)
    for k in range(len(kinds)):
        if kinds[k] == NONE:  # beyond it scratch holds another hit's lobes
            break
        if scratch[k, 4] >= lowest and scratch[k, 3] > 0.0:
            weight = (scratch[k, 0], scratch[k, 1], scratch[k, 2])
            out = madd(out, scratch[k, 3] / luminance(weight), weight)
    return out


@kernel
def _first_hit(rules, pixel, p, facing, albedo, tile):
    """Depth along the view axis, normal toward the camera and colour of the first thing seen, at p."""
    away = (p[0] - rules.eye[0], p[1] - rules.eye[1], p[2] - rules.eye[2])
    tile.depth[pixel, 0] = dot(away, (rules.forward[0], rules.forward[1], rules.forward[2]))
    store3(tile.normal, pixel, facing)
    add3(tile.albedo, pixel, albedo)


@kernel
def _guide(pixel, beta, facing, albedo, tile):
    """What guides the denoiser: colour and normal of the first rough surface, weighed by the way to it.

    A surface that reflects by rough and by sharp lobes guides by its rough ones alone: no choice, no noise.
    """
    add3(tile.guide_albedo, pixel, clamp01(mul(beta, albedo)))
    add3(tile.guide_normal, pixel, scale(facing, min(luminance(beta), 1.0)))


@kernel
def normal_spread(geometry, prim):
    """How fast the shading normal turns over a triangle [rad/m]: largest change along an edge over its length."""
    row = geometry.normal_row[prim]
    if row < 0:
        return 0.0
    worst = 0.0
    for a in range(3):
        b = (a + 1) % 3
        p = load3(geometry.positions, geometry.triangles[prim, a])
        q = load3(geometry.positions, geometry.triangles[prim, b])
        m, n = load3(geometry.normals[row], a), load3(geometry.normals[row], b)
        edge = math.sqrt((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2)
        turn = math.sqrt((m[0] - n[0]) ** 2 + (m[1] - n[1]) ** 2 + (m[2] - n[2]) ** 2)
        if edge > 0.0:
            worst = max(worst, turn / edge)
    return worst


@kernel
def eye_step(laws, rules, lights, surfaces, paths, bounce, points, tile):
    """Carry eye paths through their hits.

    Adds what is seen (world, lamps, emission) to the tile, writes visible points, compacts the paths that go on to the
    front; out: how many go on, how many visible points there are.
    """
    geometry, rows = surfaces.geometry, surfaces.rows
    alive = 0
    ended = 0
    for i in range(len(paths.key)):
        prim = surfaces.prim[i]
        t = float(surfaces.t[i]) if prim >= 0 else math.inf
        _lamps_and_sky(lights, rules, paths, i, t, tile)
        if prim < 0:
            continue
        p, ng, ns = surface_point(geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
        wo = scale(load3(paths.d, i), -1.0)
        frame = (p, ns, ng, wo)
        hidden = paths.bare[i] and not rules.visible[geometry.instance[prim]]
        cls, p_class, u0 = CLASS_NULL, 1.0, 0.0
        if not hidden:
            cls, p_class, u0 = _decide(laws, rules, surfaces, paths, i, frame, bounce, tile)
        if p_class == 0.0:
            continue
        width = float(paths.width[i]) + float(paths.spread[i]) * t
        beta = load3(paths.beta, i)
        if cls == CLASS_ROUGH:
            stretch = 2.0 / math.sqrt(max(abs(dot(wo, ng)), 0.1))
            _end(points, ended, paths, i, wo, scale(beta, 1.0 / p_class), width * stretch)
            ended += 1
            continue
        go_on, wi, eta = True, scale(wo, -1.0), 1.0
        if not hidden:
            go_on, wi, beta, eta = _continue(
                rows,
                surfaces.row[i],
                frame,
                cls,
                (p_class, u0),
                laws.threshold,
                surfaces.scratch,
                beta,
                paths.key[i],
                bounce,
            )
        if not go_on:
            continue
        spread = float(paths.spread[i])
        if cls == CLASS_SHARP:
            spread += (2.0 if eta == 1.0 else abs(1.0 - 1.0 / eta)) * width * normal_spread(geometry, prim)
        _advance(paths, alive, i, t, spread)
        paths.width[alive] = width
        paths.bare[alive] = paths.bare[alive] and cls == CLASS_NULL
        if len(paths.inside):
            paths.inside[alive] = after_surface(laws.media, paths.inside[i], prim, dot(ng, wo), dot(ng, wi))
        store3(paths.o, alive, offset_origin(p, ng, wi, laws.reach))
        store3(paths.d, alive, wi)
        store3(paths.beta, alive, beta)
        alive += 1
    return alive, ended


@kernel
def _lamps_and_sky(lights, rules, paths, i, t, tile):
    """Add the lamps that a ray meets before t, and what lies behind everything when t is infinite."""
    beta, o, d = load3(paths.beta, i), load3(paths.o, i), load3(paths.d, i)
    from_camera = 1 if paths.bare[i] else 0
    light = lamps_along_ray(lights, o, d, t, o, 0.0, 0, from_camera)
    if t == math.inf:
        light = add(light, suns_along_ray(lights, d, o, 0.0, 0, from_camera))
        radiance = load3(paths.sky, i) if len(paths.sky) else world_radiance(lights, d)
        _escape(radiance, rules, beta, paths.bare[i], paths.unguided[i], paths.pixel[i], tile)
    light = mul(beta, light)
    add3(tile.emission, paths.pixel[i], light)
    if paths.unguided[i]:
        add3(tile.guide_albedo, paths.pixel[i], clamp01(light))


@kernel
def _decide(laws, rules, surfaces, paths, i, frame, bounce, tile):
    """What becomes of a path at its hit: class of lobes, its probability (0: it ends here), a fresh random number.

    Adds emission, and depth, normal and colour of the first thing seen. frame : (p, ns, ng, wo).
    """
    p, ns, ng, wo = frame
    rows, row, scratch = surfaces.rows, surfaces.row[i], surfaces.scratch
    pixel = paths.pixel[i]
    beta = load3(paths.beta, i)
    hole = paths.bare[i] and rules.holdout[surfaces.geometry.instance[surfaces.prim[i]]]
    if hole or rows.kind[row, 0] == HOLDOUT:
        tile.alpha[pixel, 0] -= (beta[0] + beta[1] + beta[2]) / 3.0
        return CLASS_ROUGH, 0.0, 0.0
    p_null, p_sharp, p_rough = prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
    light = mul(beta, emission(rows, row, scratch))
    add3(tile.emission, pixel, light)
    cls, p_class, u0 = CLASS_ROUGH, 0.0, 0.0
    if p_null + p_sharp + p_rough > 0.0:
        u = uniform(paths.key[i], (bounce + 1) * DIMENSIONS_PER_BOUNCE)
        cls, p_class, u0 = choose_class(p_null, p_sharp, p_rough, u)
    if cls == CLASS_NULL or not (paths.bare[i] or paths.unguided[i]):
        return cls, p_class, u0
    facing = ns if dot(wo, ng) >= 0.0 else scale(ns, -1.0)
    # the weights hold a mix with a transparent lobe, and so does the chance of coming here
    here = 1.0 if p_null == 0.0 else (p_null + p_sharp + p_rough) / (p_sharp + p_rough)
    if paths.bare[i]:
        _first_hit(rules, pixel, p, facing, scale(_albedo(scratch, rows.kind[row], CLASS_SHARP), here), tile)
    if paths.unguided[i] and (p_rough > 0.0 or p_sharp == 0.0):
        own = scale(_albedo(scratch, rows.kind[row], CLASS_ROUGH), here)
        _guide(pixel, beta, facing, own if p_rough > 0.0 else emission(rows, row, scratch), tile)
        paths.unguided[i] = False
    return cls, p_class, u0


@kernel
def _end(points, m, paths, i, wo, beta, footprint):
    """Write visible point m: path i ends at its hit."""
    points.hit[m] = i
    store3(points.wo, m, wo)
    store3(points.beta, m, beta)
    points.key[m] = paths.key[i]
    points.pixel[m] = paths.pixel[i]
    points.footprint[m] = footprint
    if len(points.inside):
        points.inside[m] = paths.inside[i]


@kernel
def _advance(paths, to, i, t, spread):
    """Move what a path keeps from place i to place `to` <= i, after a leg of length t."""
    paths.spread[to] = spread
    paths.t_max[to] = paths.t_max[i] - t
    paths.key[to] = paths.key[i]
    paths.pixel[to] = paths.pixel[i]
    paths.bare[to] = paths.bare[i]
    paths.unguided[to] = paths.unguided[i]


@kernel
def _continue(rows, row, frame, cls, choice, threshold, scratch, beta, key, bounce):
    """Next direction and throughput of an eye path; refraction scales radiance by 1 / eta^2 [Veach 1997, 5.2]."""
    nothing = (False, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0)
    _, ns, ng, wo = frame
    dim = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    u = (choice[1], uniform(key, dim + 1), uniform(key, dim + 2))
    ok, wi, weight, _, eta = sample(rows, row, ns, ng, wo, cls, scratch, u, 0, threshold)
    if not ok:
        return nothing
    s = 1.0 / choice[0]
    out = (beta[0] * weight[0] * s, beta[1] * weight[1] * s, beta[2] * weight[2] * s)
    if max3(out) <= 0.0:
        return nothing
    if bounce > 3:  # the first bounces always go on, so that what is seen in glass has no extra noise
        survival = min(1.0, max3(out) / max3(beta))
        if uniform(key, dim + 3) >= survival:
            return nothing
        out = scale(out, 1.0 / survival)
    return True, wi, scale(out, 1.0 / (eta * eta)), eta
