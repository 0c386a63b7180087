"""Brute-force estimates with which the samplers are compared."""

import math

import numpy as np

from ...jit import kernel
from ...sampling.mis import power_heuristic
from ...sampling.warps import square_to_cosine_hemisphere, square_to_disk
from ...vec import add, cross, dot, load3, madd, scale, store3, sub, to_world
from ..area import area_hit, area_pdf_w
from ..emit import dark_distance, emit_photon
from ..round import round_hit
from ..sample import emitter_pdf_w, lamps_along_ray, sample_light, suns_along_ray, world_pdf_w, world_radiance
from ..table import AREA, MESH, SUN, WORLD
from ..targets import emit_aimed

LIGHTS_ONLY, RAYS_ONLY, BOTH = range(3)


@kernel
def meet_triangle(lights, m, o, d):
    """Distance to emissive triangle m along a ray, and the cosine there; inf: missed [Moeller, Trumbore 1997]."""
    e1 = load3(lights.tri_e1, m)
    e2 = load3(lights.tri_e2, m)
    q = cross(d, e2)
    det = dot(e1, q)
    if det == 0.0:
        return math.inf, 0.0
    s = sub(o, load3(lights.tri_v0, m))
    u = dot(s, q) / det
    r = cross(s, e1)
    v = dot(d, r) / det
    t = dot(e2, r) / det
    if u < 0.0 or v < 0.0 or u + v > 1.0 or t <= 0.0:
        return math.inf, 0.0
    n = cross(e1, e2)
    return t, dot(n, d) / math.sqrt(dot(n, n))


@kernel
def met(lights, tris, p, ns, d, pdf_w, mis):
    """Radiance met along d from p, weighted against light sampling when mis = 1. Triangles do not hide each other."""
    total = lamps_along_ray(lights, p, d, math.inf, p, pdf_w, mis, 0)
    total = add(total, suns_along_ray(lights, d, p, pdf_w, mis, 0))
    w = power_heuristic(pdf_w, world_pdf_w(lights, p, ns, d)) if mis else 1.0
    total = madd(total, w, world_radiance(lights, d))
    for m in range(lights.tri_area.shape[0]):
        t, cos_light = meet_triangle(lights, m, p, d)
        if t < math.inf:
            w = power_heuristic(pdf_w, emitter_pdf_w(lights, tris[m], p, t, cos_light)) if mis else 1.0
            total = madd(total, w, load3(lights.tri_radiance, m))
    return total


@kernel
def irradiance(lights, tris, p, ns, numbers, how, out):
    """Estimates of the irradiance at p, one a row -> out (n, 3); numbers (n, 5)."""
    for i in range(numbers.shape[0]):
        total = (0.0, 0.0, 0.0)
        if how != RAYS_ONLY:
            wi, _, le, pdf_w, is_delta, _ = sample_light(lights, p, ns, numbers[i, 0], numbers[i, 1], numbers[i, 2])
            cosine = dot(wi, ns)
            if cosine > 0.0:
                w = power_heuristic(pdf_w, cosine / math.pi) if how == BOTH and not is_delta else 1.0
                total = scale(le, w * cosine / pdf_w)
        if how != LIGHTS_ONLY:
            local = square_to_cosine_hemisphere(numbers[i, 3], numbers[i, 4])
            le = met(lights, tris, p, ns, to_world(local, ns), local[2] / math.pi, 1 if how == BOTH else 0)
            total = madd(total, math.pi, le)
        store3(out, i, total)


@kernel
def irradiance_on_disk(lights, center, normal, radius, numbers, out):
    """Irradiance at points spread over a disk by light sampling -> out (n, 3); numbers (n, 5)."""
    for i in range(numbers.shape[0]):
        x, y = square_to_disk(numbers[i, 3], numbers[i, 4])
        p = add(center, to_world((radius * x, radius * y, 0.0), normal))
        wi, _, le, pdf_w, _, _ = sample_light(lights, p, normal, numbers[i, 0], numbers[i, 1], numbers[i, 2])
        store3(out, i, scale(le, max(0.0, dot(wi, normal)) / pdf_w))


