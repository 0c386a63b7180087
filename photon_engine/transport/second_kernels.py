"""Rays from visible points: the lobes' half of direct light, and the legs of a final gather."""

from __future__ import annotations

import math

import numpy as np

from ..bsdf.layout import CLASS_NULL, CLASS_ROUGH
from ..bsdf.surface import emission, prepare, sample
from ..geometry.surface import leave, surface_point
from ..jit import kernel
from ..lights.sample import emitter_pdf_w, lamps_along_ray, suns_along_ray, world_pdf_w, world_radiance
from ..sampling.mis import power_heuristic
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, path_key, uniform
from ..shading.trail import GLOSSY, SINGULAR, bounced, passed
from ..vec import add, dot, length, load3, max3, mul, scale, store3, sub
from .eye_batch import SECOND_DIMENSION
from .eye_kernels import add3, draw, kept
from .lobes import has_narrow
from .media import after_surface
from .photon_kernels import choose_class

GENERATION = 3 << 20  # keys of lit landings, apart from those of a pixel's further paths and of lobe rays


@kernel
def _met_lights(lights, paths, i, t, samples):
    """Lamps before t, and the world when t is infinite, with their MIS weights."""
    o, d = load3(paths.o, i), load3(paths.d, i)
    pdf_w = float(paths.pdf_w[i]) / samples
    origin = load3(paths.origin, i)
    light = lamps_along_ray(lights, o, d, t, origin, pdf_w, 1, 0)
    if t < math.inf:
        return light
    light = add(light, suns_along_ray(lights, d, origin, pdf_w, 1, 0))
    world = world_radiance(lights, d)
    w = power_heuristic(pdf_w, world_pdf_w(lights, origin, load3(paths.normal, i), d))
    return (light[0] + w * world[0], light[1] + w * world[1], light[2] + w * world[2])


