"""Light sampling from a point, and what rays meet: the two sides of multiple importance sampling for direct light.

Selection depends on the point, so every density takes the point p from which the direction was (or would be) sampled.
"""

from __future__ import annotations

import math

from ..jit import inlined
from ..sampling.mis import power_heuristic
from ..sampling.warps import square_to_cone, square_to_cosine_hemisphere
from ..vec import add, dot, load3, madd, scale, sub, to_world
from .area import area_gain, area_hit, area_pdf_w, area_sample, beam_sample
from .beams import radiance_along
from .descend import after, next_met
from .mesh import mesh_sample
from .round import round_hit, round_sample
from .select import mixed_p, select_light, selection_p
from .sky_sample import map_pdf_w, map_radiance, map_sample
from .table import AREA, CAMERA, DELTA, MESH, SHADED, SHADOW, SUN, WORLD

BLACK = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)
LAMP = -2  # what stands for lamp l in the place of an emissive triangle is LAMP - l


@inlined
def sample_light(lights, p, ns, u_select, u0, u1):
    """Direct light at p from one light: (wi, distance, Le, pdf_w, is_delta, m).

    ns : unit normal on the side that is lit; only the world uses it (cosine-weighted about ns).
    distance : how far the shadow ray from p along wi must be free: inf for sun and world, 0 for a lamp that casts no
    shadows. Estimate of the reflected radiance: f |cos| Le / pdf_w, times an MIS weight unless is_delta; pdf_w [1/sr]
    holds the selection. For delta lights Le is intensity / d^2 or irradiance and pdf_w the selection alone.
    Le = black: no light (do not trace). m : the emissive triangle, or -1; where lights.tri_shaded[m], Le is white and
    the radiance at the end of the ray must be multiplied in. LAMP - l: what the nodes of lamp l give must be.
    """
    l, p_select, u_fresh = select_light(lights, p, u_select)
    if l < 0:
        return UP, 0.0, BLACK, 1.0, False, -1
    kind = lights.kind[l]
    if kind == MESH:
        wi, distance, le, pdf_w, m = mesh_sample(lights, p, u_fresh, u0, u1)
        return wi, distance, le, pdf_w * p_select, False, m
    gain = 1.0
    is_delta = lights.flags[l] & DELTA != 0
    if kind == WORLD and len(lights.sky.rows):
        wi, le, pdf_w = map_sample(lights.sky, u0, u1)
        return wi, math.inf, le, pdf_w * p_select, False, -1
    if kind == WORLD:
        local = square_to_cosine_hemisphere(u0, u1)
        wi = to_world(local, ns)
        distance = math.inf
        pdf_w = local[2] / math.pi
    elif kind == SUN:
        wi, pdf_w = sun_sample(lights, l, u0, u1)
        distance = math.inf
    elif kind == AREA and is_delta:
        wi, distance, seen = beam_sample(lights, l, p)
        gain = 1.0 if seen else 0.0
        pdf_w = 1.0
    elif kind == AREA:
        wi, distance, gain, pdf_w = area_sample(lights, l, p, u0, u1)
    else:
        wi, distance, gain, pdf_w = round_sample(lights, l, p, u0, u1)
    if gain == 0.0 or not pdf_w > 0.0:
        return wi, 0.0, BLACK, 1.0, is_delta, -1
    if not lights.flags[l] & SHADOW:
        # a ray that must get through to the lamp cannot share the work
        distance = 0.0
        is_delta = True
    le = scale(radiance_along(lights, l, scale(wi, -1.0)), gain)
    return wi, distance, le, pdf_w * p_select, is_delta, LAMP - l if lights.flags[l] & SHADED else -1


@inlined
def sun_sample(lights, l, u0, u1):
    """Direction to the sun, uniform over its disk: (wi, pdf_w), pdf_w = 1 for a delta."""
    axis = scale(load3(lights.normal, l), -1.0)
    h = lights.size[l, 0]
    if h == 0.0:
        return axis, 1.0
    return to_world(square_to_cone(u0, u1, h), axis), 1.0 / (2.0 * math.pi * h)


@inlined
def emitter_pdf_w(lights, tri, p, distance, cos_light):
    """Density [1/sr], with selection, of `sample_light` from p for a point on global triangle `tri`; 0: not an emitter.

    distance [m] from p;  cos_light : between the ray and the triangle's geometric normal, its sign does not matter.
    """
    m = lights.emitter_of_tri[tri]
    if m < 0 or cos_light == 0.0:
        return 0.0
    l = mesh_index(lights)
    if l < 0:
        return 0.0
    p_tri = mixed_p(lights.tri_tree, lights.tri_cdf, m, p)
    return selection_p(lights, l, p) * p_tri * distance * distance / (lights.tri_area[m] * abs(cos_light))


@inlined
def mesh_index(lights):
    """Index of the MESH light, or -1; it can only be last or before the world."""
    n = lights.kind.shape[0]
    for l in range(n - 1, max(n - 3, -1), -1):
        if lights.kind[l] == MESH:
            return l
    return -1


@inlined
def world_radiance(lights, d):
    """Radiance [W/m^2/sr] that a ray which leaves the scene along d meets; suns are not in it."""
    n = lights.kind.shape[0]
    if n > 0 and lights.kind[n - 1] == WORLD:
        if len(lights.sky.rows):
            return map_radiance(lights.sky, d)
        return load3(lights.radiance, n - 1)
    return BLACK


