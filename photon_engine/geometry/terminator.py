"""Where a shadow ray starts on a coarse smooth mesh: lifted off the facet toward the curved surface it stands for.

A smooth-shaded facet near the shadow's edge turns to the light by its shading normal while its own plane, or the facet
before it, hides the light: a dark stair of facets. Blender's objects have Shading > Shadow Terminator > Geometry Offset
against it (0.1 unless changed), and Cycles follows it: the shadow ray starts on a parabola through the corners that
leans as their normals do.
"""

from __future__ import annotations

from ..jit import kernel
from ..vec import add, dot, load3, scale, sub

NOTHING = (0.0, 0.0, 0.0)


@kernel
def lift_amount(cos_shading, cos_facet, cutoff):
    """How much of the lift a light direction gets, in [0, 1]: all below the facet's plane, none well above it.

    cos_shading >= 0 : light to shading normal;  cos_facet : light to the facet's normal on that side;  cutoff > 0 : the
    object's Geometry Offset.
    """
    amount = 1.0 - cos_facet / cutoff
    if cos_shading < cutoff:
        amount = 2.0 - (cos_facet + cos_shading) / cutoff
    return min(1.0, max(0.0, amount))


@kernel
def lift(geometry, prim, u, v, ng, ns, wi, cutoff):
    """Vector [m] from a point of triangle `prim` to the start of a shadow ray along wi; zero for flat triangles.

    ng, ns : geometric and shading normal on the side that is seen;  u, v : the point's place in the triangle.
    """
    row = geometry.normal_row[prim]
    if row < 0 or cutoff <= 0.0:
        return NOTHING
    cos_shading, cos_facet = dot(ns, wi), dot(ng, wi)
    if cos_shading < 0.0:  # light from behind
        cos_shading, cos_facet, ng = -cos_shading, -cos_facet, scale(ng, -1.0)
    amount = lift_amount(cos_shading, cos_facet, cutoff)
    if amount == 0.0:
        return NOTHING
    n = geometry.normals[row]
    n0, n1, n2 = load3(n, 0), load3(n, 1), load3(n, 2)
    normal = add(add(scale(n0, 1.0 - u - v), scale(n1, u)), scale(n2, v))
    side = 1.0 if dot(normal, ng) > 0.0 else -1.0
    v0 = load3(geometry.positions, geometry.triangles[prim, 0])
    v1 = load3(geometry.positions, geometry.triangles[prim, 1])
    v2 = load3(geometry.positions, geometry.triangles[prim, 2])
    height = bulge(v0, v1, v2, scale(n0, side), scale(n1, side), scale(n2, side), u, v)
    return scale(normal, side * amount * height)


@kernel
def bulge(v0, v1, v2, n0, n1, n2, u, v):
    """Height [m] of the curved surface over a triangle's point: between half a parabola and the corners' planes."""
    w = 1.0 - u - v
    e01, e02, e12 = sub(v1, v0), sub(v2, v0), sub(v2, v1)
    parabola = w * u * dot(sub(n1, n0), e01) + w * v * dot(sub(n2, n0), e02) + u * v * dot(sub(n2, n1), e12)
    to0 = add(scale(e01, -u), scale(e02, -v))  # v0 - p
    h0 = dot(to0, n0) + max(0.0, max(dot(e01, n0), dot(e02, n0)))
    h1 = dot(add(to0, e01), n1) + max(0.0, max(-dot(e01, n1), dot(e12, n1)))
    h2 = dot(add(to0, e02), n2) + max(0.0, max(-dot(e02, n2), -dot(e12, n2)))
    return max(max(0.0, min(h0, min(h1, h2))), 0.5 * parabola)
