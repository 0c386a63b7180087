"""Photons of lamps that cast no shadow.

Such a lamp lights every surface that its rays cross as if no other were there: shadow rays to it are never stopped. Its
photon is therefore carried along its line through all n surfaces and kept at one of them, chosen at random, with n
times its flux. By mirrors and through glass the lamp shows only where nothing hides it, as any other: only what stands
first in a photon's way bends it, and a straight pass leads to such surfaces alone, since every rough one behind is
among the n already. Photons for caustics, whose first vertex is a mirror or glass, need nothing of this.
"""

from __future__ import annotations

import numpy as np

from ..geometry.intersect import Hits
from ..geometry.surface import leave, surface_point
from ..jit import kernel
from ..lights.table import SHADOW
from ..photons.batch import Photons
from ..sampling.rng import uniform
from ..vec import load3, store3
from .photon_rules import FIRST, THROUGH
from .render_scene import RenderScene

MOST_SURFACES = 1000  # on one line
CHOICE_DIMENSION = 0  # bounces use those from DIMENSIONS_PER_BOUNCE on


@kernel
def go_beyond(geometry, hits, d, o):
    """Origins behind the surfaces that were hit; d, o : (n, 3) f32."""
    for i in range(len(hits.prim)):
        p, ng, _ = surface_point(geometry, hits.prim[i], float(hits.u[i]), float(hits.v[i]))
        store3(o, i, leave(geometry, hits.prim[i], p, ng, load3(d, i)))


@kernel
def choice_numbers(key, out):
    """A number in [0, 1) of each path."""
    for i in range(len(key)):
        out[i] = uniform(key[i], CHOICE_DIMENSION)


def light_through(scene: RenderScene, photons: Photons, light: np.ndarray, hits: Hits) -> tuple[Hits, np.ndarray]:
    """Where new photons land, lamps without shadows shining through all surfaces.

    photons : just emitted, by lights of the numbers `light` (n,), with their first hits. Flux and `dark` of those of
    lamps without shadows are changed.
    out : the hits; the flux (3,) [W] that is there once more, on further surfaces.
    """
    free = np.flatnonzero((scene.lights.flags[light] & SHADOW == 0) & (hits.prim >= 0))
    if len(free) == 0:
        return hits, np.zeros(3)
    layers = all_hits(scene, photons.o[free], photons.d[free], Hits(*(field[free] for field in hits)))
    dark = photons.dark[free]
    count = np.zeros(len(free), np.int64)
    for index, layer in layers:
        count[index] += layer.t >= dark[index]
    numbers = np.empty(len(free))
    choice_numbers(photons.key[free], numbers)
    chosen = np.floor(numbers * count).astype(np.int64)
    out = Hits(*(field.copy() for field in hits))
    passed = np.zeros(len(free), np.int64)
    for depth, (index, layer) in enumerate(layers):
        lit = layer.t >= dark[index]
        here = lit & (passed[index] == chosen[index])
        at = free[index[here]]
        for field, value in zip(out, layer, strict=True):
            field[at] = value[here]
        photons.dark[at] = FIRST if depth == 0 else THROUGH
        passed[index] += lit
    more = np.maximum(count - 1, 0)[:, None] * photons.phi[free].astype(np.float64)
    photons.phi[free] += more.astype(np.float32)
    return out, more.sum(axis=0)


def all_hits(scene: RenderScene, o: np.ndarray, d: np.ndarray, hits: Hits) -> list[tuple[np.ndarray, Hits]]:
    """Everything that lies on the lines from o along d, nearest first: which lines (m,), and their hits, t from o."""
    index, travelled = np.arange(len(o)), np.zeros(len(o), np.float32)
    layers = []
    for _ in range(MOST_SURFACES):
        there = np.flatnonzero(hits.prim >= 0)
        if len(there) == 0:
            break
        hits = Hits(*(np.ascontiguousarray(field[there]) for field in hits))
        index, d, travelled = index[there], np.ascontiguousarray(d[there]), travelled[there] + hits.t
        layers.append((index, hits._replace(t=travelled)))
        o = np.empty_like(d)
        go_beyond(scene.flat.geometry, hits, d, o)
        hits = scene.intersector.closest(o, d)
    return layers