@kernel
def _direct_light(laws, lights, surfaces, paths, i, samples, direct):
    """Add what a path that met nothing sharp yet sees at the end of this leg: lamps, sky, an emitting surface.

    The hit's row, if there is one, is prepared.
    """
    prim = surfaces.prim[i]
    beta = load3(paths.beta, i)
    t = float(surfaces.t[i]) if prim >= 0 else math.inf
    add3(direct, paths.pixel[i], mul(beta, _met_lights(lights, paths, i, t, samples)))
    if prim < 0:
        return
    le = emission(surfaces.rows, surfaces.row[i], surfaces.scratch)
    if max3(le) <= 0.0:
        return
    p, ng, _ = surface_point(surfaces.geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
    origin = load3(paths.origin, i)
    pdf_w = emitter_pdf_w(lights, prim, origin, length(sub(p, origin)), dot(load3(paths.d, i), ng))
    w = power_heuristic(float(paths.pdf_w[i]) / samples, pdf_w)
    add3(direct, paths.pixel[i], scale(mul(beta, le), w))


@kernel
def second_step(laws, lights, surfaces, paths, bounce, samples, landings, direct):
    """Carry secondary rays through their hits; out: how many go on (compacted), how many landed on a rough lobe.

    Light that a ray meets before anything sharp is direct light; what it meets behind a sharp surface is in the
    caustic map and not added. Landings are VisiblePoints whose beta is the throughput of the final gather.
    samples : light samples taken at the visible point, for the MIS weight.
    """
    rows, scratch = surfaces.rows, surfaces.scratch
    alive = 0
    landed = 0
    for i in range(len(paths.key)):
        prim = surfaces.prim[i]
        row = surfaces.row[i]
        weights = (0.0, 0.0, 0.0)
        p, ng, ns, wo = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), scale(load3(paths.d, i), -1.0)
        if prim >= 0:
            p, ng, ns = surface_point(surfaces.geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
            weights = prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
        if paths.bare[i]:
            _direct_light(laws, lights, surfaces, paths, i, samples, direct)
        if max3(load3(paths.gather, i)) <= 0.0:  # only straight passes matter to direct light
            weights = (weights[0], 0.0, 0.0)
        if weights[0] + weights[1] + weights[2] <= 0.0:
            continue
        key = paths.key[i]
        dim = SECOND_DIMENSION + (bounce + 1) * DIMENSIONS_PER_BOUNCE
        cls, p_class, u0 = choose_class(weights[0], weights[1], weights[2], uniform(key, dim))
        if cls == CLASS_ROUGH:
            _land(landings, landed, paths, i, wo, p_class)
            landed += 1
            continue
        u = (u0, uniform(key, dim + 1), uniform(key, dim + 2))
        ok, wi, weight, pdf_w, eta = sample(rows, row, ns, ng, wo, cls, scratch, u, 0, laws.threshold)
        if ok and _pass_on(paths, alive, i, scale(weight, 1.0 / (p_class * eta * eta)), cls == CLASS_NULL):
            if len(paths.inside):
                paths.inside[alive] = after_surface(laws.media, paths.inside[i], prim, dot(ng, wo), dot(ng, wi))
            if len(paths.trail):
                kind = GLOSSY | SINGULAR if pdf_w == 0.0 else GLOSSY
                reflected = dot(ng, wo) * dot(ng, wi) > 0.0
                straight = cls == CLASS_NULL
                paths.trail[alive] = passed(paths.trail[i]) if straight else bounced(paths.trail[i], kind, reflected)
            store3(paths.o, alive, leave(surfaces.geometry, prim, p, ng, wi))
            store3(paths.d, alive, wi)
            alive += 1
    return alive, landed


@kernel
def narrow_points(surfaces, landings, generation, points):
    """Landings on narrow lobes, to be lit as visible points of theirs; out: how many.

    A narrow lobe would weigh the few photons it looks at by up to 1 / (pi alpha^2). Those that carry little go on by
    Russian roulette. generation : 1, 2, ...: each has random numbers of its own.
    """
    count = 0
    for m in range(len(landings.hit)):
        i = landings.hit[m]
        if not has_narrow(surfaces.rows, surfaces.row[i]):
            continue
        key = path_key(landings.key[m], GENERATION + generation)
        beta = load3(landings.beta, m)
        s = kept(max3(beta), key, 0)
        if s <= 0.0:
            continue
        points.hit[count] = i
        store3(points.wo, count, load3(landings.wo, m))
        store3(points.beta, count, scale(beta, s))
        points.key[count] = key
        draw(points, count)
        points.pixel[count] = landings.pixel[m]
        points.footprint[count] = landings.footprint[m]
        if len(landings.inside):
            points.inside[count] = landings.inside[m]
        if len(landings.trail):
            points.trail[count] = landings.trail[m]
        count += 1
    return count


@kernel
def _land(landings, m, paths, i, wo, p_class):
    """Write landing m: path i ends on a rough lobe, where the whole radius may be used."""
    landings.hit[m] = i
    store3(landings.wo, m, wo)
    store3(landings.beta, m, scale(load3(paths.gather, i), 1.0 / p_class))
    landings.key[m] = paths.key[i]
    landings.pixel[m] = paths.pixel[i]
    landings.footprint[m] = np.float32(1e30)
    if len(landings.inside):
        landings.inside[m] = paths.inside[i]
    if len(landings.trail):
        landings.trail[m] = paths.trail[i]


@kernel
def _pass_on(paths, to, i, weight, straight):
    """Move path i to place `to` <= i with its throughputs scaled; out: whether anything is left of it."""
    beta, gather = mul(load3(paths.beta, i), weight), mul(load3(paths.gather, i), weight)
    if max3(gather) <= 0.0 and max3(beta) <= 0.0:
        return False
    store3(paths.beta, to, beta)
    store3(paths.gather, to, gather)
    paths.pdf_w[to] = paths.pdf_w[i]
    store3(paths.origin, to, load3(paths.origin, i))
    store3(paths.normal, to, load3(paths.normal, i))
    paths.key[to] = paths.key[i]
    paths.pixel[to] = paths.pixel[i]
    paths.bare[to] = paths.bare[i] and straight
    return True
