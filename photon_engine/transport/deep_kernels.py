"""Where eye paths and photons go below surfaces with SUBSURFACE lobes, and where photons come out."""

from __future__ import annotations

import math

from ..bsdf.deep import enter, has_deep, leave_by, medium, pick_deep, same_deep
from ..bsdf.diffuse import sample_cosine
from ..bsdf.frame import lobe_normal, negate, shading_ratio
from ..bsdf.layout import HAS_NORMAL, HOLDOUT, NORMAL
from ..bsdf.surface import prepare_any
from ..geometry.surface import leave, surface_point
from ..jit import kernel
from ..sampling.rng import path_key, uniform
from ..vec import dot, load3, max3, mul, scale, store3
from .eye_kernels import draw, kept
from .photon_rules import after_rough, roulette
from .walk_kernels import begin

WALK_KEYS = 1 << 23  # keys of walks, apart from those of forks, lobe rays, landings, and a pixel's other paths;
LANDED = 4096  # those of walks from where a gather's legs land begin so much later
PICK, WAY, WAY2, KEEP = 0, 1, 2, 3  # random numbers of the entry, which come before those of the legs
OUT, OUT2, END = 4, 5, 6  # and of a photon's way out


@kernel
def _look_below(laws, surfaces, i, wo, beta, key, walkers, count):
    """Let a path of throughput beta into hit i, as walk `count`; out: how many walks there are now."""
    rows, row, scratch = surfaces.rows, surfaces.row[i], surfaces.scratch
    _, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
    prepare_any(rows, row, ns, ng, wo, laws.threshold, scratch)
    k, share = pick_deep(rows, row, scratch, uniform(key, PICK))
    if k < 0:
        return count
    inner, entering = medium(rows, row, k)
    weight = scale((scratch[k, 0], scratch[k, 1], scratch[k, 2]), 1.0 / share)
    s = kept(max3(mul(beta, weight)), key, KEEP)
    if s <= 0.0:
        return count
    ok, d, n = enter(rows, row, k, ns, ng, wo, (uniform(key, WAY), uniform(key, WAY2)))
    if not ok:
        return count
    beta = scale(mul(beta, mul(weight, entering)), s)
    return count + 1 if begin(walkers, count, i, k, key, surfaces, n, d, beta, inner) else count


