"""New photons that for certain can add nothing: those that fly past all that they could do something at.

A photon for the caustic map must meet a specular surface first; straight passes do not change its line. Any photon must
meet a surface at all. Only work is spared: the photons that are left, and their random numbers, are the same.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import inlined, kernel
from ..photons.batch import Photons, head
from ..vec import load3, madd, store3

MOST_BOXES = 8  # more objects are taken together
# photons of a chunk that are tried; where fewer than this share of them fly past, their rays cost less than the test
TRIED, WORTH = 1024, 0.25
LANES = 32  # photons at a time
# columns of work space: origins, inverses of directions, whether a box was met
ORIGIN, INVERSE, MEETS = 0, 3 * LANES, 6 * LANES
N_COLUMNS = 7
PAD = 1e-5  # of the scene's radius and of the distance: positions and rays are single precision


def boxes_of(positions: np.ndarray, triangles: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Corners (n, 2, 3) f64 of boxes round groups of triangles, of all together where there are more than MOST_BOXES.

    positions : (V, 3);  triangles : (T, 3);  group : (T,) the group of each, in ascending order
    """
    if len(triangles) == 0:
        return np.zeros((0, 2, 3))
    corners = positions[triangles]
    low, high = corners.min(axis=1).astype(np.float64), corners.max(axis=1).astype(np.float64)
    first = np.flatnonzero(np.diff(group, prepend=group[0] - 1))
    boxes = np.stack([np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)], axis=1)
    if len(boxes) > MOST_BOXES:
        return np.array([[boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]])
    return boxes


def keep_those_that_meet(boxes: np.ndarray, radius: float, photons: Photons, lost: np.ndarray) -> Photons:
    """The photons whose rays meet one of the boxes (n, 2, 3), in their order; the arrays are compacted in place.

    All of them where hardly any flies past: in a closed room the test would be in vain.

    radius : of the scene [m];  lost : (3,) f64, the flux of the others is added
    """
    lanes = np.zeros(N_COLUMNS * LANES)
    return head(photons, compact(widened(boxes, PAD * radius), lanes, photons, lost))


def widened(boxes: np.ndarray, pad: float) -> np.ndarray:
    """Boxes (n, 2, 3) that reach `pad` [m] farther."""
    return boxes + np.array([[-pad], [pad]])


@kernel
def compact(boxes, lanes, photons, lost):
    """Move photons that meet a box to the front; out: how many, all where few of the first ones do not.

    lanes : work space (N_COLUMNS * LANES,)
    """
    n = len(photons.key)
    tried = min(n, TRIED)
    missing = 0
    for first in range(0, tried, LANES):
        note_all(boxes, lanes, photons, first)
        for j in range(min(LANES, tried - first)):
            missing += 0 if lanes[MEETS + j] > 0.0 else 1
    if missing < WORTH * tried:
        return n
    kept, past = 0, (0.0, 0.0, 0.0)
    for first in range(0, n, LANES):
        note_all(boxes, lanes, photons, first)
        for j in range(min(LANES, n - first)):  # all are written, only some counted: branches would be mispredicted
            move(photons, first + j, kept)
            meets = lanes[MEETS + j] > 0.0
            past = madd(past, 0.0 if meets else 1.0, load3(photons.phi, first + j))
            kept += 1 if meets else 0
    for c in range(3):
        lost[c] += past[c]
    return kept


@inlined
def note_all(boxes, lanes, photons, first):
    """Mark which of the photons from `first` on, as many as there are lanes, meet a box."""
    load_rays(lanes, photons, first, min(LANES, len(photons.key) - first))
    for j in range(LANES):
        lanes[MEETS + j] = 0.0
    for b in range(len(boxes)):
        note_meetings(lanes, boxes, b)


@inlined
def load_rays(lanes, photons, first, count):
    """Put origins and the inverses of directions of `count` photons into the lanes; those beyond keep what they hold.

    Without divisions by zero: along an axis in which it does not move, a ray moves by 1e-30 a metre.
    """
    for j in range(count):
        for c in range(3):
            lanes[ORIGIN + c * LANES + j] = photons.o[first + j, c]
            lanes[INVERSE + c * LANES + j] = photons.d[first + j, c]
    for k in range(INVERSE, INVERSE + 3 * LANES):
        lanes[k] = 1.0 / math.copysign(max(abs(lanes[k]), 1e-30), lanes[k])


@inlined
def note_meetings(lanes, boxes, b):
    """Mark the lanes whose rays meet box b, widened by PAD of the way to it."""
    low, high = (boxes[b, 0, 0], boxes[b, 0, 1], boxes[b, 0, 2]), (boxes[b, 1, 0], boxes[b, 1, 1], boxes[b, 1, 2])
    for j in range(LANES):
        near, far = 0.0, math.inf
        for c in range(3):
            o, inverse = lanes[ORIGIN + c * LANES + j], lanes[INVERSE + c * LANES + j]
            a, z = low[c] - o, high[c] - o
            more = PAD * max(abs(a), abs(z))
            a, z = (a - more) * inverse, (z + more) * inverse
            near, far = max(near, min(a, z)), min(far, max(a, z))
        lanes[MEETS + j] = 1.0 if near <= far else lanes[MEETS + j]


@inlined
def move(photons, i, to):
    """Write photon i to an earlier place."""
    store3(photons.o, to, load3(photons.o, i))
    store3(photons.d, to, load3(photons.d, i))
    store3(photons.phi, to, load3(photons.phi, i))
    photons.key[to] = photons.key[i]
    photons.seen[to] = photons.seen[i]
    photons.dark[to] = photons.dark[i]
    if len(photons.inside):
        photons.inside[to] = photons.inside[i]
    if len(photons.lamp):
        photons.lamp[to] = photons.lamp[i]
