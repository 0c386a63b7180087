"""Emissive triangles: a point on one of them for direct light or for a photon."""

from __future__ import annotations

import math

from ..geometry.surface import half_extent, offset_origin
from ..jit import inlined
from ..sampling.warps import square_to_triangle
from ..vec import add, cross, dot, load3, normalize, scale, sub
from .select import mixed_pick, pick

BLACK = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)


@inlined
def mesh_sample(lights, p, u, u0, u1):
    """Point on an emissive triangle, uniform in area: (wi, distance, Le, pdf_w without the selection, triangle)."""
    m, p_tri, _ = mixed_pick(lights.tri_tree, lights.tri_cdf, p, u)
    b1, b2 = square_to_triangle(u0, u1)
    e1 = load3(lights.tri_e1, m)
    e2 = load3(lights.tri_e2, m)
    r = sub(add(load3(lights.tri_v0, m), add(scale(e1, b1), scale(e2, b2))), p)
    d2 = dot(r, r)
    normal = cross(e1, e2)
    projected = abs(dot(normal, r)) * 0.5  # area times cosine times distance
    if projected == 0.0 or d2 == 0.0:
        return UP, 0.0, BLACK, 1.0, m
    distance = math.sqrt(d2)
    return scale(r, 1.0 / distance), distance, triangle_radiance(lights, m), p_tri * d2 * distance / projected, m


@inlined
def triangle_radiance(lights, m):
    """Radiance of emissive triangle m; white where it is still to be evaluated."""
    return (1.0, 1.0, 1.0) if lights.tri_shaded[m] else load3(lights.tri_radiance, m)


@inlined
def place_on(lights, m, p):
    """Coordinates (u, v) in emissive triangle m of the point of it that is nearest to p."""
    e1, e2 = load3(lights.tri_e1, m), load3(lights.tri_e2, m)
    r = sub(p, load3(lights.tri_v0, m))
    a, b, c = dot(e1, e1), dot(e1, e2), dot(e2, e2)
    det = a * c - b * b
    if det <= 0.0:
        return 1.0 / 3.0, 1.0 / 3.0
    x, y = dot(r, e1), dot(r, e2)
    u = min(max((c * x - b * y) / det, 0.0), 1.0)
    return u, min(max((a * y - b * x) / det, 0.0), 1.0 - u)


@inlined
def leave_mesh(lights, m, p, normal, w):
    """Origin of a photon that leaves the point p of emissive triangle m along w."""
    return offset_origin(p, normal, w, half_extent((0.0, 0.0, 0.0), load3(lights.tri_e1, m), load3(lights.tri_e2, m)))


@inlined
def mesh_origin(lights, u0, u1):
    """Point on the emissive triangles, by flux: (m, point, unit normal, density [1/m^2])."""
    m, p_tri, rest = pick(lights.tri_cdf, u0)
    # the leftover of u0 has lost few of its 53 bits to the choice of triangle
    b1, b2 = square_to_triangle(rest, u1)
    e1 = load3(lights.tri_e1, m)
    e2 = load3(lights.tri_e2, m)
    o = add(load3(lights.tri_v0, m), add(scale(e1, b1), scale(e2, b2)))
    return m, o, normalize(cross(e1, e2)), p_tri / lights.tri_area[m]
