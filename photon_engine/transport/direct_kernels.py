"""Direct light at visible points: shadow rays, and rays sampled from the lobes, combined by MIS."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..bsdf.layout import CLASS_ROUGH
from ..bsdf.split import straight_through
from ..bsdf.surface import eval_rough, prepare, sample
from ..geometry.surface import leave, surface_point
from ..geometry.terminator import lift
from ..jit import kernel
from ..lights.mesh import place_on
from ..lights.sample import sample_light
from ..sampling.mis import power_heuristic
from ..sampling.rng import path_key
from ..shading.trail import bounced, no_trails
from ..vec import add, dot, length, load3, max3, scale, store3, sub
from .eye_batch import LATTICE_X, LATTICE_Y
from .eye_kernels import add3
from .lobes import NARROW, keep_lobes, lobe_rays, rough_kind
from .media import after_surface, no_bits

LOBE_RAY = 1 << 21  # keys of further rays from a visible point's lobes
LATTICE_U, LATTICE_V, LATTICE_W = 0.8191725133961645, 0.6710436067037893, 0.5497004779019703  # as LATTICE_X, for three
SHORTEN = 1.0 - 2.0**-14  # a shadow ray ends before the emitter that it was aimed at


class ShadowRays(NamedTuple):
    """Light that arrives unless something is in the way."""

    o: np.ndarray  # (n, 3) f32
    d: np.ndarray  # (n, 3) f32
    t_max: np.ndarray  # (n,) f32
    light: np.ndarray  # (n, 3) f32, what it adds to the pixel
    pixel: np.ndarray  # (n,) i32
    inside: np.ndarray  # (n,) i64, bits of the absorbing media it is in; (0,) in a scene without
    # (n,) i32, triangle at its end whose radiance is still to be multiplied in; -1: none; LAMP - l: the nodes of lamp l
    emitter: np.ndarray
    place: np.ndarray  # (n, 2) f32, where on it


class SecondPaths(NamedTuple):
    """Rays from visible points, sampled from their rough lobes; kernels compact them in place."""

    o: np.ndarray  # (n, 3) f32
    d: np.ndarray  # (n, 3) f32
    beta: np.ndarray  # (n, 3) f32, throughput for direct light: all rough lobes
    gather: np.ndarray  # (n, 3) f32, throughput for the final gather: the lobes that gather
    pdf_w: np.ndarray  # (n,) f32, of the direction at the visible point, times the number of rays from there
    origin: np.ndarray  # (n, 3) f32, the visible point, for the densities of lights
    normal: np.ndarray  # (n, 3) f32, its shading normal on the side that is seen
    key: np.ndarray  # (n,) u64
    pixel: np.ndarray  # (n,) i32
    bare: np.ndarray  # (n,) bool, only straight passes so far: what it meets is direct light
    inside: np.ndarray  # (n,) i64, as in ShadowRays
    trail: np.ndarray  # (n,) i64, as in EyePaths


def empty_shadow_rays(n: int, media: bool = False) -> ShadowRays:
    """Room for n shadow rays; media: where something absorbs."""
    return ShadowRays(
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.int32),
        no_bits(n, media),
        np.empty(n, np.int32),
        np.empty((n, 2), np.float32),
    )


def empty_second_paths(n: int, media: bool = False, trails: bool = False) -> SecondPaths:
    """Room for n secondary paths; media: where something absorbs; trails: where a material asks."""
    f3 = [np.empty((n, 3), np.float32) for _ in range(4)]
    return SecondPaths(
        *f3,
        np.empty(n, np.float32),
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.uint64),
        np.empty(n, np.int32),
        np.ones(n, bool),
        no_bits(n, media),
        no_trails(n, trails),
    )


@kernel
def facing(ns, ng, wo):
    """The shading normal on the side from which the surface is seen."""
    return ns if dot(wo, ng) >= 0.0 else scale(ns, -1.0)


@kernel
def sample_lights(laws, lights, surfaces, points, first, last, samples, narrow, lobes, rays):
    """Shadow rays of light samples [first, last) of `samples` at every visible point; out: how many.

    narrow : how many rays from narrow lobes (one from others) will meet the same lights, 0: none
    lobes : which rough ones are lit, lobes.ALL or NARROW;  rays : room for last - first at every point
    """
    rows = surfaces.rows
    scratch = surfaces.scratch
    count = 0
    for m in range(len(points.hit)):
        i = points.hit[m]
        p, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = load3(points.wo, m)
        row = surfaces.row[i]
        met = -1  # rays from the lobes that meet the same lights; -1: the lobes are not prepared yet
        for j in range(first, last):
            # random numbers once for all samples: strata select lights, and a lattice spreads the places on them
            u_select = (j + points.u[m, 0]) / samples
            u0 = (points.u[m, 1] + j * LATTICE_X) % 1.0
            u1 = (points.u[m, 2] + j * LATTICE_Y) % 1.0
            light = sample_light(lights, p, facing(ns, ng, wo), u_select, u0, u1)
            wi, _, le, pdf_w, is_delta, _ = light
            if max3(le) <= 0.0:
                continue
            if met < 0:
                prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
                if not keep_lobes(rows, row, scratch, lobes):
                    break
                met = lobe_rays(rows, row, scratch, narrow) if narrow > 0 else 0
            f, lobe_pdf_w = eval_rough(rows, row, ns, ng, wo, wi, scratch)
            s = abs(dot(ns, wi)) / (pdf_w * samples)
            if met > 0 and not is_delta:
                s *= power_heuristic(pdf_w * samples, lobe_pdf_w * met)
            beta = load3(points.beta, m)
            value = (beta[0] * f[0] * le[0] * s, beta[1] * f[1] * le[1] * s, beta[2] * f[2] * le[2] * s)
            if max3(value) > 0.0:
                _cast(laws, lights, surfaces, points, m, (p, ng, ns), light, value, rays, count)
                count += 1
    return count


@kernel
def _cast(laws, lights, surfaces, points, m, point, light, value, rays, k):
    """Write shadow ray k, from visible point m along what `sample_light` told, that brings `value`.

    point : (p, ng, ns)
    """
    p, ng, _ = point
    wi, distance, _, _, _, emitter = light
    i, wo = points.hit[m], load3(points.wo, m)
    o, d, reach = _start(laws, surfaces, i, point, wo, wi, distance)
    store3(rays.o, k, o)
    store3(rays.d, k, d)
    rays.t_max[k] = min(reach * SHORTEN, 1e30)
    store3(rays.light, k, value)
    rays.pixel[k] = points.pixel[m]
    if len(rays.inside):
        prim = surfaces.prim[i]
        rays.inside[k] = after_surface(laws.media, points.inside[m], prim, dot(ng, wo), dot(ng, wi))
    _note_emitter(lights, rays, k, emitter, add(p, scale(wi, distance)))


@kernel
def _note_emitter(lights, rays, i, m, p):
    """Where shadow ray i ends on emissive triangle m, when its radiance depends on that."""
    rays.emitter[i] = min(m, -1)
    if m >= 0 and lights.tri_shaded[m]:
        rays.emitter[i] = lights.tri_id[m]
        u, v = place_on(lights, m, p)
        rays.place[i, 0], rays.place[i, 1] = u, v


@kernel
def _start(laws, surfaces, i, point, wo, wi, distance):
    """The shadow ray from hit i to light along wi: (o, d, distance), lifted at the terminator of smooth meshes.

    It starts on the side that its lobe is lit from by the shading normal: where that leans beyond the horizon of the
    facet, the facet itself hides the light, or lamps would shine through closed smooth walls.
    """
    p, ng, ns = point
    prim = surfaces.prim[i]
    cutoff = float(laws.terminator[surfaces.geometry.instance[prim]])
    side = 1.0 if dot(wo, ng) >= 0.0 else -1.0
    u, v = float(surfaces.u[i]), float(surfaces.v[i])
    up = lift(surfaces.geometry, prim, u, v, scale(ng, side), scale(ns, side), wi, cutoff)
    o = add(p, up)
    if distance < math.inf and distance > 0.0 and dot(up, up) > 0.0:
        to_light = sub(scale(wi, distance), up)
        distance = length(to_light)
        wi = scale(to_light, 1.0 / distance)
    lit = math.copysign(1.0, dot(ns, wi) * dot(ns, ng))
    return leave(surfaces.geometry, prim, o, ng, scale(ng, lit)), wi, distance


@kernel
def add_unoccluded(rays, occluded, count, picture):
    """Add the light of rays that nothing stopped; picture (n, 3)."""
    for i in range(count):
        if not occluded[i]:
            add3(picture, rays.pixel[i], load3(rays.light, i))


@kernel
def attenuate_shadows(laws, surfaces, rays, casts):
    """Carry shadow rays through see-through surfaces; blocked ones get no light. out: how many go on, compacted.

    casts : (instances,) bool, whether an instance stops light at all. Rays that reached the end must have been
    added already: those with prim < 0 here.
    """
    rows = surfaces.rows
    scratch = surfaces.scratch
    alive = 0
    for i in range(len(rays.pixel)):
        prim = surfaces.prim[i]
        if prim < 0:
            continue
        p, ng, ns = surface_point(surfaces.geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
        d = load3(rays.d, i)
        light = load3(rays.light, i)
        if casts[surfaces.geometry.instance[prim]]:
            wo = scale(d, -1.0)
            prepare(rows, surfaces.row[i], ns, ng, wo, laws.threshold, scratch)
            through = straight_through(rows.kind[surfaces.row[i]], scratch)
            light = (light[0] * through[0], light[1] * through[1], light[2] * through[2])
        if max3(light) <= 0.0:
            continue
        store3(rays.o, alive, leave(surfaces.geometry, prim, p, ng, d))
        store3(rays.d, alive, d)
        rays.t_max[alive] = rays.t_max[i] - surfaces.t[i]
        store3(rays.light, alive, light)
        rays.pixel[alive] = rays.pixel[i]
        if len(rays.inside):
            rays.inside[alive] = after_surface(laws.media, rays.inside[i], prim, -dot(ng, d), dot(ng, d))
        alive += 1
    return alive


@kernel
def sample_lobes(laws, surfaces, points, gathers, lobes, narrow, paths):
    """Rays from the rough lobes of every visible point, `lobe_rays` from each; out: how many.

    gathers : which rough lobes gather: 0 none, 1 the narrow ones, 2 all;  lobes : which count at all, ALL or NARROW.
    narrow : rays from narrow lobes, one from others;  paths : room for most_lobe_rays(narrow) for each point
    """
    rows = surfaces.rows
    scratch = surfaces.scratch
    count = 0
    for m in range(len(points.hit)):
        i = points.hit[m]
        p, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = load3(points.wo, m)
        row = surfaces.row[i]
        prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
        if not keep_lobes(rows, row, scratch, lobes):
            continue
        n = lobe_rays(rows, row, scratch, narrow)
        for j in range(n):
            if j > 0 and gathers == 1:  # the ray before has told the lobes that gather apart, in scratch
                prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
                keep_lobes(rows, row, scratch, lobes)
            count = _sample_lobe(laws, surfaces, points, m, (p, ns, ng, wo), gathers, lobes, j, n, paths, count)
    return count


@kernel
def _sample_lobe(laws, surfaces, points, m, frame, gathers, lobes, j, n, paths, count):
    """The j-th of n rays from the prepared lobes of visible point m, as path `count`; out: the next free place.

    frame : (p, ns, ng, wo). Where gathers is 1, scratch may be left with the narrow lobes alone.
    """
    p, ns, ng, wo = frame
    i = points.hit[m]
    rows, row, scratch = surfaces.rows, surfaces.row[i], surfaces.scratch
    key = points.key[m]
    # random numbers once for all rays, and a lattice that spreads the rays evenly
    u0 = (points.u[m, 3] + j * LATTICE_U) % 1.0
    u1 = (points.u[m, 4] + j * LATTICE_V) % 1.0
    u2 = (points.u[m, 5] + j * LATTICE_W) % 1.0
    ok, wi, weight, pdf_w, eta = sample(rows, row, ns, ng, wo, CLASS_ROUGH, scratch, (u0, u1, u2), 0, laws.threshold)
    if not ok or max3(weight) <= 0.0:
        return count
    s = 1.0 / (eta * eta * n)
    beta = load3(points.beta, m)
    out = (beta[0] * weight[0] * s, beta[1] * weight[1] * s, beta[2] * weight[2] * s)
    kind = rough_kind(rows.kind[row], scratch) if len(paths.trail) else 0  # while all lobes have their weights
    gather = out
    if gathers != 2 and lobes != NARROW:
        gather = (0.0, 0.0, 0.0)
        if gathers == 1 and keep_lobes(rows, row, scratch, NARROW):
            f, _ = eval_rough(rows, row, ns, ng, wo, wi, scratch)
            s = abs(dot(ns, wi)) / (pdf_w * n)
            gather = (beta[0] * f[0] * s, beta[1] * f[1] * s, beta[2] * f[2] * s)
    store3(paths.o, count, leave(surfaces.geometry, surfaces.prim[i], p, ng, wi))
    store3(paths.d, count, wi)
    store3(paths.beta, count, out)
    store3(paths.gather, count, gather)
    paths.pdf_w[count] = pdf_w * n
    store3(paths.origin, count, p)
    store3(paths.normal, count, facing(ns, ng, wo))
    paths.key[count] = key if j == 0 else path_key(key, LOBE_RAY + j)
    paths.pixel[count] = points.pixel[m]
    paths.bare[count] = True
    if len(paths.inside):
        prim = surfaces.prim[i]
        paths.inside[count] = after_surface(laws.media, points.inside[m], prim, dot(ng, wo), dot(ng, wi))
    if len(paths.trail):
        paths.trail[count] = bounced(points.trail[m], kind, dot(ng, wo) * dot(ng, wi) > 0.0)
    return count + 1
