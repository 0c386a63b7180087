"""Emissive surfaces: which triangles radiate how much, and the exact radiance at a point that was sampled on one."""

from __future__ import annotations

import numpy as np

from ..bsdf.layout import EMISSION, NONE
from ..bsdf.surface import emission, prepare
from ..geometry.flatten import Flattened
from ..geometry.intersect import Hits
from ..geometry.surface import surface_point
from ..jit import kernel
from ..lights.table import Emitters
from ..vec import load3, mul, store3
from .materials import MaterialTable
from .photon_kernels import Surfaces

MOST_AT_ONCE = 1 << 16
# where the radiance of a triangle is looked up for its mean: the middles of sixteen equal parts
UP = [(i, j, 1 / 3) for i in range(4) for j in range(4 - i)]
DOWN = [(i, j, 2 / 3) for i in range(3) for j in range(3 - i)]
GRID = [((i + third) / 4, (j + third) / 4) for i, j, third in (*UP, *DOWN)]
LEAST = 0.02  # of the material's brightest triangle: one that is dark at all of these points may still glow between


def find_emitters(flat: Flattened, table: MaterialTable) -> Emitters:
    """Triangles whose material radiates, with their mean radiance."""
    geometry = flat.geometry
    tri = np.zeros(0, np.int32)
    if len(geometry.material):
        tri = np.flatnonzero(table.emits[geometry.material]).astype(np.int32)
    radiance, shaded = np.zeros((len(tri), 3), np.float32), np.zeros(len(tri), bool)
    material = geometry.material[tri]
    for m in np.unique(material):
        index = np.flatnonzero(material == m)
        if m in table.varying:
            shaded[index] = True
            parts = np.array_split(index, -(-len(index) // MOST_AT_ONCE))
            radiance[index] = np.concatenate([mean_radiance(flat, table, m, tri[part]) for part in parts])
            if (brightest := radiance[index].max(axis=0)).any():
                radiance[index] = np.maximum(radiance[index], LEAST * brightest)
        else:
            kind = table.fixed.kind[m : m + 1]
            shaded[index] = not np.isin(kind, (EMISSION, NONE)).all()
            radiance[index] = emission_of(kind, table.fixed.params[m : m + 1])
    lit = (radiance != 0.0).any(axis=1)
    tri, radiance, shaded = tri[lit], radiance[lit], shaded[lit]
    corner = geometry.positions[geometry.triangles[tri]]
    return Emitters(tri, corner[:, 0], corner[:, 1], corner[:, 2], radiance, shaded, outward(flat, tri))


def mean_radiance(flat: Flattened, table: MaterialTable, m: int, tri: np.ndarray) -> np.ndarray:
    """Radiance (n, 3) of triangles of a varying material: mean over GRID, seen along the normal."""
    geometry = flat.geometry
    corner = geometry.positions[geometry.triangles[tri]].astype(np.float64)
    ng = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    ng /= np.maximum(np.linalg.norm(ng, axis=1, keepdims=True), 1e-300)
    total = np.zeros((len(tri), 3))
    ones = np.ones(len(tri), np.float32)
    for u, v in GRID:
        rows = table.rows_at(m, Hits(tri, ones * np.float32(u), ones * np.float32(v), ones), ng.astype(np.float32))
        total += emission_of(rows.kind, rows.params)
    return (total / len(GRID)).astype(np.float32)


def emission_of(kind: np.ndarray, params: np.ndarray) -> np.ndarray:
    """Radiance (n, 3) of rows of lobes without regard to layers above."""
    return (params[:, :, :3] * (kind == EMISSION)[:, :, None]).sum(axis=1)


def outward(flat: Flattened, tri: np.ndarray) -> np.ndarray:
    """(M,) f32: 1 where a triangle's normal points out of a closed instance, -1 where into it, 0 of open ones."""
    geometry = flat.geometry
    out = np.zeros(len(tri), np.float32)
    owner = geometry.instance[tri]
    for i in np.unique(owner):
        triangles = geometry.triangles[flat.first_triangle[i] : flat.first_triangle[i + 1]]
        out[owner == i] = closed_side(geometry.positions, triangles)
    return out


def closed_side(positions: np.ndarray, triangles: np.ndarray) -> float:
    """1 (-1) where triangles (n, 3) bound a volume and their normals point out of (into) it; 0: they bound none.

    Closed: every edge is run through once in each direction. positions (V, 3).
    """
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    size = int(triangles.max()) + 1
    there, back = np.sort(edges[:, 0] * size + edges[:, 1]), np.sort(edges[:, 1] * size + edges[:, 0])
    if (there[1:] == there[:-1]).any() or not np.array_equal(there, back):
        return 0.0
    first = int(triangles.min())
    p = positions[first:size].astype(np.float64)
    a, b, c = (p[triangles[:, k] - first] - p.mean(axis=0) for k in range(3))
    return float(np.sign((a * np.cross(b, c)).sum()))


def multiply_radiance(scene, tri: np.ndarray, place: np.ndarray, wo: np.ndarray, values: np.ndarray) -> None:
    """Multiply values (n, 3) by the radiance of triangles (n,) at place (n, 2) toward wo (n, 3); triangle -1: leave.

    Light sampling knows only each triangle's mean; this makes a sample of a textured or coated emitter exact.
    """
    if not scene.shaded_emitters:
        return
    index = np.flatnonzero(tri >= 0)
    if len(index) == 0:
        return
    uv = np.ascontiguousarray(place[index].T)
    hits = Hits(tri[index], uv[0], uv[1], np.ones(len(index), np.float32))
    d = np.ascontiguousarray(-wo[index], np.float32)
    surfaces = scene.surfaces_at(hits, d)
    scaled = values[index]
    radiance_times(surfaces, d, scene.laws.threshold, scaled)
    values[index] = scaled


@kernel
def radiance_times(surfaces: Surfaces, d, threshold, values):
    """Multiply values (n, 3) by what each surface emits against d (n, 3)."""
    rows, scratch = surfaces.rows, surfaces.scratch
    for i in range(len(surfaces.prim)):
        _, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        wo = (-float(d[i, 0]), -float(d[i, 1]), -float(d[i, 2]))
        prepare(rows, surfaces.row[i], ns, ng, wo, threshold, scratch)
        store3(values, i, mul(load3(values, i), emission(rows, surfaces.row[i], scratch)))
