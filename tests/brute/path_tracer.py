"""Paths from the eye, sorted by Heckbert's classes."""

import math

import numpy as np

from .bvh import intersect
from .compiled import compile_scene
from .film import eye_ray, filter_offset, make_view
from .jit import kernel
from .lamps import is_delta, lamps_seen, toward_lamp
from .materials import (
    ABSORBED,
    EMISSION,
    NULL,
    ROUGH,
    TRANSPARENT,
    has_rough,
    rough_f,
    scatter,
    summed_color,
)
from .maths import dot, madd, mul, row, scale, uniform, unit

CLASSES = ("Direct", "Caustic", "Diffuse", "Emission", "Environment")
DIRECT, CAUSTIC, DIFFUSE, EMITTED, ENVIRONMENT = range(5)
SAFETY_DEPTH = 4096  # null surfaces between two vertices


@kernel
def class_of(rough, sharp_since):
    """Class of a path that reaches a light after `rough` D vertices and then `sharp_since` S vertices, from the eye."""
    if rough == 0:
        return EMITTED
    if rough > 1:
        return DIFFUSE
    return CAUSTIC if sharp_since > 0 else DIRECT


@kernel
def shading_frame(sc, i, u, v, d):
    """(ng, ns, front) at a hit: normals that face the ray's origin."""
    ng = row(sc.ng, i)
    w = 1.0 - u - v
    ns = unit((
        w * sc.ns[i, 0, 0] + u * sc.ns[i, 1, 0] + v * sc.ns[i, 2, 0],
        w * sc.ns[i, 0, 1] + u * sc.ns[i, 1, 1] + v * sc.ns[i, 2, 1],
        w * sc.ns[i, 0, 2] + u * sc.ns[i, 1, 2] + v * sc.ns[i, 2, 2],
    ))
    front = dot(ng, d) < 0.0
    if not front:
        ng, ns = scale(ng, -1.0), scale(ns, -1.0)
    # a smooth normal that turns away from the ray at a silhouette has no meaning
    if dot(ns, d) >= 0.0:
        ns = ng
    return ng, ns, front


@kernel
def place(sc, i, u, v):
    """(material, texture u, v) at barycentric (u, v) of triangle i."""
    w = 1.0 - u - v
    s = w * sc.uv[i, 0, 0] + u * sc.uv[i, 1, 0] + v * sc.uv[i, 2, 0]
    t = w * sc.uv[i, 0, 1] + u * sc.uv[i, 1, 1] + v * sc.uv[i, 2, 1]
    return sc.material[i], s, t


@kernel
def transmittance(sc, p, wi, distance, skip, stack):
    """What passes along a shadow ray: 0 behind a surface, the colour of see-through ones."""
    out = (1.0, 1.0, 1.0)
    for _ in range(SAFETY_DEPTH):
        # a light's own surface must not hide it
        i, t, u, v = intersect(sc.tree, p, wi, distance * (1.0 - 1e-9), skip, stack)
        if i < 0:
            return out
        if not sc.null:
            return (0.0, 0.0, 0.0)
        out = mul(out, summed_color(sc, place(sc, i, u, v), TRANSPARENT))
        if max(out) == 0.0:
            return out
        p, distance, skip = madd(p, t, wi), distance - t, i
    return (0.0, 0.0, 0.0)


@kernel
def glow_point(sc, p, state):
    """A shadow ray to the emissive meshes: (wi, distance, radiance / density by solid angle)."""
    e = min(np.searchsorted(sc.glow_cdf, uniform(state), side="right"), len(sc.glow) - 1)
    i = sc.glow[e]
    s, b = math.sqrt(uniform(state)), uniform(state)
    on = madd(madd(row(sc.tree.v0, i), s * (1.0 - b), row(sc.tree.e1, i)), s * b, row(sc.tree.e2, i))
    to = madd(on, -1.0, p)
    d2 = dot(to, to)
    wi = unit(to)
    le = summed_color(sc, (sc.material[i], 0.0, 0.0), EMISSION)
    return wi, math.sqrt(d2), scale(le, abs(dot(wi, row(sc.ng, i))) / (d2 * sc.glow_pdf[e]))


@kernel
def direct_light(sc, at, p, wo, ng, ns, skip, only_delta, stack, state):
    """Radiance that one shadow ray to each lamp, and one to the emissive meshes, finds."""
    out = (0.0, 0.0, 0.0)
    lights = len(sc.lamp_kind)
    for light in range(lights + (1 if len(sc.glow) else 0)):
        if light < lights:
            if only_delta and not is_delta(sc.lamp_kind, sc.lamps, light):
                continue
            wi, distance, le = toward_lamp(sc, light, p, state)
        elif only_delta:
            continue
        else:
            wi, distance, le = glow_point(sc, p, state)
        f = scale(mul(rough_f(sc, at, wo, wi, ng, ns), le), abs(dot(wi, ns)))
        if max(f) > 0.0:
            out = madd(out, 1.0, mul(f, transmittance(sc, p, wi, distance, skip, stack)))
    return out


@kernel
def add_to(out, c, value):
    """Add a colour to class c of a sample."""
    for k in range(3):
        out[c, k] += value[k]


