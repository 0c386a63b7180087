"""Radiance by density estimation: photons near a point, weighted by what its lobes reflect of them."""

from __future__ import annotations

import math

from ..bsdf.frame import shading_ratio
from ..bsdf.layering import is_lambert
from ..bsdf.surface import eval_rough, prepare
from ..geometry.surface import surface_point
from ..jit import inlined, kernel
from ..photons.map import cell_index
from ..photons.packing import body, touches, unpack_direction, unpack_facet
from ..vec import add, dot, load3, mul, normalize, scale
from .clearing_kernels import SAME_SURFACE
from .clipping import LEAST_SHARE, beyond, free_shares, lines_near
from .eye_kernels import add3
from .lobes import keep_lobes
from .near_kernels import MOST_FOUND, flux_near, in_row, is_stacked, parts_of_row, run_of_cells, scan


@kernel
def gather(laws, surfaces, points, lookup, lobes, picture, bias):
    """Add reflected radiance at visible points to the picture (n, 3), and what its radius smears to bias (n, 3).

        L(p, wo) = sum_j f(p, wo, wi_j) phi_j K(d_j / r) / (pi r^2),  K(x) = 2 (1 - x^2)
        [Jensen 2001, 7.2, with Epanechnikov's kernel]

    No cosine: a photon's flux per area holds it. A photon falls on its facet while f is relative to the shading
    normal, hence |ns.wi| / |ng.wi|, ng being the photon's own facet [Veach 1997, 5.3]. Biased by O(r^2).

    The bias is estimated from the same photons as the difference to a kernel without second moment, of bias O(r^4):

        K_4(x) = 2 (1 - x^2) (3 - 6 x^2),  E[K - K_4] = r^2 / 12 laplace(L) + O(r^4)  [Wand and Jones 1995, 2.8]

    Its mean over passes estimates the bias of the picture's mean whatever the radii were. Where a wall or a rim cuts
    the disc, both kernels are divided by their integrals over what is left of it, and photons beyond are left out: see
    clipping. Across a straight edge the bias is then O(r) with the gradient, and its estimate 0.57 of it.
    lobes : which rough ones, lobes.ALL, WIDE or NARROW.
    """
    rows, geometry = surfaces.rows, surfaces.geometry
    scratch = surfaces.scratch
    photons, radius, clearings = lookup.photons, lookup.radius, lookup.clearings
    for m in range(len(points.hit)):
        i = points.hit[m]
        r = max(min(radius.pixels * float(points.footprint[m]), radius.bound), radius.least)
        if r <= 0.0:
            continue
        p, ng, ns = surface_point(geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = load3(points.wo, m)
        row = surfaces.row[i]
        instance = geometry.instance[surfaces.prim[i]]
        if is_lambert(rows, row) and geometry.normal_row[surfaces.prim[i]] < 0:
            lit = ng if dot(wo, ng) >= 0.0 else scale(ng, -1.0)
            own = body(dot(wo, ng) >= 0.0, instance)
            flux, smear = flux_on_plane(p, lit, own, photons, r, cut_at(clearings, m, p, ng, r), lookup.near)
            albedo = scale(load3(rows.params[row], 0), 1.0 / math.pi)
            total, smear = mul(albedo, flux), mul(albedo, smear)
        else:
            prepare(rows, row, ns, ng, wo, laws.threshold, scratch)
            if not keep_lobes(rows, row, scratch, lobes):
                continue
            cut = cut_at(clearings, m, p, ng, r)
            total, smear = estimate(rows, row, (p, ns, ng, wo), instance, scratch, photons, r, cut)
        beta = load3(points.beta, m)
        add3(picture, points.pixel[m], mul(beta, total))
        add3(bias, points.pixel[m], mul(beta, smear))


@kernel
def cut_at(clearings, m, p, n, r):
    """What cuts visible point m's disc: (lines, how many, parts of K and of K_4 that they leave)."""
    count = lines_near(clearings, m, p, r)
    if count == 0:
        return clearings.work, 0, 1.0, 1.0
    share, share4 = free_shares(clearings.work, count, n, r)
    if share < LEAST_SHARE:
        return clearings.work, 0, 1.0, 1.0
    return clearings.work, count, share, share4


@inlined
def with_bias(total, moment, r2, share, share4):
    """The estimate with K, and its difference to that with K_4; from sums of (1 - x^2) phi and x^2 (1 - x^2) phi.

    share, share4 : integrals of K and K_4 over the part of the disc that photons may fall on.
    """
    s = 2.0 / (math.pi * r2)
    estimated = scale(total, s / share)
    near, far = s / share - 3.0 * s / share4, 6.0 * s / share4
    smear = (near * total[0] + far * moment[0], near * total[1] + far * moment[1], near * total[2] + far * moment[2])
    return estimated, smear


@kernel
def flux_on_plane(p, n, own, photons, r, cut, near):
    """Flux per area (rgb) on the side n of the plane through p, and its bias: `estimate` of Lambert of albedo pi.

    own : packing.body of that side;  cut : see `cut_at`.
    """
    lines, count, share, share4 = cut
    cell = photons.cell
    x0, x1 = cell_index(p[0] - r, cell), cell_index(p[0] + r, cell)
    check = photons.clash or r > cell
    total, moment, found = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0
    for iz in range(cell_index(p[2] - r, cell), cell_index(p[2] + r, cell) + 1):
        for iy in range(cell_index(p[1] - r, cell), cell_index(p[1] + r, cell) + 1):
            for part in range(parts_of_row(photons, iy, iz, x0, x1 - x0 + 1)):
                first, last = run_of_cells(photons, iy, iz, x0, x1 - x0 + 1, part)
                while first < last:
                    end = min(last, first + MOST_FOUND - found)
                    found = scan(photons, first, end, p, r * r, (check, iy, iz, x0, x1), near, found)
                    first = end
                    if found > MOST_FOUND // 2:
                        flux, flux2 = flux_near(photons, p, n, own, r * r, (lines, count), near, found)
                        total, moment, found = add(total, flux), add(moment, flux2), 0
    flux, flux2 = flux_near(photons, p, n, own, r * r, (lines, count), near, found)
    return with_bias(add(total, flux), add(moment, flux2), r * r, share, share4)


@kernel
def estimate(rows, row, frame, instance, scratch, photons, r, cut):
    """Radiance (rgb) from photons within r of a prepared surface point (p, ns, ng, wo), and its bias."""
    p, ns, ng, wo = frame
    side = 1.0 if dot(wo, ng) >= 0.0 else -1.0
    lines, count, share, share4 = cut
    cell = photons.cell
    x0, x1 = cell_index(p[0] - r, cell), cell_index(p[0] + r, cell)
    check = photons.clash or r > cell
    red, green, blue = 0.0, 0.0, 0.0
    red2, green2, blue2 = 0.0, 0.0, 0.0
    r2 = r * r
    for iz in range(cell_index(p[2] - r, cell), cell_index(p[2] + r, cell) + 1):
        for iy in range(cell_index(p[1] - r, cell), cell_index(p[1] + r, cell) + 1):
            for part in range(parts_of_row(photons, iy, iz, x0, x1 - x0 + 1)):
                first, last = run_of_cells(photons, iy, iz, x0, x1 - x0 + 1, part)
                for j in range(first, last):
                    q = load3(photons.position, j)
                    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
                    d2 = dx * dx + dy * dy + dz * dz
                    if d2 >= r2 or (check and not in_row(q, cell, iy, iz, x0, x1)):
                        continue
                    if count and beyond(lines, count, dx, dy, dz):
                        continue
                    facet = normalize(unpack_facet(photons.normal[j]))
                    c = dot(facet, ng)
                    if abs(c) < SAME_SURFACE or touches(photons.normal[j], body(c > 0.0, instance)):
                        continue
                    if is_stacked(ng, scale(facet, math.copysign(1.0, c)), (dx, dy, dz), d2):
                        continue
                    wi = unpack_direction(photons.wi[j])
                    # from behind a wall whose normals lean beyond its horizon
                    if c * side < 0.0 and dot(ns, wi) * side >= 0.0:
                        continue
                    f, _ = eval_rough(rows, row, ns, ng, wo, wi, scratch)
                    x2 = d2 / r2
                    w = (1.0 - x2) * shading_ratio(dot(ns, wi), dot(facet, wi))
                    flux = mul(scale(f, w), load3(photons.flux, j))
                    red, green, blue = red + flux[0], green + flux[1], blue + flux[2]
                    red2, green2, blue2 = red2 + x2 * flux[0], green2 + x2 * flux[1], blue2 + x2 * flux[2]
    return with_bias((red, green, blue), (red2, green2, blue2), r2, share, share4)