@kernel
def eyes_below(laws, rules, surfaces, paths, bounce, walkers, footprint):
    """Let eye paths go below the surfaces they hit, besides all other ways on; out: how many do.

    footprint (n,) f32 [m]: of a pixel on the surface, by walk, as VisiblePoints has it
    """
    count = 0
    for i in range(len(paths.key)):
        prim = surfaces.prim[i]
        row = surfaces.row[i]
        if prim < 0 or not has_deep(surfaces.rows, row) or surfaces.rows.kind[row, 0] == HOLDOUT:
            continue
        instance = surfaces.geometry.instance[prim]
        if paths.bare[i] and (rules.holdout[instance] or not rules.visible[instance]):
            continue
        wo = scale(load3(paths.d, i), -1.0)
        key = path_key(paths.key[i], WALK_KEYS + bounce)
        before = count
        count = _look_below(laws, surfaces, i, wo, load3(paths.beta, i), key, walkers, count)
        if count > before:
            _, ng, _ = surface_point(surfaces.geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
            across = float(paths.width[i]) + float(paths.spread[i]) * float(surfaces.t[i])
            footprint[before] = across * 2.0 / math.sqrt(max(abs(dot(wo, ng)), 0.1))
    return count


@kernel
def landings_below(laws, surfaces, paths, bounce, walkers):
    """Let the legs of a final gather go below where they land; out: how many do."""
    count = 0
    for i in range(len(paths.key)):
        if surfaces.prim[i] < 0 or not has_deep(surfaces.rows, surfaces.row[i]):
            continue
        wo, beta = scale(load3(paths.d, i), -1.0), load3(paths.gather, i)
        key = path_key(paths.key[i], WALK_KEYS + LANDED + bounce)
        count = _look_below(laws, surfaces, i, wo, beta, key, walkers, count)
    return count


@kernel
def photons_below(surfaces, leg, photons, walkers):
    """Let photons go below the surfaces they hit, those that `photon_step` listed in leg.deep; out: how many do.

    An eye path comes out as by white Lambert about the shading normal, hence the factor of its cosine.
    """
    rows, count = surfaces.rows, 0
    for m in range(leg.deep[0]):
        i = leg.deep[1 + m]
        row = surfaces.row[i]
        key = path_key(photons.key[i], WALK_KEYS + leg.bounce)
        k = leg.deep_lobe[i]
        _, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = scale(load3(photons.d, i), -1.0)
        front = dot(wo, ng) >= 0.0
        near = ng if front else negate(ng)
        n = lobe_normal(rows, row, k, ns, front)
        lit = dot(n, wo)
        if lit <= 0.0:
            continue
        inner, entering = medium(rows, row, k)
        s = shading_ratio(lit, dot(near, wo)) / leg.deep_share[i]
        phi = load3(photons.phi, i)
        if len(leg.gain):
            phi = mul(phi, load3(leg.gain, i))
        beta = scale(mul(phi, entering), s)
        d = negate(sample_cosine(near, uniform(key, WAY), uniform(key, WAY2)))
        if dot(d, near) < 0.0 and begin(walkers, count, i, k, key, surfaces, near, d, beta, inner):
            count += 1
    return count


@kernel
def photons_out(laws, surfaces, index, walkers, photons, out, alive):
    """Send photons on whose walks `index` came out at the hits `surfaces`; out: how many are alive now, their flux.

    The lobe there weighs them as an eye path would be that comes back: it may be another material's, or none.
    """
    rows, scratch = surfaces.rows, surfaces.scratch
    flux = (0.0, 0.0, 0.0)
    for m in range(len(index)):
        j = index[m]
        i, row, key = walkers.lane[j], surfaces.row[m], walkers.key[j]
        k = same_deep(rows, row, walkers.lobe[j])
        if k < 0:
            continue
        p, ng, ns = surface_point(surfaces.geometry, surfaces.prim[m], float(surfaces.u[m]), float(surfaces.v[m]))
        ok, wi, s = leave_by(rows, row, k, ns, ng, load3(walkers.d, j), (uniform(key, OUT), uniform(key, OUT2)))
        if not ok:
            continue
        prepare_any(rows, row, ns, ng, wi, laws.threshold, scratch)
        weight = (scratch[k, 0] * s, scratch[k, 1] * s, scratch[k, 2] * s)
        survives, phi = roulette(load3(photons.phi, i), mul(load3(walkers.beta, j), weight), uniform(key, END))
        if not survives:
            continue
        flux = (flux[0] + phi[0], flux[1] + phi[1], flux[2] + phi[2])
        if len(photons.inside):
            out.inside[alive] = photons.inside[i]
        store3(out.o, alive, leave(surfaces.geometry, surfaces.prim[m], p, ng, wi))
        store3(out.d, alive, wi)
        store3(out.phi, alive, phi)
        out.key[alive] = photons.key[i]
        out.dark[alive] = 0.0
        out.seen[alive] = after_rough(photons.seen[i])
        alive += 1
    return alive, flux


@kernel
def draw_all(points):
    """Numbers of all visible points, from their keys."""
    for m in range(len(points.hit)):
        draw(points, m)


@kernel
def bent_rows(rows, row, white):
    """White Lambert rows (n) about the normals of the hits' SUBSURFACE lobes, where these have their own."""
    for i in range(len(row)):
        k = same_deep(rows, row[i], 0)
        if k < 0 or rows.params[row[i], k, HAS_NORMAL] == 0.0:
            continue
        white.params[i, 0, HAS_NORMAL] = rows.params[row[i], k, HAS_NORMAL]
        for c in range(3):
            white.params[i, 0, NORMAL + c] = rows.params[row[i], k, NORMAL + c]
