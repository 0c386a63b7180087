"""Subsurface scattering: batches of random walks through single bodies, carried on between Embree and the kernels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..bsdf.layout import DIFFUSE, HAS_NORMAL, N_FIELDS, LobeRows
from ..geometry.intersect import Hits
from ..photons.batch import Photons, head
from .deep_kernels import bent_rows, draw_all, eyes_below, landings_below, photons_below, photons_out
from .eye_batch import EyePaths, VisiblePoints
from .photon_kernels import ABSORBED, Leg, Surfaces
from .render_scene import RenderScene
from .walk_kernels import MOST_LEGS, Walkers, advance, aim, empty_walkers

f32 = np.float32
WIDE = f32(1e30)  # footprint where a gather's leg ends: the whole radius may be used


def walk(scene: RenderScene, walkers: Walkers) -> tuple[np.ndarray, int]:
    """Carry all walks to their ends; out: indices (k,) i64 of those that came out, in order, and rays traced."""
    geometry = scene.flat.geometry
    instance = geometry.instance[walkers.prim]
    index = np.argsort(instance, kind="stable").astype(np.int32)  # one body after the other
    rays = 0
    for bounce in range(MOST_LEGS):
        m = len(index)
        if m == 0:
            break
        o, d, t_max = np.empty((m, 3), f32), np.empty((m, 3), f32), np.empty(m, f32)
        aim(geometry, walkers, index, bounce, o, d, t_max)
        hits = scene.materials.rays.within(instance[index], o, d, t_max)
        index = index[: advance(walkers, index, bounce, hits.prim, hits.u, hits.v, hits.t)]
        rays += m
    return np.flatnonzero(walkers.prim >= 0), rays


def seen_below(scene: RenderScene, surfaces: Surfaces, paths: EyePaths, bounce: int) -> tuple[np.ndarray, np.ndarray]:
    """Where eye paths go below the surfaces they hit: footprints (k,) f32 of pixels, and points (k, 3) f64 [m]."""
    n = len(paths.key)
    walkers, footprint = empty_walkers(n), np.empty(n, f32)
    count = eyes_below(scene.laws, scene.rules, surfaces, paths, bounce, walkers, footprint)
    return footprint[:count], walkers.p[:count]


def light_below(
    scene: RenderScene, surfaces: Surfaces, paths: EyePaths, bounce: int,
    light: Callable[[Surfaces, VisiblePoints], int],
) -> int:  # fmt: skip
    """Light where eye paths come out that went below the surfaces they hit; out: rays traced."""
    n = len(paths.key)
    walkers, footprint = empty_walkers(n), np.empty(n, f32)
    count = eyes_below(scene.laws, scene.rules, surfaces, paths, bounce, walkers, footprint)
    return _light_where_out(scene, head(walkers, count), footprint, paths, light) if count else 0


def light_below_landings(
    scene: RenderScene, surfaces: Surfaces, paths, bounce: int, light: Callable[[Surfaces, VisiblePoints], int]
) -> int:
    """Light where the legs of a final gather (SecondPaths) come out that went below where they landed."""
    n = len(paths.key)
    walkers = empty_walkers(n)
    count = landings_below(scene.laws, surfaces, paths, bounce, walkers)
    return _light_where_out(scene, head(walkers, count), np.full(count, WIDE), paths, light) if count else 0


def _light_where_out(scene: RenderScene, walkers: Walkers, footprint: np.ndarray, paths, light) -> int:
    """Walk, and hand the exits to `light` as visible points of white Lambert surfaces; out: rays traced."""
    out, rays = walk(scene, walkers)
    if len(out) == 0:
        return rays
    lane = walkers.lane[out]
    points = VisiblePoints(
        np.arange(len(out), dtype=np.int32), walkers.d[out].astype(f32), walkers.beta[out].astype(f32),
        walkers.key[out], np.empty((len(out), 6)), paths.pixel[lane], footprint[out],
        *(field[lane] if len(field) else field for field in (paths.inside, paths.trail)),
    )  # fmt: skip
    draw_all(points)
    return rays + light(_exits(scene, walkers, out), points)


def _exits(scene: RenderScene, walkers: Walkers, out: np.ndarray) -> Surfaces:
    """Where walks came out, white, about the normals that bumps give."""
    prim, u, v = walkers.prim[out], walkers.u[out], walkers.v[out]
    n = len(out)
    bent = scene.materials.bends_deep
    white = LobeRows(
        np.full((n if bent else 1, 1), DIFFUSE, np.int32), np.zeros((n if bent else 1, 1, N_FIELDS), f32)
    )
    white.params[:, 0, :3] = 1.0
    row = np.arange(n, dtype=np.int32) if bent else np.zeros(n, np.int32)
    t = np.zeros(n, f32)
    if bent:
        seen = scene.surfaces_at(Hits(prim, u, v, t), -walkers.d[out].astype(f32))
        if seen.rows.params[:, :, HAS_NORMAL].any():
            bent_rows(seen.rows, seen.row, white)
    return Surfaces(scene.flat.geometry, white, row, prim, u, v, t, np.empty((1, 8)))


def carry_below(
    scene: RenderScene, leg: Leg, surfaces: Surfaces, photons: Photons, out: Photons, alive: int, tally: np.ndarray
) -> tuple[int, int]:
    """Carry the photons below the surface that `photon_step` listed; out: how many of `out` are alive, rays traced."""
    walkers = empty_walkers(int(leg.deep[0]))
    walkers = head(walkers, photons_below(surfaces, leg, photons, walkers))
    index, rays = walk(scene, walkers)
    if len(index) == 0:
        return alive, rays
    hits = Hits(walkers.prim[index], walkers.u[index], walkers.v[index], np.zeros(len(index), f32))
    there = scene.surfaces_at(hits, -walkers.d[index].astype(f32), is_photon=True)
    alive, flux = photons_out(scene.laws, there, index, walkers, photons, out, alive)
    tally[ABSORBED] -= flux
    return alive, rays
