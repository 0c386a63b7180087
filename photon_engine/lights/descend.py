"""Picking an emitter from a light tree for a point, the probability of that, and the lamps that a ray may meet."""

from __future__ import annotations

import math

from ..jit import inlined, kernel
from ..vec import dot, load3, madd, sub

ALMOST_ONE = 0.9999999999999999
FRONTIER = 7  # first node of the fourth level: eight nodes tell how much a whole tree may send to a point


@inlined
def best_cosine(cosine, cos_o, sin_o, cos_b, sin_b, cos_e):
    """Largest cosine at which a normal within a cone may face a point within a cone; 0 when beyond the reach.

    cosine : between the axis and the direction to the middle;  o : cone of normals, b : cone of directions, e : reach.
    """
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    if cosine > cos_o:
        return 1.0
    c = cosine * cos_o + sine * sin_o
    s = sine * cos_o - cosine * sin_o
    if c > cos_b:
        return 1.0
    c, s = c * cos_b + s * sin_b, s * cos_b - c * sin_b
    return max(c, 0.0) if c > cos_e else 0.0


@inlined
def node_weight(tree, k, p):
    """Bound of the irradiance [W/m^2] that node k sends to p, unoccluded, facing it."""
    r = sub(p, load3(tree.center, k))
    d2 = dot(r, r)
    r2 = tree.radius[k] * tree.radius[k]
    if d2 <= r2:
        return tree.power[k] / max(r2, 1e-12)
    inverse = 1.0 / math.sqrt(d2)
    sin_b = tree.radius[k] * inverse
    cos_b = math.sqrt(max(0.0, 1.0 - sin_b * sin_b))
    cosine = dot(load3(tree.axis, k), r) * inverse
    cos_o, sin_o, cos_e = tree.cone[k, 0], tree.cone[k, 1], tree.cone[k, 2]
    facing = best_cosine(cosine, cos_o, sin_o, cos_b, sin_b, cos_e)
    if tree.back[k] > 0.0:
        facing = max(facing, tree.back[k] * best_cosine(-cosine, cos_o, sin_o, cos_b, sin_b, cos_e))
    return tree.power[k] * facing / max(d2, 1e-12)


@kernel
def tree_weight(tree, p):
    """Estimate of what all emitters together send to p, as `node_weight`."""
    if tree.item.shape[0] == 0:
        return 0.0
    return _frontier_weight(tree, 0, p)


@inlined
def _frontier_weight(tree, root, p):
    """Sum over the nodes of the fourth level, and the leaves above it."""
    total = 0.0
    for k in range(root, min(tree.item.shape[0], 2 * FRONTIER + 1)):
        if tree.item[k] >= 0 or (k >= FRONTIER and tree.item[k] == -1):
            total += node_weight(tree, k, p)
    return total


@inlined
def left_share(tree, k, p):
    """Probability of the left child of inner node k."""
    a = node_weight(tree, 2 * k + 1, p)
    b = node_weight(tree, 2 * k + 2, p)
    if a + b > 0.0:
        return a / (a + b)
    return tree.power[2 * k + 1] / max(tree.power[k], 1e-300)


@kernel
def tree_pick(tree, p, u):
    """An emitter for p: (index, probability, fresh uniform number)."""
    k = 0
    probability = 1.0
    while tree.item[k] < 0:
        share = left_share(tree, k, p)
        if u < share:
            u = min(u / share, ALMOST_ONE)
            probability *= share
            k = 2 * k + 1
        else:
            u = min(max((u - share) / (1.0 - share), 0.0), ALMOST_ONE)
            probability *= 1.0 - share
            k = 2 * k + 2
    return tree.item[k], probability, u


@kernel
def tree_p(tree, i, p):
    """Probability with which `tree_pick` finds emitter i for p."""
    k = tree.leaf[i]
    probability = 1.0
    while k > 0:
        parent = (k - 1) // 2
        share = left_share(tree, parent, p)
        probability *= share if k == 2 * parent + 1 else 1.0 - share
        k = parent
    return probability


@inlined
def may_meet(tree, k, o, d, t_min, t_max):
    """Whether a ray between t_min and t_max comes near enough to node k to meet one of its emitters."""
    if not tree.solid[k]:
        return False
    r = sub(load3(tree.center, k), o)
    along = dot(r, d)
    radius = tree.radius[k] * 1.000001
    if along + radius < t_min or along - radius > t_max:
        return False
    across = madd(r, -along, d)
    return dot(across, across) <= radius * radius


@kernel
def next_met(tree, k, o, d, t_min, t_max):
    """The first leaf at or after node k, in depth-first order, that the ray may meet; -1: none is left."""
    while k >= 0:
        if may_meet(tree, k, o, d, t_min, t_max):
            if tree.item[k] >= 0:
                return k
            k = 2 * k + 1
        else:
            k = after(k)
    return -1


@inlined
def after(k):
    """The node that follows the whole subtree of node k in depth-first order; -1: none."""
    while k > 0 and k % 2 == 0:
        k = (k - 1) // 2
    return k + 1 if k > 0 else -1