@inlined
def world_pdf_w(lights, p, ns, d):
    """Density [1/sr], with selection, of `sample_light` from p with normal ns for the world in direction d."""
    n = lights.kind.shape[0]
    cos_theta = dot(ns, d)
    if n == 0 or lights.kind[n - 1] != WORLD:
        return 0.0
    if len(lights.sky.rows):
        return selection_p(lights, n - 1, p) * map_pdf_w(lights.sky, d)
    if cos_theta <= 0.0:
        return 0.0
    return selection_p(lights, n - 1, p) * cos_theta / math.pi


@inlined
def suns_along_ray(lights, d, prev_p, bsdf_pdf_w, use_mis, camera):
    """Radiance of all suns whose disk a ray that leaves the scene along d meets; arguments as `lamps_along_ray`."""
    total = BLACK
    for l in range(min(lights.n_near, lights.kind.shape[0]), lights.kind.shape[0]):
        if lights.kind[l] != SUN or lights.flags[l] & (DELTA | SHADED) or hidden(lights, l, use_mis, camera):
            continue
        weight = sun_met(lights, l, d, prev_p, bsdf_pdf_w, use_mis)
        if weight > 0.0:
            total = madd(total, weight, radiance_along(lights, l, scale(d, -1.0)))
    return total


@inlined
def sun_met(lights, l, d, prev_p, bsdf_pdf_w, use_mis):
    """The MIS weight of a ray from prev_p along d that meets the disk of sun l; 0: it does not."""
    r = add(d, load3(lights.normal, l))
    # |d - axis|^2 = 2 (1 - cos)
    if 0.5 * dot(r, r) > lights.size[l, 0]:
        return 0.0
    return _weight(lights, l, prev_p, 1.0 / (2.0 * math.pi * lights.size[l, 0]), bsdf_pdf_w, use_mis)


@inlined
def hidden(lights, l, use_mis, camera):
    """Whether rays of this sort do not see lamp l; a lamp without shadows is left to light sampling alone."""
    return (camera and not lights.flags[l] & CAMERA) or (use_mis and not lights.flags[l] & SHADOW)


@inlined
def _weight(lights, l, prev_p, pdf_w, bsdf_pdf_w, use_mis):
    """MIS weight of a BSDF sample that met lamp l."""
    if not use_mis:
        return 1.0
    return power_heuristic(bsdf_pdf_w, pdf_w * selection_p(lights, l, prev_p))


@inlined
def lamps_along_ray(lights, o, d, t_max, prev_p, bsdf_pdf_w, use_mis, camera):
    """Radiance of all point, spot and area lamps that a ray meets before t_max; lamps stop no ray. No suns here.

    o, d : a segment of the ray (it may have passed transparent surfaces);  t_max [m] : its length, inf allowed;
    prev_p : the vertex where d was chosen: soft lamps face it, densities are those of `sample_light` from it;
    bsdf_pdf_w [1/sr] : density of d;  use_mis : 0: weight 1 (camera, mirrors), 1: power heuristic against light
    sampling;  camera : 1: the ray comes from the camera, and only lamps that it may see count.
    """
    start = dot(sub(o, prev_p), d)
    span = (start, start + t_max)
    total = BLACK
    if lights.lamp_tree.item.shape[0] == 0:
        for l in range(min(lights.n_near, lights.kind.shape[0])):
            total = add(total, _lamp_met(lights, l, prev_p, d, span, bsdf_pdf_w, use_mis, camera))
        return total
    k = next_met(lights.lamp_tree, 0, prev_p, d, span[0], span[1])
    while k >= 0:
        l = lights.lamp_tree.item[k]
        total = add(total, _lamp_met(lights, l, prev_p, d, span, bsdf_pdf_w, use_mis, camera))
        k = next_met(lights.lamp_tree, after(k), prev_p, d, span[0], span[1])
    return total


@inlined
def _lamp_met(lights, l, prev_p, d, span, bsdf_pdf_w, use_mis, camera):
    """Weighted radiance of lamp l if a ray from prev_p meets it within the span of distances; see `lamps_along_ray`.

    Lamps whose nodes must be evaluated are left to transport/lamp_nodes.py.
    """
    if lights.flags[l] & SHADED or hidden(lights, l, use_mis, camera):
        return BLACK
    weight = lamp_met(lights, l, prev_p, d, span, bsdf_pdf_w, use_mis)
    return scale(radiance_along(lights, l, scale(d, -1.0)), weight) if weight > 0.0 else BLACK


@inlined
def lamp_met(lights, l, prev_p, d, span, bsdf_pdf_w, use_mis):
    """MIS weight times gain of a ray from prev_p along d that meets lamp l within the span; 0: it does not."""
    kind = lights.kind[l]
    pdf_w = 0.0
    if kind == AREA:
        t, cos_light = area_hit(lights, l, prev_p, d)
        gain = area_gain(lights, l, cos_light)
    else:
        cos_light = 1.0
        t, gain, pdf_w = round_hit(lights, l, prev_p, d)
    if not span[0] < t < span[1] or gain == 0.0:
        return 0.0
    if kind == AREA:
        pdf_w = area_pdf_w(lights, l, prev_p, t, cos_light)
    return gain * _weight(lights, l, prev_p, pdf_w, bsdf_pdf_w, use_mis)
