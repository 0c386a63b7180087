"""Nodes that send rays from the points they shade: Ambient Occlusion, Bevel and Raycast.

Their random numbers are a hash of the point: every pass shades other points of a pixel, the same whatever the thread.
"""

from __future__ import annotations

import numpy as np

from ..registry import f32, node
from ..trail import DIFFUSE_DEPTH, MOST
from .coordinates import columns

# steps of the two-dimensional golden ratio [Roberts 2018], which spreads the samples of a point evenly
STEPS = np.array([0.7548776662466927, 0.5698402909980532])
PRIMES = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
PICK = np.array([0.5, 0.25, 0.25])  # how often a bevel's ray goes along the normal and the axes across it
MOST_CROSSINGS = 4  # of a bevel's ray, as Cycles keeps
NEWTON = 10


def point_numbers(p: np.ndarray) -> np.ndarray:
    """Two random numbers (n, 2) f64 in [0, 1) of each point (n, 3) f32: a hash of its bits."""
    bits = np.ascontiguousarray(p, f32).view(np.uint32).astype(np.uint64)
    with np.errstate(over="ignore"):
        x = (bits * PRIMES).sum(axis=1, dtype=np.uint64)
        out = []
        for _ in range(2):
            x = x + np.uint64(0x9E3779B97F4A7C15)
            z = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            out.append((z ^ (z >> np.uint64(31))) >> np.uint64(11))
    return np.stack(out, axis=1) * 2.0**-53


