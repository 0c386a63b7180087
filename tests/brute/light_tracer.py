"""Paths from the lights, each rough vertex joined to a pinhole: unbiased, and finds caustics of any light."""

import math

import numpy as np

from .bvh import intersect
from .compiled import compile_scene
from .film import filter_value, make_view, project
from .jit import kernel
from .lamps import emit, first_hit_kept, from_disk
from .materials import ABSORBED, EMISSION, NULL, ROUGH, SHARP, has_rough, rough_f, scatter, summed_color
from .maths import cone_direction, cosine_direction, dot, madd, mul, row, scale, uniform
from .path_tracer import (
    CAUSTIC,
    CLASSES,
    DIFFUSE,
    DIRECT,
    SAFETY_DEPTH,
    mean_and_error,
    place,
    shading_frame,
    transmittance,
)


@kernel
def emit_glow(sc, state):
    """A photon of the emissive meshes as if they were the only light: (o, d, flux, triangle)."""
    e = min(np.searchsorted(sc.glow_cdf, uniform(state), side="right"), len(sc.glow) - 1)
    i = sc.glow[e]
    s, b = math.sqrt(uniform(state)), uniform(state)
    o = madd(madd(row(sc.tree.v0, i), s * (1.0 - b), row(sc.tree.e1, i)), s * b, row(sc.tree.e2, i))
    n = row(sc.ng, i) if uniform(state) < 0.5 else scale(row(sc.ng, i), -1.0)
    flux = 2.0 * math.pi / sc.glow_pdf[e]
    return o, cosine_direction(n, state), scale(summed_color(sc, (sc.material[i], 0.0, 0.0), EMISSION), flux), i


@kernel
def emit_any(sc, state):
    """A photon of all light together: (o, d, flux [W], triangle it left or -1, lamp or -1)."""
    light = min(np.searchsorted(sc.light_cdf, uniform(state), side="right"), len(sc.light_p) - 1)
    lamps, share = len(sc.lamp_kind), 1.0 / sc.light_p[light]
    if light < lamps:
        o, d, phi = emit(sc, light, state)
        return o, d, scale(phi, share), -1, light
    if light == lamps:
        o, d, phi, i = emit_glow(sc, state)
        return o, d, scale(phi, share), i, -1
    d = cone_direction((0.0, 0.0, 1.0), -1.0, state)
    flux = 4.0 * math.pi * math.pi * sc.world_radius**2 * share
    return from_disk(sc, d, state), d, (sc.world[0] * flux, sc.world[1] * flux, sc.world[2] * flux), -1, -1


@kernel
def splat(view, px, py, value, out):
    """Add a point's light to all pixels whose filter covers it; out: (h, w, 3)."""
    x0, y0, x1, y1 = view.border
    reach = 0.5 * view.filter_width
    for y in range(max(y0, math.ceil(py - 0.5 - reach)), min(y1, math.floor(py - 0.5 + reach) + 1)):
        wy = filter_value(view, py - y - 0.5)
        for x in range(max(x0, math.ceil(px - 0.5 - reach)), min(x1, math.floor(px - 0.5 + reach) + 1)):
            w = wy * filter_value(view, px - x - 0.5)
            for k in range(3):
                out[y - y0, x - x0, k] += w * value[k]


@kernel
def join_eye(sc, view, at, p, w_light, ng, ns, i, phi, stack, out):
    """Splat what a photon of flux phi that came from w_light brings to the eye; ng, ns face w_light.

    L = f phi |ns.w_light| / |ng.w_light| per area of the true surface; the film sees |ng.wo| of it per film area.
    """
    seen, px, py, wo, distance, density = project(view, p)
    if not seen:
        return
    # f with the eye's direction as the one that normals face, as the path tracer has it
    side = 1.0 if dot(wo, ng) > 0.0 else -1.0
    f = rough_f(sc, at, wo, w_light, scale(ng, side), scale(ns, side))
    value = scale(mul(f, phi), density * abs(dot(ng, wo)) * abs(dot(ns, w_light)) / abs(dot(ng, w_light)))
    if max(value) > 0.0:
        splat(view, px, py, mul(value, transmittance(sc, p, wo, distance, i, stack)), out)


@kernel
def trace_photon(sc, view, max_bounces, state, stack, out):
    """Add one photon's light to out (5, h, w, 3)."""
    o, d, phi, skip, lamp = emit_any(sc, state)
    rough, sharp, depth = 0, 0, 0
    largest = max(phi)
    if largest == 0.0:
        return
    for _ in range(SAFETY_DEPTH):
        i, t, u, v = intersect(sc.tree, o, d, np.inf, skip, stack)
        if i < 0:
            return
        o, skip = madd(o, t, d), i
        if depth == 0 and lamp >= 0 and not first_hit_kept(sc, lamp, o, d):
            return
        at = place(sc, i, u, v)
        ng, ns, front = shading_frame(sc, i, u, v, d)
        wo = scale(d, -1.0)
        if has_rough(sc, at) and depth < max_bounces:
            where = DIFFUSE if rough > 0 else (CAUSTIC if sharp > 0 else DIRECT)
            join_eye(sc, view, at, o, wo, ng, ns, i, phi, stack, out[where])
        event, wi, weight, _eta = scatter(sc, at, wo, ng, ns, front, state)
        if event == ABSORBED:
            return
        phi = mul(phi, weight)
        if event != NULL:
            # flux falls on the true surface, f integrates about the shading normal [Veach 1997, section 5.3]
            phi = scale(phi, abs(dot(ns, wo) * dot(ng, wi) / (dot(ng, wo) * dot(ns, wi))))
            depth += 1
            rough, sharp = rough + (event == ROUGH), sharp + (event == SHARP)
            q = min(1.0, max(phi) / largest) if depth > 3 else 1.0
            if depth >= max_bounces or q == 0.0 or uniform(state) >= q:
                return
            phi = scale(phi, 1.0 / q)
        d = wi


@kernel
def trace_batch(sc, view, photons, seed, max_bounces, out):
    """Add the mean over a batch of photons to out (5, h, w, 3)."""
    stack, state = np.empty(256, np.int32), np.zeros(1, np.uint64)
    state[0] = np.uint64(seed) * np.uint64(0xE7037ED1A0B428DB) + np.uint64(0x8EBC6AF09C88C6E3)
    for _ in range(photons):
        trace_photon(sc, view, max_bounces, state, stack, out)
    out /= photons


def trace_light(scene, photons, seed=0, max_bounces=1024, batches=16, compiled=None):
    """{class: (mean, standard error)} of light on rough surfaces that the eye sees directly, arrays (h, w, 3).

    What is seen in mirrors or through glass is missing: `render(start="sharp")` has it. The error is that of the
    mean over `batches`; neighbouring pixels share photons where their filters overlap.
    """
    sc, view = compiled or compile_scene(scene), make_view(scene)
    x0, y0, x1, y1 = view.border
    total, squares = np.zeros((2, y1 - y0, x1 - x0, len(CLASSES), 3))
    for batch in range(batches):
        out = np.zeros((len(CLASSES), y1 - y0, x1 - x0, 3))
        trace_batch(sc, view, photons // batches, seed * batches + batch, max_bounces, out)
        out = np.moveaxis(out, 0, 2)
        total += out
        squares += out * out
    return mean_and_error(total, squares, batches)
