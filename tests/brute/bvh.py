"""A median-split box tree over triangles, in doubles."""

from typing import NamedTuple

import numpy as np

from .jit import kernel
from .maths import cross, dot, row

LEAF = 4


class Tree(NamedTuple):
    """Boxes, and the triangles in the order of the leaves."""

    lo: np.ndarray  # (N, 3) f64
    hi: np.ndarray  # (N, 3) f64
    child: np.ndarray  # (N,) i32, left child (right is next to it), or the first triangle of a leaf
    count: np.ndarray  # (N,) i32, triangles of a leaf; 0: inner node
    v0: np.ndarray  # (T, 3) f64
    e1: np.ndarray  # (T, 3) f64
    e2: np.ndarray  # (T, 3) f64


def build_tree(corners):
    """Tree over (T, 3, 3) corners, and the order (T,) in which it keeps the triangles."""
    centre = corners.mean(axis=1)
    order = np.arange(len(corners))
    lo, hi, child, count = [None], [None], [0], [0]
    todo = [(0, 0, len(corners))]
    while todo:
        node, a, b = todo.pop()
        box = corners[order[a:b]].reshape(-1, 3)
        lo[node], hi[node] = box.min(axis=0), box.max(axis=0)
        if b - a <= LEAF:
            child[node], count[node] = a, b - a
            continue
        c = centre[order[a:b]]
        axis = int(np.argmax(np.ptp(c, axis=0)))
        middle = (b - a) // 2
        order[a:b] = order[a:b][np.argpartition(c[:, axis], middle)]
        child[node] = len(lo)
        for half in ((a, a + middle), (a + middle, b)):
            todo.append((len(lo), *half))
            for column in (lo, hi, child, count):
                column.append(0)
    c = corners[order]
    tree = Tree(
        np.array(lo, float), np.array(hi, float), np.array(child, np.int32), np.array(count, np.int32),
        np.ascontiguousarray(c[:, 0]), c[:, 1] - c[:, 0], c[:, 2] - c[:, 0],
    )
    return tree, order


@kernel
def hit_box(lo, hi, n, o, inverse, t_max):
    """Whether the ray meets the box of node n before t_max."""
    near, far = 0.0, t_max
    for k in range(3):
        a = (lo[n, k] - o[k]) * inverse[k]
        b = (hi[n, k] - o[k]) * inverse[k]
        if a > b:
            a, b = b, a
        # comparisons that a NaN (0 * inf: the ray lies in the box's face) leaves alone
        if a > near:
            near = a
        if b < far:
            far = b
    return near <= far * (1.0 + 1e-12)


@kernel
def hit_triangle(tree, i, o, d):
    """(t, u, v) of the ray and triangle i; t < 0: missed [Moeller and Trumbore 1997]."""
    e1, e2, v0 = row(tree.e1, i), row(tree.e2, i), row(tree.v0, i)
    p = cross(d, e2)
    det = dot(e1, p)
    if det == 0.0:
        return -1.0, 0.0, 0.0
    s = (o[0] - v0[0], o[1] - v0[1], o[2] - v0[2])
    u = dot(s, p) / det
    if u < 0.0 or u > 1.0:
        return -1.0, 0.0, 0.0
    q = cross(s, e1)
    v = dot(d, q) / det
    if v < 0.0 or u + v > 1.0:
        return -1.0, 0.0, 0.0
    return dot(e2, q) / det, u, v


@kernel
def intersect(tree, o, d, t_max, skip, stack):
    """Nearest triangle (index or -1, t, u, v) hit before t_max, not the triangle `skip`; stack: (64,) i32 scratch."""
    inverse = (1.0 / d[0], 1.0 / d[1], 1.0 / d[2])
    best, best_u, best_v = -1, 0.0, 0.0
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = stack[top]
        if not hit_box(tree.lo, tree.hi, node, o, inverse, t_max):
            continue
        first = tree.child[node]
        if tree.count[node] == 0:
            stack[top] = first
            stack[top + 1] = first + 1
            top += 2
            continue
        for i in range(first, first + tree.count[node]):
            if i == skip:
                continue
            t, u, v = hit_triangle(tree, i, o, d)
            # rounding leaves about 1e-15 of the scene's size; the same triangle is skipped by index
            if 1e-10 < t < t_max:
                t_max, best, best_u, best_v = t, i, u, v
    return best, t_max, best_u, best_v
