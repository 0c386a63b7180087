"""Clearings: how far around visible points the surface goes on, free of walls, up to its rims. By rays.

Points that lie close together on one surface share a clearing, so that a ray or two for each point are enough. From
its origin rays go out in the tangent plane, a little above it, to find what stands on the surface, and a little
below, where they leave a solid through the face behind its edge. Where both meet nothing, a ray down from their end
tells whether the surface is still there; if not, its rim is found by halving the distance.

What rays cannot see are objects narrower than an eighth of the turn; they dim the light around them as long as the
radius is not small beside them.
"""

from __future__ import annotations

import numpy as np

from ..geometry.flatten import Geometry
from ..geometry.intersect import Intersector
from .clearing_kernels import (
    FAN,
    Fan,
    Sites,
    aim,
    answer,
    draw_rims,
    empty_fan,
    empty_sites,
    find_cells,
    judge,
    keep_lines,
    outside,
    place_sites,
    probe,
    share,
)
from .clipping import MOST_LINES, Clearings

ROUNDS = 3  # of sharing; whoever is alone after them gets a clearing of its own
HALVINGS = 5


def find_clearings(intersector: Intersector, surfaces, points, pixels: float, most: float) -> tuple[Clearings, int]:
    """Clearings of visible points, and how many rays they took.

    surfaces, points : the batch of hits and its VisiblePoints;  pixels : how many footprints a point looks around, the
    gather radius or more, at most so far [m].
    """
    sites = empty_sites(len(points.hit))
    place_sites(surfaces, points, float(pixels), float(most), sites)
    return share_clearings(intersector, surfaces.geometry, sites)


def share_clearings(intersector: Intersector, geometry: Geometry, sites: Sites) -> tuple[Clearings, int]:
    """As `find_clearings`, of sites, whose `cell` is filled here."""
    find_cells(sites)
    n = len(sites.prim)
    of_point, origins = np.zeros(n, np.int32), np.zeros(n, np.int32)
    line, lines = np.empty((n, MOST_LINES, 4), np.float32), np.zeros(n, np.int32)
    rest = np.arange(n, dtype=np.int32)
    table = np.empty(1 << int(2 * max(len(rest), 1)).bit_length(), np.int32)
    count = rays = turn = 0
    while len(rest):
        first = count
        if turn == ROUNDS:
            sites.cell[rest] = np.arange(len(rest), dtype=np.uint64)  # everybody's own
        count = share(sites, rest, first, table, of_point, origins)
        fan = empty_fan(origins[first:count])
        rays += _look_around(intersector, geometry, sites, fan)
        keep_lines(geometry, sites, fan, first, line, lines)
        left = np.empty(len(rest), np.int32)
        rest = left[: outside(sites, rest, of_point, origins, line, lines, left)]
        turn += 1
    chosen = origins[:count]
    return Clearings(of_point, sites.p[chosen], line[:count], lines[:count], np.empty((MOST_LINES, 4))), rays


def _look_around(intersector: Intersector, geometry: Geometry, sites: Sites, fan: Fan) -> int:
    """Fill the fan's lines; out: rays."""
    n = len(fan.site) * FAN
    o, d, t_max = np.empty((2 * n, 3), np.float32), np.empty((2 * n, 3), np.float32), np.empty(2 * n, np.float32)
    aim(sites, fan, o, d, t_max)
    judge(geometry, sites, fan, intersector.closest(o, d, t_max))
    rays = 2 * n
    owner = np.empty(n, np.int32)
    for step in range(HALVINGS + 1):
        found = probe(sites, fan, step, owner, o, d, t_max)
        hits = intersector.closest(o[:found], d[:found], t_max[:found])
        rays += found
        if not answer(geometry, sites, fan, step, owner[:found], hits):
            break
    draw_rims(geometry, sites, fan)
    return rays
