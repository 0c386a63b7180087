"""Radiance by density estimation: photons near a point, weighted by what its lobes reflect of them."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..bsdf.frame import shading_ratio
from ..bsdf.surface import eval_rough, prepare
from ..geometry.surface import surface_point
from ..jit import kernel
from ..photons.map import cell_index, row_hash
from ..photons.packing import unpack_direction
from ..vec import dot, load3
from .eye_kernels import add3
from .lobes import keep_wide

SAME_SURFACE = 0.5  # cosine between normals beyond which a photon lies on another face


class Radius(NamedTuple):
    """How far to look for photons in this pass."""

    pixels: float  # times the footprint of a pixel
    bound: float  # at most [m]


@kernel
def gather(laws, surfaces, points, photons, radius, lobes, picture):
    """Add reflected radiance at visible points to the picture (n, 3).

        L(p, wo) = sum_j f(p, wo, wi_j) phi_j K(d_j / r) / (pi r^2),  K(x) = 2 (1 - x^2)
        [Jensen 2001, 7.2, with Epanechnikov's kernel]

    No cosine: a photon's flux per area holds it. A photon falls on its facet while f is relative to the shading
    normal, hence |ns.wi| / |ng.wi|, ng being the photon's own facet [Veach 1997, 5.3]. Biased by O(r^2).
    lobes : 0 all rough ones, 1 the wide ones only.
    """
    rows = surfaces.rows
    scratch = surfaces.scratch
    for m in range(len(points.hit)):
        i = points.hit[m]
        r = min(radius.pixels * float(points.footprint[m]), radius.bound)
        if r <= 0.0:
            continue
        p, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = load3(points.wo, m)
        row = surfaces.row[i]
        prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
        if lobes == 1 and not keep_wide(rows, row, scratch):
            continue
        total = estimate(rows, row, (p, ns, ng, wo), scratch, photons, r)
        beta = load3(points.beta, m)
        add3(picture, points.pixel[m], (beta[0] * total[0], beta[1] * total[1], beta[2] * total[2]))


@kernel
def estimate(rows, row, frame, scratch, photons, r):
    """Radiance from photons within r of a prepared surface point (p, ns, ng, wo)."""
    p, ns, ng, wo = frame
    cell = photons.cell
    mask = len(photons.start) - 2
    x0, x1 = cell_index(p[0] - r, cell), cell_index(p[0] + r, cell)
    red, green, blue = 0.0, 0.0, 0.0
    r2 = r * r
    for iz in range(cell_index(p[2] - r, cell), cell_index(p[2] + r, cell) + 1):
        for iy in range(cell_index(p[1] - r, cell), cell_index(p[1] + r, cell) + 1):
            row_start = row_hash(iy, iz)
            for ix in range(x0, x1 + 1):
                b = (row_start + ix) & mask
                for j in range(photons.start[b], photons.start[b + 1]):
                    q = load3(photons.position, j)
                    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
                    d2 = dx * dx + dy * dy + dz * dz
                    if d2 >= r2:
                        continue
                    if cell_index(q[0], cell) != ix or cell_index(q[1], cell) != iy or cell_index(q[2], cell) != iz:
                        continue  # another cell with the same hash
                    facet = unpack_direction(photons.normal[j])
                    if abs(dot(facet, ng)) < SAME_SURFACE:
                        continue
                    wi = unpack_direction(photons.wi[j])
                    f, _ = eval_rough(rows, row, ns, ng, wo, wi, scratch)
                    w = 2.0 * (1.0 - d2 / r2) * shading_ratio(dot(ns, wi), dot(facet, wi))
                    red += w * f[0] * photons.flux[j, 0]
                    green += w * f[1] * photons.flux[j, 1]
                    blue += w * f[2] * photons.flux[j, 2]
    s = 1.0 / (math.pi * r2)
    return (red * s, green * s, blue * s)