def axes(n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across unit normals (n, 3), those that Cycles takes."""
    x, y, z = n.T
    even = (x == y) & (x == z)
    t = np.stack([z - y, np.where(even, x + z, x - z), np.where(even, -y - x, y - x)], axis=1)
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    return t, np.cross(n, t)


def disk(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points uniform in the unit disk from numbers (n, 2)."""
    r, phi = np.sqrt(numbers[:, 0]), 2.0 * np.pi * numbers[:, 1]
    return r * np.cos(phi), r * np.sin(phi)


def rows(vector, points, otherwise):
    """A vector input as rows (n, 3) f64 of length 1, or what stands in for it."""
    if vector is None:
        return np.asarray(otherwise, np.float64)
    value = np.broadcast_to(vector.T, points.p.shape).astype(np.float64)
    size = np.linalg.norm(value, axis=1, keepdims=True)
    return value / np.where(size > 0.0, size, 1.0)


@node("ShaderNodeAmbientOcclusion", varies=True, needs={"rays", "corners"})
def ambient_occlusion(x, props, points):
    """The share of directions, weighed by the cosine, in which nothing is near."""
    samples = int(props.get("samples", 16))
    color = x["Color"]
    if points is None or points.rays is None or samples < 1:
        return {"AO": np.ones(1, f32), "Color": color}
    n = rows(x.get("Normal"), points, points.facing(points.ns))
    n = -n if props.get("inside") else n
    s, t = axes(n)
    near = np.asarray(x["Distance"], f32)
    if len(near) == 1 and near[0] == 0.0:  # an unlinked 0 stands for the world's distance
        near = np.full(1, props.get("world_distance", 0.0), f32)
    near = np.broadcast_to(near, (len(points),))
    own, start = bool(props.get("only_local")), point_numbers(points.p)
    free = np.zeros(len(points))
    for k in range(samples):
        a, b = disk((start + k * STEPS) % 1.0)
        height = np.sqrt(np.maximum(1.0 - a * a - b * b, 0.0))
        free += points.rays.free(points, a[:, None] * s + b[:, None] * t + height[:, None] * n, near, own)
    ao = np.where(near > 0.0, free / samples, 1.0).astype(f32)
    return {"AO": ao, "Color": color * ao}


def cubic(radius, r):
    """Weight of a distance r: (R - r)^3, its integral over the disk 1."""
    return np.where(r < radius, 10.0 * np.maximum(radius - r, 0.0) ** 3 / (np.pi * radius**5), 0.0)


def cubic_radius(u):
    """The share of the radius within which `cubic` has the weight u: 10 x^2 - 20 x^3 + 15 x^4 - 4 x^5 = u."""
    x = np.full_like(u, 0.25)
    for _ in range(NEWTON):
        value = ((15.0 - 4.0 * x) * x - 20.0) * x**3 + 10.0 * x * x - u
        slope = 20.0 * x * (1.0 - x) ** 3
        x = np.clip(x - np.where(slope > 0.0, value / np.where(slope > 0.0, slope, 1.0), 0.0), 0.0, 1.0)
    return x


@node("ShaderNodeBevel", varies=True, needs={"rays", "trail", "corners"})
def bevel(x, props, points):
    """A normal averaged over the object's surface within a radius; blurred paths see the surface's own, as ever."""
    samples = int(props.get("samples", 4))
    own = points.facing(points.ns).astype(np.float64)
    normal = own
    if points.rays is not None and samples > 0:
        radius = np.broadcast_to(np.asarray(x["Radius"], np.float64), (len(points),))
        wanted = (radius > 0.0) & ~blurred(points)
        index = np.flatnonzero(wanted)
        if len(index):
            normal = own.copy()
            normal[index] = averaged(points.take(index), radius[index], samples, own[index])
    if x.get("Normal") is not None:
        normal = np.broadcast_to(x["Normal"].T, own.shape) + (normal - own)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    return {"Normal": columns(normal.astype(f32))}


def blurred(points) -> np.ndarray:
    """Points (n,) bool that a diffuse bounce led to, photons' among them."""
    trail = points.trail
    if points.is_photon:
        return np.ones(len(points), bool)
    return np.zeros(len(points), bool) if trail is None or not len(trail) else (trail >> DIFFUSE_DEPTH) & MOST > 0


def averaged(points, radius, samples: int, own: np.ndarray) -> np.ndarray:
    """Normals (n, 3): mean over the surface near the points, found by rays along three axes [King et al. 2013]."""
    ng = points.facing(points.ng).astype(np.float64)
    frame = np.stack([ng, *axes(ng)], axis=1)  # (n, 3 axes, 3)
    total = np.zeros(ng.shape)
    start = point_numbers(points.p)
    every = np.arange(len(ng))
    for k in range(samples):
        numbers = (start + k * STEPS) % 1.0
        axis = np.where(numbers[:, 0] < 0.5, 0, np.where(numbers[:, 0] < 0.75, 1, 2))
        share = np.where(axis == 0, 2.0 * numbers[:, 0], 4.0 * (numbers[:, 0] - 0.25 * (axis + 1)))
        order = np.array([[0, 1, 2], [1, 0, 2], [2, 1, 0]])[axis]
        along, s, t = (frame[every, order[:, j]] for j in range(3))
        reach = cubic_radius(numbers[:, 1])
        height = np.sqrt(np.maximum(1.0 - reach * reach, 0.0)) * radius
        phi = 2.0 * np.pi * share
        offset = (np.cos(phi)[:, None] * s + np.sin(phi)[:, None] * t) * (reach * radius)[:, None]
        o = points.p + along * height[:, None] + offset
        for index, p, hit_ng, hit_ns in points.rays.crossings(points, o, -along, 2.0 * height, MOST_CROSSINGS):
            pdf = PICK * np.abs(np.einsum("nij,nj->ni", frame[index], hit_ng.astype(np.float64)))
            chosen = pdf[np.arange(len(index)), axis[index]]
            weight = chosen / np.maximum((pdf * pdf).sum(axis=1), 1e-30)
            far = np.linalg.norm(p - points.p[index], axis=1)
            weight *= cubic(radius[index], far) / np.maximum(cubic(radius[index], reach[index] * radius[index]), 1e-30)
            np.add.at(total, index, weight[:, None] * hit_ns)
    size = np.linalg.norm(total, axis=1, keepdims=True)
    side = np.where(points.backfacing, -1.0, 1.0)[:, None]
    return np.where(size > 0.0, side * total / np.where(size > 0.0, size, 1.0), own)


@node("ShaderNodeRaycast", varies=True, needs={"rays", "corners"})
def raycast(x, props, points):
    """What a ray meets first: from the point along its normal unless linked."""
    n = len(points)
    length = np.broadcast_to(np.asarray(x["Length"], f32), (n,))
    place, way = x.get("Position"), x.get("Direction")
    d = points.facing(points.ns) if way is None else np.broadcast_to(way.T, points.p.shape)
    o = None if place is None else (np.broadcast_to(place.T, points.p.shape) - points.origin).astype(f32)
    hit, t, mine, normal = np.zeros(n, bool), length, np.zeros(n, bool), np.zeros((n, 3), f32)
    index = np.flatnonzero((length > 0.0) & (np.abs(d).max(axis=1) > 0.0))
    if points.rays is not None and len(index):
        hit, t, mine, normal = hit.copy(), length.copy(), mine.copy(), normal.copy()
        start = None if o is None else o[index]
        found = points.rays.nearest(points.take(index), start, d[index], length[index], bool(props.get("only_local")))
        hit[index], mine[index], normal[index] = found[0], found[2], found[3]
        t[index] = np.where(found[0], found[1], length[index])
    where = np.where(hit[:, None], (points.p if o is None else o) + t[:, None] * d + points.origin, 0.0)
    return {
        "Is Hit": hit.astype(f32), "Self Hit": mine.astype(f32), "Hit Distance": t.astype(f32),
        "Hit Position": columns(where.astype(f32)), "Hit Normal": columns(normal),
    }  # fmt: skip
