"""A light tree: emitters in a balanced binary tree whose nodes bound how brightly their emitters can light a point.

Descending it from a point picks an emitter in time log n by what it may send there: power over distance squared, times
the cosine that its orientation allows at best [Conty Estevez and Kulla 2018; pbrt, 4th edition, 12.6.3].
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

INSIDE = 0.1  # how much the inner side of a closed surface counts: who looks at it from inside sees no other
TURN = 0.25  # how much of a group's diagonal a whole turn between its normals counts, when it is split


class LightTree(NamedTuple):
    """K nodes as in a heap: node k has the children 2k + 1 and 2k + 2; N emitters, each a leaf. N = 0: no nodes."""

    center: np.ndarray  # (K, 3) f64, of a sphere around the emitters [m]
    radius: np.ndarray  # (K,) f64 [m]
    axis: np.ndarray  # (K, 3) f64, unit, middle of the cone of their normals
    cone: np.ndarray  # (K, 3) f64: cosine and sine of the cone's half angle, cosine of how far off a normal they shine
    back: np.ndarray  # (K,) f64, how much the back counts: 1: both sides shine alike, 0: one-sided
    power: np.ndarray  # (K,) f64: intensity along the normal, or A Le (luminance)
    item: np.ndarray  # (K,) i32, the emitter of a leaf; -1: inner node; -2: no node
    leaf: np.ndarray  # (N,) i32, node of each emitter
    solid: np.ndarray  # (K,) bool, whether a ray can meet one of the emitters


class Bounds(NamedTuple):
    """Emitters, or nodes, as the tree combines them."""

    low: np.ndarray  # (n, 3) f64, box [m]
    high: np.ndarray  # (n, 3) f64
    axis: np.ndarray  # (n, 3) f64, unit
    spread: np.ndarray  # (n,) f64, half angle of the cone of normals [rad]; pi: any direction
    reach: np.ndarray  # (n,) f64, angle off a normal up to which light is sent [rad]
    back: np.ndarray  # (n,) f64
    power: np.ndarray  # (n,) f64
    solid: np.ndarray  # (n,) bool


def empty_bounds(n: int) -> Bounds:
    """n emitters without power at the origin that shine along z."""
    return Bounds(
        np.zeros((n, 3)), np.zeros((n, 3)), np.tile([0.0, 0.0, 1.0], (n, 1)), np.zeros(n), np.full(n, 0.5 * math.pi),
        np.zeros(n), np.zeros(n), np.ones(n, bool),
    )  # fmt: skip


def build_tree(items: Bounds) -> LightTree:
    """The tree over N emitters, of depth ceil(log2 N): a group is split at the median of its longest extent.

    Extents are those of the boxes' middles and, scaled by TURN, of the normals, so that emitters which face
    alike come together even where they lie close.
    """
    n = len(items.power)
    depth = max(n - 1, 0).bit_length()
    size = 2 ** (depth + 1) - 1 if n else 0
    count, order = np.zeros(size, np.int64), np.arange(n)
    start = np.zeros(size, np.int64)
    if n:
        count[0] = n
    points = np.concatenate([0.5 * (items.low + items.high), items.axis], 1)
    for level in range(depth):
        first, last = 2**level - 1, 2 ** (level + 1) - 1
        order = _sorted(points, order, start[first:last], count[first:last])
        split = np.flatnonzero(count[first:last] > 1) + first
        left = (count[split] + 1) // 2
        count[2 * split + 1], count[2 * split + 2] = left, count[split] - left
        start[2 * split + 1], start[2 * split + 2] = start[split], start[split] + left
    item = np.where(count == 1, order[np.minimum(start, n - 1)] if n else 0, np.where(count == 0, -2, -1))
    leaf = np.zeros(n, np.int32)
    leaf[item[item >= 0]] = np.flatnonzero(item >= 0)
    nodes = empty_bounds(size)
    for whole, part in zip(nodes, items, strict=True):
        whole[leaf] = part
    for level in range(depth - 1, -1, -1):
        first = 2**level - 1
        inner = np.flatnonzero(count[first : 2 ** (level + 1) - 1] > 1) + first
        joined = join(_rows(nodes, 2 * inner + 1), _rows(nodes, 2 * inner + 2))
        for whole, part in zip(nodes, joined, strict=True):
            whole[inner] = part
    return _packed(nodes, item.astype(np.int32), leaf)


def _packed(nodes: Bounds, item: np.ndarray, leaf: np.ndarray) -> LightTree:
    """Nodes as the kernels read them."""
    spread, reach = np.minimum(nodes.spread, math.pi), np.minimum(nodes.reach, math.pi)
    return LightTree(
        center=0.5 * (nodes.low + nodes.high),
        radius=0.5 * np.linalg.norm(nodes.high - nodes.low, axis=1),
        axis=nodes.axis,
        cone=np.stack([np.cos(spread), np.sin(spread), np.cos(reach)], 1),
        back=nodes.back,
        power=nodes.power,
        item=item,
        leaf=leaf,
        solid=nodes.solid,
    )


def _rows(nodes: Bounds, rows: np.ndarray) -> Bounds:
    """Some of the nodes."""
    return Bounds(*(field[rows] for field in nodes))


def _sorted(points: np.ndarray, order: np.ndarray, start: np.ndarray, count: np.ndarray) -> np.ndarray:
    """The order with each group [start, start + count) sorted along its own longest extent; points (n, 6)."""
    groups = np.flatnonzero(count)
    at = np.argsort(start[groups])
    groups = groups[at]
    values = points[order]
    extent = np.maximum.reduceat(values, start[groups]) - np.minimum.reduceat(values, start[groups])
    diagonal = np.linalg.norm(extent[:, :3], axis=1, keepdims=True)
    longest = np.argmax(np.concatenate([extent[:, :3], TURN * diagonal * extent[:, 3:]], 1), axis=1)
    group = np.repeat(np.arange(len(groups)), count[groups])
    key = values[np.arange(len(order)), longest[group]]
    return order[np.lexsort((key, group))]


def join(a: Bounds, b: Bounds) -> Bounds:
    """Bounds of pairs; two-sided emitters may turn round, so that their normals agree."""
    turn = (a.back == 1.0) & (b.back == 1.0) & ((a.axis * b.axis).sum(1) < 0.0)
    axis, spread = join_cones(a.axis, a.spread, np.where(turn[:, None], -b.axis, b.axis), b.spread)
    return Bounds(
        np.minimum(a.low, b.low), np.maximum(a.high, b.high), axis, spread, np.maximum(a.reach, b.reach),
        np.maximum(a.back, b.back), a.power + b.power, a.solid | b.solid,
    )  # fmt: skip


def join_cones(axis_a, spread_a, axis_b, spread_b) -> tuple[np.ndarray, np.ndarray]:
    """Smallest cones (axis (n, 3), half angle (n,)) around pairs of cones; half angle pi: all directions."""
    wider = (spread_a >= spread_b)[:, None]
    big, small = np.where(wider, axis_a, axis_b), np.where(wider, axis_b, axis_a)
    most, least = np.maximum(spread_a, spread_b), np.minimum(spread_a, spread_b)
    # the angle between unit vectors without the rounding of an arc cosine near 0
    apart = 2.0 * np.arctan2(np.linalg.norm(big - small, axis=1), np.linalg.norm(big + small, axis=1))
    inside = np.minimum(apart + least, math.pi) <= most
    half = 0.5 * (most + apart + least)
    sine = np.sin(apart)
    everything = ~inside & ((half >= math.pi) | (sine < 1e-9) & (apart > 1.0))
    turn = np.where(inside | everything | (sine < 1e-9), 0.0, half - most)
    safe = np.where(sine < 1e-9, 1.0, sine)
    axis = (np.sin(apart - turn) / safe)[:, None] * big + (np.sin(turn) / safe)[:, None] * small
    axis = np.where((turn == 0.0)[:, None], big, axis)
    spread = np.where(inside, most, np.where(everything, math.pi, half))
    return axis / np.linalg.norm(axis, axis=1, keepdims=True), spread


def triangle_bounds(corners: np.ndarray, power: np.ndarray, outward: np.ndarray) -> Bounds:
    """Bounds of emissive triangles (M, 3, 3) that shine A Le cos to both sides.

    outward (M,) : 1 or -1 where the triangle is part of a closed surface, whose inside it faces with the other side; 0
    where both sides are seen alike.
    """
    n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(n, axis=1, keepdims=True)
    n = np.where(size > 0.0, n / np.where(size > 0.0, size, 1.0), (0.0, 0.0, 1.0))
    return empty_bounds(len(power))._replace(
        low=corners.min(axis=1), high=corners.max(axis=1), axis=np.where(outward[:, None] < 0.0, -n, n),
        back=np.where(outward == 0.0, 1.0, INSIDE), power=power,
    )  # fmt: skip


def spot_half_angle(cosine: float, to_world: np.ndarray, axis: np.ndarray) -> float:
    """Largest angle [rad] between a spot's axis (3,) and its rim, a circle that to_world (3, 3) makes an ellipse."""
    angle = np.linspace(0.0, 2.0 * math.pi, 64)
    sine = math.sqrt(1.0 - cosine**2)
    rim = np.stack([sine * np.cos(angle), sine * np.sin(angle), np.full(64, -cosine)], 1) @ to_world.T
    off = np.arccos(np.clip(rim @ axis / np.linalg.norm(rim, axis=1), -1.0, 1.0))
    return float(off.max()) + 0.01  # what 64 points may miss


def spot_solid_angle(linear: np.ndarray, cos_half: float, blend: float) -> float:
    """Integral [sr] of a spot's falloff over directions; exact to 1e-4 for moderate scales.

    linear (3, 3) : the object's matrix. A local solid angle dw turns into |det M| / |M v|^3 dw.
    """
    n = 128
    height = 1.0 - (np.arange(n) + 0.5) / n * (1.0 - cos_half)
    angle = (np.arange(n) + 0.5) / n * 2.0 * math.pi
    sine = np.sqrt(1.0 - height**2)
    x, y = sine[:, None] * np.cos(angle), sine[:, None] * np.sin(angle)
    local = np.stack(np.broadcast_arrays(x, y, -height[:, None]), -1)
    with np.errstate(divide="ignore"):
        x = np.clip((height - cos_half) / ((1.0 - cos_half) * blend), 0.0, 1.0)
    falloff = x * x * (3.0 - 2.0 * x)
    jacobian = abs(np.linalg.det(linear)) / np.linalg.norm(local @ linear.T, axis=-1) ** 3
    return float(2.0 * math.pi * (1.0 - cos_half) * (falloff[:, None] * jacobian).mean())
