"""The normal that a lobe scatters about."""

from __future__ import annotations

import math

from ..jit import kernel
from ..vec import dot
from .layout import HAS_NORMAL, NORMAL


@kernel
def negate(a):
    """-a."""
    return (-a[0], -a[1], -a[2])


@kernel
def lobe_normal(rows, row, k, ns, front):
    """Unit normal of a lobe: its own or ns, turned round when the back side was hit."""
    n = ns
    if rows.params[row, k, HAS_NORMAL] != 0.0:
        p = rows.params
        n = (float(p[row, k, NORMAL]), float(p[row, k, NORMAL + 1]), float(p[row, k, NORMAL + 2]))
    return n if front else negate(n)


@kernel
def raised_normal(n, ng, wo):
    """n, turned toward ng as far as it takes for the mirror image of wo to stay above the surface.

    As Blender does for glossy lobes: without it smooth or bumped meshes are black where the mirrored ray would enter.
    With n' = cos(a) ng + sin(a) x, the image's height is |(wo.x, wo.ng)| cos(2a - b): solved for a.

    n, ng : on the side of wo.
    """
    height = dot(wo, ng)
    least = min(0.9 * height, 0.01)
    d = dot(n, wo)
    n_z = dot(n, ng)
    if 2.0 * d * n_z - height >= least:
        return n
    x = (n[0] - n_z * ng[0], n[1] - n_z * ng[1], n[2] - n_z * ng[2])
    norm = math.sqrt(dot(x, x))
    if norm < 1e-12:
        return n
    x = (x[0] / norm, x[1] / norm, x[2] / norm)
    w_x = dot(wo, x)
    a = 0.5 * (math.atan2(w_x, height) + math.acos(least / math.sqrt(w_x * w_x + height * height)))
    s = math.sin(a)
    c = math.cos(a)
    return (c * ng[0] + s * x[0], c * ng[1] + s * x[1], c * ng[2] + s * x[2])


@kernel
def facet_normal(rows, row, k, ns, ng, wo, front):
    """Normal of a REFLECT, GLASS or REFRACT lobe as met from wo; ng as given (not turned)."""
    n = lobe_normal(rows, row, k, ns, front)
    return raised_normal(n, ng if front else negate(ng), wo)


# see shading_ratio
MOST_RATIO = 4.0


@kernel
def shading_ratio(cos_shading, cos_geometric):
    """|ns.w| / |ng.w|, which turns flux that falls on facets into flux on the smooth surface [Veach 1997, 5.3].

    It grows without bound where light grazes the facet, and with it the variance of whatever is multiplied by it: one
    photon in 10^5 was a hundred times the rest. Cut at MOST_RATIO = 4; normals that differ by an angle a lose at most
    a^2 / 6 of the light by it (0.02% at 2 degrees).
    """
    return min(abs(cos_shading), MOST_RATIO * abs(cos_geometric)) / max(abs(cos_geometric), 1e-30)