@kernel
def flux_on_disk(lights, l, center, normal, radius, numbers, out):
    """Flux of whole-light photons on the front of a disk -> out (n, 3); numbers (n, 4)."""
    for i in range(numbers.shape[0]):
        o, d, phi, _ = emit_photon(lights, l, numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3])
        cosine = -dot(d, normal)
        t = dot(sub(o, center), normal) / cosine if cosine > 0.0 else -1.0
        off = sub(madd(o, t, d), center)
        if t > 0.0 and t >= dark_distance(lights, l, o, d) and dot(off, off) <= radius * radius:
            store3(out, i, phi)
        else:
            store3(out, i, (0.0, 0.0, 0.0))


@kernel
def region(targets, o, d):
    """Which targets a photon's ray passes, as bits."""
    bits = 0
    for c in range(targets.radius.shape[0]):
        r = sub(load3(targets.center, c), o)
        along = dot(r, d)
        across = madd(r, -along, d)
        r2 = targets.radius[c] * targets.radius[c]
        if dot(across, across) <= r2 and (along > 0.0 or dot(r, r) < r2):
            bits |= 1 << c
    return bits


@kernel
def flux_by_region(lights, targets, l, numbers, aimed, sums, squares):
    """Flux by the set of targets that photons pass -> sums, squares (2^C,); numbers (n, 5)."""
    for i in range(numbers.shape[0]):
        u0, u1, u2, u3 = numbers[i, 0], numbers[i, 1], numbers[i, 2], numbers[i, 3]
        if aimed:
            o, d, phi, _ = emit_aimed(lights, targets, l, numbers[i, 4], u0, u1, u2, u3)
        else:
            o, d, phi, _ = emit_photon(lights, l, u0, u1, u2, u3)
        bits = region(targets, o, d)
        sums[bits] += phi[0]
        squares[bits] += phi[0] * phi[0]


@kernel
def direction_pdf(lights, tris, p, ns, d):
    """Density of `sample_light` for a direction along which light 0 is seen, as rays are weighted; 0: unseen."""
    kind = lights.kind[0]
    if kind == MESH:
        total = 0.0
        for m in range(lights.tri_area.shape[0]):
            t, cos_light = meet_triangle(lights, m, p, d)
            if t < math.inf:
                total += emitter_pdf_w(lights, tris[m], p, t, cos_light)
        return total
    if kind == WORLD:
        return world_pdf_w(lights, p, ns, d)
    if met(lights, tris, p, ns, d, 1.0, 0)[0] == 0.0:
        return 0.0
    if kind == SUN:
        return 1.0 / (2.0 * math.pi * lights.size[0, 0])
    if kind == AREA:
        t, cos_light = area_hit(lights, 0, p, d)
        return area_pdf_w(lights, 0, p, t, cos_light)
    return round_hit(lights, 0, p, d)[2]


@kernel
def sampled_directions(lights, p, ns, numbers, d, pdf_w):
    """Directions of `sample_light` -> d (n, 3), and their densities, 0 without light -> pdf_w (n,); numbers (n, 3)."""
    for i in range(numbers.shape[0]):
        wi, _, le, pdf, _, _ = sample_light(lights, p, ns, numbers[i, 0], numbers[i, 1], numbers[i, 2])
        store3(d, i, wi)
        pdf_w[i] = pdf if le[0] > 0.0 else 0.0


@kernel
def density_from_above(lights, tris, p, ns, x, y, out):
    """Density of upward directions (x, y, z) per area of (x, y) -> out."""
    for i in range(len(x)):
        for j in range(len(y)):
            z2 = 1.0 - x[i] * x[i] - y[j] * y[j]
            if z2 > 1e-12:
                z = math.sqrt(z2)
                out[i, j] = direction_pdf(lights, tris, p, ns, (x[i], y[j], z)) / z


def uniform(n, dimensions, seed=11):
    return np.random.default_rng(seed).random((n, dimensions))


def mean_and_error(samples):
    """Mean and its standard error, by column."""
    return samples.mean(0), samples.std(0, ddof=1) / math.sqrt(len(samples))


def assert_same(a, b, sigmas=4.5, floor=0.0):
    """Two (mean, error) agree within their noise; 4.5 sigmas: one false alarm in 150 000 comparisons."""
    difference = np.abs(np.asarray(a[0]) - b[0])
    noise = np.hypot(a[1], b[1])
    assert np.all(difference <= sigmas * noise + floor), f"{a[0]} +- {a[1]} and {b[0]} +- {b[1]}"


def emitter_ids(emitters):
    return np.asarray(emitters.tri, np.int32)
