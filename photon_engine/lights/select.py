"""Which light to sample from a point: by an estimate of what arrives there, with a share for every light."""

from __future__ import annotations

import math

from ..jit import inlined
from ..vec import dot, load3, scale, sub
from .descend import tree_p, tree_pick, tree_weight
from .round import spot_falloff
from .table import AREA, DELTA, POINT, SPOT, SUN, WORLD

STATIC = 0.1  # of what a tree selects is drawn from a fixed table: the tree does not know what is in the way
FLOOR = 0.2  # of the probability is shared evenly by all lights that can reach the point
DARK_SPOT = 0.05  # weight of a spot with a radius outside its cone: its rim may still be seen


@inlined
def light_weight(lights, l, p):
    """Estimated irradiance [W/m^2] from light l at p, unoccluded, facing it; 0 only where none can arrive."""
    kind = lights.kind[l]
    power = lights.power[l]
    if kind == SUN or kind == WORLD:
        return power
    r = sub(p, load3(lights.position, l))
    d2 = dot(r, r)
    if kind == POINT or kind == SPOT:
        radius = lights.size[l, 0]
        weight = power / max(d2 + radius * radius, 1e-12)
        if kind == POINT or d2 == 0.0:
            return weight
        falloff = spot_falloff(lights, l, scale(r, 1.0 / math.sqrt(d2)))
        return weight * (falloff if lights.flags[l] & DELTA else max(falloff, DARK_SPOT))
    if kind == AREA:
        height = dot(r, load3(lights.normal, l))
        if height <= 0.0:
            return 0.0
        extent = lights.size[l, 0] * lights.size[l, 0] + lights.size[l, 1] * lights.size[l, 1]
        if lights.flags[l] & DELTA:
            return power / (math.pi * extent)
        # the lamp's own cosine, softened by its extent, since p may look at its near end
        cosine = min(1.0, (height + math.sqrt(extent)) / math.sqrt(d2 + extent))
        return power * cosine / (d2 + extent)
    return tree_weight(lights.tri_tree, p)


@inlined
def first_entry(lights):
    """The first light that is looked at; where a tree selects among the near lamps, the last of them stands for all."""
    return lights.n_near - 1 if lights.lamp_tree.item.shape[0] > 0 else 0


@inlined
def entry_weight(lights, l, first, p):
    """`light_weight` of light l, or that of all near lamps where l stands for them."""
    return tree_weight(lights.lamp_tree, p) if l == first and first > 0 else light_weight(lights, l, p)


@inlined
def selection_sums(lights, p):
    """(sum of all weights at p, how many are above 0), as `selection_p` needs them."""
    total = 0.0
    count = 0
    n = lights.kind.shape[0]
    first = first_entry(lights)
    if n - first == 1:
        return 1.0, 1
    for l in range(first, n):
        weight = entry_weight(lights, l, first, p)
        total += weight
        count += 1 if weight > 0.0 else 0
    return total, count


@inlined
def _entry_p(lights, l, first, p, total, count):
    """Probability of light l, or of the lamps that it stands for; total, count from `selection_sums`."""
    if lights.kind.shape[0] - first == 1:
        return 1.0
    weight = entry_weight(lights, l, first, p)
    return (1.0 - FLOOR) * weight / total + FLOOR / count if weight > 0.0 else 0.0


@inlined
def selection_p(lights, l, p):
    """Probability with which `select_light` chooses light l at p."""
    total, count = selection_sums(lights, p)
    first = first_entry(lights)
    if first == 0 or l > first:
        return _entry_p(lights, l, first, p, total, count)
    return _entry_p(lights, first, first, p, total, count) * mixed_p(lights.lamp_tree, lights.near_cdf, l, p)


@inlined
def mixed_p(tree, cdf, i, p):
    """Probability of emitter i in `mixed_pick`."""
    static = cdf[i] - (cdf[i - 1] if i > 0 else 0.0)
    return (1.0 - STATIC) * tree_p(tree, i, p) + STATIC * static


@inlined
def mixed_pick(tree, cdf, p, u):
    """An emitter by a tree or, now and then, by a fixed table: (index, probability, fresh uniform number)."""
    if u < STATIC:
        i, static, rest = pick(cdf, u / STATIC)
        return i, (1.0 - STATIC) * tree_p(tree, i, p) + STATIC * static, rest
    i, probability, rest = tree_pick(tree, p, (u - STATIC) / (1.0 - STATIC))
    static = cdf[i] - (cdf[i - 1] if i > 0 else 0.0)
    return i, (1.0 - STATIC) * probability + STATIC * static, rest


@inlined
def search(cdf, u):
    """First index whose cumulative value exceeds u, for u in [0, 1) and a CDF that ends at 1."""
    low = 0
    high = cdf.shape[0] - 1
    while low < high:
        middle = (low + high) // 2
        if cdf[middle] > u:
            high = middle
        else:
            low = middle + 1
    return low


@inlined
def pick(cdf, u):
    """Index drawn from a CDF, its probability, and a fresh uniform number made of what u has left: (i, p, u')."""
    i = search(cdf, u)
    before = cdf[i - 1] if i > 0 else 0.0
    p = cdf[i] - before
    return i, p, min(max((u - before) / p, 0.0), 0.9999999999999999)


@inlined
def select_light(lights, p, u):
    """A light for the point p: (l, probability, fresh uniform number); l = -1: no light can reach p."""
    n = lights.kind.shape[0]
    first = first_entry(lights)
    if n == 0:
        return -1, 0.0, u
    if n == 1:
        return 0, 1.0, u
    total, count = selection_sums(lights, p)
    if count == 0:
        return -1, 0.0, u
    below = 0.0
    last = -1
    probability = 0.0
    for l in range(first, n):
        q = _entry_p(lights, l, first, p, total, count)
        if q > 0.0:
            last = l
            probability = q
            if u < below + q:
                break
            below += q
    rest = min(max((u - below) / probability, 0.0), 0.9999999999999999)
    if first > 0 and last == first:
        l, p_lamp, rest = mixed_pick(lights.lamp_tree, lights.near_cdf, p, rest)
        return l, probability * p_lamp, rest
    return last, probability, rest
