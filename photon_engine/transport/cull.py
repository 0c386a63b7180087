"""New photons that for certain can add nothing: those that fly past all that they could do something at.

A photon for the caustic map must meet a specular surface first; straight passes do not change its line. Any photon must
meet a surface at all. Only work is spared: the photons that are left, and their random numbers, are the same.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import inlined, kernel
from ..photons.batch import Photons, head
from ..vec import load3

MOST_BOXES = 8  # more objects are taken together: a box costs a new photon 5 ns
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

    radius : of the scene [m];  lost : (3,) f64, the flux of the others is added
    """
    return head(photons, compact(boxes, PAD * radius, photons, lost))


@kernel
def compact(boxes, pad, photons, lost):
    """Move photons that meet a box to the front; out: how many."""
    kept = 0
    for i in range(len(photons.key)):
        if not meets(boxes, pad, load3(photons.o, i), load3(photons.d, i)):
            for c in range(3):
                lost[c] += photons.phi[i, c]
            continue
        if kept < i:
            for c in range(3):
                photons.o[kept, c] = photons.o[i, c]
                photons.d[kept, c] = photons.d[i, c]
                photons.phi[kept, c] = photons.phi[i, c]
            photons.key[kept] = photons.key[i]
            photons.seen[kept] = photons.seen[i]
            photons.dark[kept] = photons.dark[i]
            if len(photons.inside):
                photons.inside[kept] = photons.inside[i]
        kept += 1
    return kept


@inlined
def meets(boxes, pad, o, d):
    """Whether a ray meets one of the boxes, widened by pad and by PAD of the way to them."""
    found = False
    for b in range(len(boxes)):
        near, far = 0.0, math.inf
        for c in range(3):
            low, high = boxes[b, 0, c] - o[c] - pad, boxes[b, 1, c] - o[c] + pad
            more = PAD * max(abs(low), abs(high))
            low, high = low - more, high + more
            if d[c] == 0.0:
                far = far if low <= 0.0 <= high else -1.0
                continue
            a, z = low / d[c], high / d[c]
            near, far = max(near, min(a, z)), min(far, max(a, z))
        found = found or near <= far
    return found