@kernel
def trace_path(sc, o, d, t_max, shadow_rays, start, max_bounces, state, stack, out):
    """Add one eye path's light to out (5, 3).

    shadow_rays: light after a rough vertex is sampled, else met by chance (delta lamps always sampled).
    start: which paths count by their first vertex after the eye: 0 all, 1 rough ones, 2 sharp ones.
    """
    beta, radiance_scale = (1.0, 1.0, 1.0), 1.0
    rough, sharp, depth, skip = 0, 0, 0, -1
    for _ in range(SAFETY_DEPTH):
        i, t, u, v = intersect(sc.tree, o, d, t_max, skip, stack)
        first = depth == 0 and start == 2
        # shadow rays have already brought what lies straight behind a rough vertex
        counted = not first and not (shadow_rays and rough > 0 and sharp == 0)
        where = class_of(rough, sharp)
        if counted:
            add_to(out, where, mul(beta, lamps_seen(sc, o, d, t if i >= 0 else np.inf, depth == 0)))
        if i < 0:
            if not first:
                world = (sc.world[0], sc.world[1], sc.world[2])
                add_to(out, ENVIRONMENT if rough == 0 else where, mul(beta, world))
            return
        at = place(sc, i, u, v)
        if counted:
            add_to(out, where, mul(beta, summed_color(sc, at, EMISSION)))
        ng, ns, front = shading_frame(sc, i, u, v, d)
        wo = scale(d, -1.0)
        o, skip = madd(o, t, d), i
        if has_rough(sc, at) and depth < max_bounces and not first:
            light = direct_light(sc, at, o, wo, ng, ns, i, not shadow_rays, stack, state)
            add_to(out, DIRECT if rough == 0 else DIFFUSE, mul(beta, light))
        event, d, weight, eta = scatter(sc, at, wo, ng, ns, front, state)
        beta = scale(mul(beta, weight), 1.0 / (eta * eta))
        if event == NULL:
            t_max -= t
            continue
        unwanted = event == ABSORBED or (depth == 0 and start == (2 if event == ROUGH else 1))
        depth += 1
        if depth > max_bounces or unwanted:
            return
        if event == ROUGH:
            rough, sharp = rough + 1, 0
        else:
            sharp += 1
        t_max = np.inf
        radiance_scale *= eta * eta
        if depth > 3:
            beta = roulette(beta, radiance_scale, state)
            if max(beta) == 0.0:
                return


@kernel
def roulette(beta, radiance_scale, state):
    """Throughput of a path that survives with the probability of its throughput, refraction left out; else 0."""
    q = min(1.0, max(beta) * radiance_scale)
    return scale(beta, 1.0 / q) if uniform(state) < q else (0.0, 0.0, 0.0)


@kernel
def trace_rows(sc, view, rows, spp, seed, options, total, squares):
    """Add spp samples of each pixel in rows [rows[0], rows[1]) to the sums (h, w, 5, 3) of values and squares."""
    shadow_rays, start, max_bounces = options
    stack, state, sample = np.empty(256, np.int32), np.zeros(1, np.uint64), np.zeros((5, 3))
    x0, y0, x1, _y1 = view.border
    for y in range(rows[0], rows[1]):
        # streams of different rows and seeds start far apart, at multiples of odd numbers
        state[0] = np.uint64(seed) * np.uint64(0xD1342543DE82EF95) + np.uint64(y + 1) * np.uint64(0xA0761D6478BD642F)
        for x in range(x1 - x0):
            for _ in range(spp):
                sample[:] = 0.0
                px = x0 + x + 0.5 + filter_offset(view, uniform(state))
                py = y0 + y + 0.5 + filter_offset(view, uniform(state))
                o, d, t_max = eye_ray(view, px, py)
                trace_path(sc, o, d, t_max, shadow_rays, start, max_bounces, state, stack, sample)
                total[y, x] += sample
                squares[y, x] += sample * sample


def mean_and_error(total, squares, n):
    """{class: (mean, standard error)} with arrays (h, w, 3) f64 from the sums of n samples (h, w, 5, 3)."""
    mean = total / n
    error = np.sqrt(np.maximum(squares / n - mean * mean, 0.0) / max(n - 1, 1))
    return {name: (mean[:, :, k], error[:, :, k]) for k, name in enumerate(CLASSES)}


START = {"all": 0, "not sharp": 1, "sharp": 2}


def render(scene, spp, seed=0, max_bounces=1024, shadow_rays=True, start="all", compiled=None):
    """{class: (mean, standard error)} of a scene, arrays (h, w, 3), bottom row first [W/m^2/sr].

    shadow_rays : sample lights behind rough vertices (same mean, less noise); False meets them by chance.
    start : "sharp" keeps only paths whose first vertex after the eye is sharp, "not sharp" the others.
    compiled : `compile_scene(scene)` when it is at hand.
    Filtering by sampling offsets from the filter, so pixels are independent. Exposure is not applied.
    """
    sc, view = compiled or compile_scene(scene), make_view(scene)
    x0, y0, x1, y1 = view.border
    total, squares = np.zeros((2, y1 - y0, x1 - x0, len(CLASSES), 3))
    trace_rows(sc, view, (0, y1 - y0), spp, seed, (shadow_rays, START[start], max_bounces), total, squares)
    return mean_and_error(total, squares, spp)
