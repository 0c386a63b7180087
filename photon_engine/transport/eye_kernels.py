"""One step of a batch of eye paths: from hit to what is seen there, to a visible point or the next ray."""

from __future__ import annotations

import math

from ..bsdf.layering import IDEAL, class_total
from ..bsdf.layout import CLASS_DEEP, CLASS_NULL, CLASS_ROUGH, CLASS_SHARP, HOLDOUT, NONE, ROUGHNESS, TRANSPARENT
from ..bsdf.split import is_fork, sample_side, sides, straight_through
from ..bsdf.surface import emission, prepare, sample
from ..film.passes import BACKGROUND_DEPTH
from ..geometry.surface import leave, surface_point
from ..jit import inlined, kernel
from ..lights.sample import lamps_along_ray, suns_along_ray, world_radiance
from ..sampling.even import even_pair
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, path_key, uniform
from ..shading.trail import GLOSSY, SINGULAR, bounced, passed
from ..vec import add, dot, load3, luminance, madd, max3, mul, scale, store3
from .eye_batch import CHOICE, DIRECT_DIMENSION, LATE_DIMENSION, LIGHT, LOBE, SECOND_DIMENSION
from .media import after_surface
from .photon_kernels import choose_class

LEAST_SHARE = 1.0 / 32.0  # of a pixel: a way that carries less is worth its rays only now and then
WIDEST = 1e3  # growth of a footprint per metre; a ray that spreads so sees all
NO_DEPTH = 0.9 * BACKGROUND_DEPTH
UNCLIPPED = 1e30  # [m]


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
def _depth(rules, pixel, p, tile):
    """Depth of p along the view axis, where a pixel has none yet."""
    if tile.depth[pixel, 0] >= NO_DEPTH:
        away = (p[0] - rules.eye[0], p[1] - rules.eye[1], p[2] - rules.eye[2])
        tile.depth[pixel, 0] = dot(away, (rules.forward[0], rules.forward[1], rules.forward[2]))


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
def eye_step(laws, rules, lights, surfaces, paths, bounce, onward, points, tile):
    """Carry eye paths through their hits.

    Adds what is seen (world, lamps, emission) to the tile, writes visible points, and into `onward` the paths that go
    on: one of the ways that lead on, or all of them while a path may still split.
    out: how many go on, how many visible points there are.
    """
    geometry = surfaces.geometry
    alive = 0
    ended = 0
    for i in range(len(paths.key)):
        prim = surfaces.prim[i]
        t = float(surfaces.t[i]) if prim >= 0 else math.inf
        _lamps_and_sky(lights, rules, paths, i, t, tile)
        if prim < 0:
            continue
        p, ng, ns = surface_point(geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
        frame = (p, ns, ng, scale(load3(paths.d, i), -1.0))
        if paths.bare[i] and not rules.visible[geometry.instance[prim]]:
            beta, wi = load3(paths.beta, i), load3(paths.d, i)
            _go_on(laws, surfaces, paths, i, frame, (CLASS_NULL, wi, 1.0, beta, False, False), onward, alive)
            alive += 1
            continue
        weights = _look(laws, rules, surfaces, paths, i, frame, tile)
        if weights[0] + weights[1] + weights[2] <= 0.0:
            continue
        if paths.splits[i] > 0 and is_fork(surfaces.rows.kind[surfaces.row[i]], surfaces.scratch, weights):
            alive, ended = _take_all(
                laws, rules, surfaces, paths, i, bounce, frame, weights, onward, alive, points, ended
            )
        else:
            alive, ended = _take_one(
                laws, rules, surfaces, paths, i, bounce, frame, weights, onward, alive, points, ended, tile
            )
    return alive, ended


@kernel
def _take_one(laws, rules, surfaces, paths, i, bounce, frame, weights, onward, alive, points, ended, tile):
    """One of the ways that lead on from a hit, picked by sampling weight; out: as of `eye_step`."""
    p, ns, ng, wo = frame
    key = paths.key[i]
    dim = first_dimension(bounce)
    cls, p_class, u0 = choose_class(weights[0], weights[1], weights[2], uniform(key, dim))
    beta = load3(paths.beta, i)
    if paths.bare[i] and cls != CLASS_NULL:
        _depth(rules, paths.pixel[i], p, tile)
    if cls == CLASS_ROUGH:
        _end(rules, points, ended, surfaces, paths, i, frame, scale(beta, 1.0 / p_class))
        return alive, ended + 1
    u = (u0, uniform(key, dim + 1), uniform(key, dim + 2))
    ok, wi, weight, pdf_w, eta = sample(
        surfaces.rows, surfaces.row[i], ns, ng, wo, cls, surfaces.scratch, u, 0, laws.threshold
    )
    if not ok:
        return alive, ended
    out = scale(mul(beta, weight), 1.0 / p_class)
    if max3(out) <= 0.0:
        return alive, ended
    if bounce > 3:  # the first bounces always go on, so that what is seen in glass has no extra noise
        survival = min(1.0, max3(out) / max3(beta))
        if uniform(key, dim + 3) >= survival:
            return alive, ended
        out = scale(out, 1.0 / survival)
    way = (cls, wi, eta, out, _is_matte(surfaces, paths, i, weights), pdf_w == 0.0)
    _go_on(laws, surfaces, paths, i, frame, way, onward, alive)
    return alive + 1, ended


@kernel
def _take_all(laws, rules, surfaces, paths, i, bounce, frame, weights, onward, alive, points, ended):
    """All ways that lead on from a hit, each with its own weight: none of the noise of a pick. Out: as of `eye_step`.

    A way that carries little goes on by Russian roulette. Every way has random numbers of its own.
    """
    _, ns, ng, wo = frame
    rows, row, scratch = surfaces.rows, surfaces.row[i], surfaces.scratch
    dim = first_dimension(bounce)
    beta, key = load3(paths.beta, i), paths.key[i]
    matte = _is_matte(surfaces, paths, i, weights)
    lit = kept(max3(beta) * weights[2], key, dim)
    if lit > 0.0:
        _end(rules, points, ended, surfaces, paths, i, frame, scale(beta, lit))
        ended += 1
    for k in range(rows.kind.shape[1]):
        kind = rows.kind[row, k]
        if kind == NONE:
            break
        if scratch[k, 4] > CLASS_SHARP or scratch[k, 4] < CLASS_NULL or scratch[k, 3] <= 0.0:
            continue
        for side in range(sides(kind)):
            fresh = path_key(key, 2 * k + side + 1)
            u1, u2 = uniform(fresh, dim + 1), uniform(fresh, dim + 2)
            ok, wi, weight, eta = sample_side(rows, row, k, side, (ns, ng, wo), scratch, u1, u2)
            out = mul(beta, weight)
            s = kept(max3(out), fresh, dim) if ok else 0.0
            if s > 0.0:
                cls = CLASS_NULL if kind == TRANSPARENT else CLASS_SHARP
                smooth = rows.params[row, k, ROUGHNESS] < IDEAL
                way = (cls, wi, eta, scale(out, s), matte, smooth)
                _go_on(laws, surfaces, paths, i, frame, way, onward, alive)
                onward.key[alive] = fresh
                onward.place[alive] = -1
                onward.splits[alive] = paths.splits[i] - 1
                alive += 1
    return alive, ended


@inlined
def first_dimension(bounce):
    """The first random number of an eye path's bounce; from bounce 255 on they come behind those of visible points."""
    first = (bounce + 1) * DIMENSIONS_PER_BOUNCE
    return first if first < DIRECT_DIMENSION else first + LATE_DIMENSION


@kernel
def kept(share, key, dim):
    """What a way that carries this share of a pixel is multiplied with: 0 where Russian roulette ends it."""
    if share >= LEAST_SHARE:
        return 1.0
    return LEAST_SHARE / share if uniform(key, dim) * LEAST_SHARE < share else 0.0


@kernel
def _is_matte(surfaces, paths, i, weights):
    """Whether hit i, prepared, has lobes that guide the denoiser; not asked where a path has met some already."""
    if weights[2] > 0.0:
        return True
    return paths.unguided[i] and class_total(surfaces.rows, surfaces.row[i], surfaces.scratch, CLASS_DEEP) > 0.0


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
def _look(laws, rules, surfaces, paths, i, frame, tile):
    """Sampling weights of the classes of lobes at a hit, as `prepare` gives them; all 0 where a path ends unseen.

    Adds emission, what guides the denoiser, and depth, normal and colour of what the camera sees straight: behind
    transparent surfaces these count by what is let pass, and depth is that of the first surface which is at least
    half opaque, as in Cycles. frame : (p, ns, ng, wo).
    """
    p, ns, ng, wo = frame
    rows, row, scratch = surfaces.rows, surfaces.row[i], surfaces.scratch
    pixel = paths.pixel[i]
    beta = load3(paths.beta, i)
    hole = paths.bare[i] and rules.holdout[surfaces.geometry.instance[surfaces.prim[i]]]
    if hole or rows.kind[row, 0] == HOLDOUT:
        tile.alpha[pixel, 0] -= (beta[0] + beta[1] + beta[2]) / 3.0
        return 0.0, 0.0, 0.0
    weights = prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
    radiance = emission(rows, row, scratch)
    add3(tile.emission, pixel, mul(beta, radiance))
    if not (paths.bare[i] or paths.unguided[i]):
        return weights
    opacity = 1.0 - luminance(straight_through(rows.kind[row], scratch)) if weights[0] > 0.0 else 1.0
    facing = scale(ns, opacity if dot(wo, ng) >= 0.0 else -opacity)
    if paths.bare[i]:
        if opacity >= 0.5:
            _depth(rules, pixel, p, tile)
        add3(tile.normal, pixel, scale(facing, luminance(beta)))
        add3(tile.albedo, pixel, mul(beta, _albedo(scratch, rows.kind[row], CLASS_SHARP)))
    matte = _is_matte(surfaces, paths, i, weights)
    if paths.unguided[i] and (matte or weights[0] + weights[1] == 0.0):
        own = _albedo(scratch, rows.kind[row], CLASS_ROUGH) if matte else radiance
        _guide(pixel, beta, facing, own, tile)
    return weights


@kernel
def _end(rules, points, m, surfaces, paths, i, frame, beta):
    """Write visible point m: path i ends at its hit, with the throughput beta."""
    _, _, ng, wo = frame
    points.hit[m] = i
    store3(points.wo, m, wo)
    store3(points.beta, m, beta)
    points.key[m] = paths.key[i]
    if paths.place[i] >= 0:
        _draw_evenly(points, m, rules.key, paths.place[i])
    else:
        draw(points, m)
    points.pixel[m] = paths.pixel[i]
    stretch = 2.0 / math.sqrt(max(abs(dot(wo, ng)), 0.1))
    points.footprint[m] = _width(surfaces, paths, i) * stretch
    if len(points.inside):
        points.inside[m] = paths.inside[i]
    if len(points.trail):
        points.trail[m] = paths.trail[i]


@kernel
def _draw_evenly(points, m, key, place):
    """Numbers of visible point m, spread evenly over pixels: a pixel has one point on its main path."""
    points.u[m, 0], points.u[m, 3] = even_pair(key, place, CHOICE)
    points.u[m, 1], points.u[m, 2] = even_pair(key, place, LIGHT)
    points.u[m, 4], points.u[m, 5] = even_pair(key, place, LOBE)


@kernel
def draw(points, m):
    """Numbers of visible point m, from its key."""
    key = points.key[m]
    for k in range(3):
        points.u[m, k] = uniform(key, DIRECT_DIMENSION + k)
        points.u[m, 3 + k] = uniform(key, SECOND_DIMENSION + k)


@kernel
def _width(surfaces, paths, i):
    """Radius of half a pixel's footprint across path i at its hit [m]."""
    return float(paths.width[i]) + float(paths.spread[i]) * float(surfaces.t[i])


@kernel
def _go_on(laws, surfaces, paths, i, frame, way, onward, to):
    """Write path `to` of those that go on: path i after its hit.

    frame : (p, ns, ng, wo);  way : class of the lobe, direction, index beyond over index here, throughput before
    the index, whether the hit has rough lobes (they guide the denoiser, and what a sharp one shows no more), whether
    the lobe is perfectly smooth.
    """
    p, _, ng, wo = frame
    cls, wi, eta, beta, guided, smooth = way
    # no wider than the scene: along dozens of reflections in curved glass footprints grow without end
    width = min(_width(surfaces, paths, i), laws.radius)
    spread = float(paths.spread[i])
    if cls == CLASS_SHARP:
        turn = normal_spread(surfaces.geometry, surfaces.prim[i])
        spread += (2.0 if eta == 1.0 else abs(1.0 - 1.0 / eta)) * width * turn
    onward.width[to] = width
    onward.spread[to] = min(spread, WIDEST)
    # the camera's far clipping is of what it sees straight, not of what is mirrored
    onward.t_max[to] = paths.t_max[i] - surfaces.t[i] if cls == CLASS_NULL else UNCLIPPED
    onward.key[to] = paths.key[i]
    onward.place[to] = paths.place[i]
    onward.pixel[to] = paths.pixel[i]
    onward.bare[to] = paths.bare[i] and cls == CLASS_NULL
    onward.splits[to] = paths.splits[i]
    onward.unguided[to] = paths.unguided[i] and (cls == CLASS_NULL or not guided)
    if len(paths.inside):
        inside = after_surface(laws.media, paths.inside[i], surfaces.prim[i], dot(ng, wo), dot(ng, wi))
        onward.inside[to] = inside
    if len(paths.trail):
        kind = GLOSSY | SINGULAR if smooth else GLOSSY
        reflected = dot(ng, wo) * dot(ng, wi) > 0.0
        straight = cls == CLASS_NULL
        onward.trail[to] = passed(paths.trail[i]) if straight else bounced(paths.trail[i], kind, reflected)
    store3(onward.o, to, leave(surfaces.geometry, surfaces.prim[i], p, ng, wi))
    store3(onward.d, to, wi)
    # refraction scales radiance by 1 / eta^2 [Veach 1997, 5.2]
    store3(onward.beta, to, scale(beta, 1.0 / (eta * eta)))
