"""Rays from visible points: the lobes' half of direct light, and the legs of a final gather."""

from __future__ import annotations

import math

import numpy as np

from ..bsdf.layout import CLASS_NULL, CLASS_ROUGH
from ..bsdf.surface import emission, prepare, sample
from ..geometry.surface import offset_origin, surface_point
from ..jit import kernel
from ..lights.sample import emitter_pdf_w, lamps_along_ray, suns_along_ray, world_pdf_w, world_radiance
from ..sampling.mis import power_heuristic
from ..sampling.rng import DIMENSIONS_PER_BOUNCE, uniform
from ..vec import add, dot, length, load3, max3, scale, store3, sub
from .direct_kernels import SECOND_DIMENSION
from .eye_kernels import add3
from .photon_kernels import choose_class


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
def second_step(laws, lights, surfaces, paths, bounce, samples, landings, direct):
    """Carry secondary rays through their hits; out: how many go on (compacted), how many landed on a rough lobe.

    Light that a ray meets before anything sharp is direct light; what it meets behind a sharp surface is in the
    caustic map and not added. Landings are VisiblePoints whose beta is the throughput of the final gather.
    samples : light samples taken at the visible point, for the MIS weight.
    """
    geometry, rows = surfaces.geometry, surfaces.rows
    scratch = surfaces.scratch
    alive = 0
    landed = 0
    for i in range(len(paths.key)):
        prim = surfaces.prim[i]
        t = float(surfaces.t[i]) if prim >= 0 else math.inf
        beta = load3(paths.beta, i)
        pixel = paths.pixel[i]
        bare = paths.bare[i]
        if bare:
            light = _met_lights(lights, paths, i, t, samples)
            add3(direct, pixel, (beta[0] * light[0], beta[1] * light[1], beta[2] * light[2]))
        if prim < 0:
            continue
        p, ng, ns = surface_point(geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
        wo = scale(load3(paths.d, i), -1.0)
        row = surfaces.row[i]
        p_null, p_sharp, p_rough = prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
        if bare:
            le = emission(rows, row, scratch)
            if max3(le) > 0.0:
                origin = load3(paths.origin, i)
                pdf_w = emitter_pdf_w(lights, prim, origin, length(sub(p, origin)), dot(wo, ng))
                w = power_heuristic(float(paths.pdf_w[i]) / samples, pdf_w)
                add3(direct, pixel, (beta[0] * le[0] * w, beta[1] * le[1] * w, beta[2] * le[2] * w))
        gather = load3(paths.gather, i)
        if max3(gather) <= 0.0:  # only straight passes matter to direct light
            p_sharp, p_rough = 0.0, 0.0
        if p_null + p_sharp + p_rough <= 0.0:
            continue
        key = paths.key[i]
        dim = SECOND_DIMENSION + (bounce + 1) * DIMENSIONS_PER_BOUNCE
        cls, p_class, u0 = choose_class(p_null, p_sharp, p_rough, uniform(key, dim))
        if cls == CLASS_ROUGH:
            landings.hit[landed] = i
            store3(landings.wo, landed, wo)
            store3(landings.beta, landed, scale(gather, 1.0 / p_class))
            landings.key[landed] = key
            landings.pixel[landed] = pixel
            landings.footprint[landed] = np.float32(1e30)
            landed += 1
            continue
        u = (u0, uniform(key, dim + 1), uniform(key, dim + 2))
        ok, wi, weight, _, eta = sample(rows, row, ns, ng, wo, cls, scratch, u, 0, laws.threshold)
        if not ok:
            continue
        s = 1.0 / (p_class * eta * eta)
        beta = (beta[0] * weight[0] * s, beta[1] * weight[1] * s, beta[2] * weight[2] * s)
        gather = (gather[0] * weight[0] * s, gather[1] * weight[1] * s, gather[2] * weight[2] * s)
        if max3(gather) <= 0.0 and max3(beta) <= 0.0:
            continue
        store3(paths.o, alive, offset_origin(p, ng, wi, laws.reach))
        store3(paths.d, alive, wi)
        store3(paths.beta, alive, beta)
        store3(paths.gather, alive, gather)
        paths.pdf_w[alive] = paths.pdf_w[i]
        store3(paths.origin, alive, load3(paths.origin, i))
        store3(paths.normal, alive, load3(paths.normal, i))
        paths.key[alive] = key
        paths.pixel[alive] = pixel
        paths.bare[alive] = bare and cls == CLASS_NULL
        alive += 1
    return alive, landed
