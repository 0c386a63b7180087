"""Every way on from a hit at once, instead of one picked at random: for paths that follow all of them."""

from __future__ import annotations

from ..jit import kernel
from ..vec import mul
from .layout import CLASS_NULL, CLASS_SHARP, GLASS, NONE, REFRACT
from .surface import sample_lobe


@kernel
def straight_through(kinds, scratch):
    """Colour that passes straight through a prepared row; kinds : (K,) i32 of the row."""
    r, g, b = 0.0, 0.0, 0.0
    for k in range(len(kinds)):
        if kinds[k] == NONE:  # beyond it scratch holds another hit's lobes
            break
        if scratch[k, 4] == CLASS_NULL:
            r += scratch[k, 0]
            g += scratch[k, 1]
            b += scratch[k, 2]
    return (r, g, b)


@kernel
def is_fork(kinds, scratch, weights):
    """Whether more than one way leads on from a prepared row; weights : what `prepare` returned. An upper bound:
    total reflection leaves only one way through glass."""
    ways = (1 if weights[0] > 0.0 else 0) + (1 if weights[2] > 0.0 else 0)
    if weights[1] <= 0.0:
        return ways > 1
    for k in range(len(kinds)):
        if kinds[k] == NONE:
            break
        if scratch[k, 4] == CLASS_SHARP and scratch[k, 3] > 0.0:
            ways += sides(kinds[k])
    return ways > 1


@kernel
def sides(kind):
    """How many ways lead on from a sharp lobe: glass reflects and refracts."""
    return 2 if kind == GLASS else 1


@kernel
def sample_side(rows, row, k, side, frame, scratch, u1, u2):
    """One way on from the sharp lobe k of a prepared row: (ok, wi, weight rgb, eta), eta as in `surface.sample`.

    side : 0, or 1 for what glass refracts;  frame : (ns, ng, wo);  u1, u2 : choose the facet of a lobe that is not
    quite smooth. The weights of all sides of all lobes add up to what `sample` gives in the mean.
    """
    ns, ng, wo = frame
    through = side == 1 or rows.kind[row, k] == REFRACT
    ok, wi, value, _, eta = sample_lobe(rows, row, k, ns, ng, wo, (2.0 if through else -1.0, u1, u2), 0)
    return ok, wi, mul(value, (scratch[k, 0], scratch[k, 1], scratch[k, 2])), eta
