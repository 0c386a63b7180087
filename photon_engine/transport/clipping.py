"""The part of a gather's disc that a surface fills: a polygon of lines around the point, cut out of the disc.

A density estimate divides by the area that photons could fall on. Where a wall stands within the radius, or the surface
ends, that is less than the disc. Photons beyond the lines are left out and the kernel is divided by its integral over
what remains, so that even light stays even up to the edge. Any polygon around the point will do that holds nothing
but lit surface: a smaller one costs photons, not truth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..jit import inlined, kernel
from ..vec import cross, dot, load3, sub

MOST_LINES = 8
# of the kernel; what is left of a smaller piece holds too few photons, and the whole disc is used as if nothing were
# cut: grass, leaves smaller than the radius, which then see the light of their neighbours too
LEAST_SHARE = 0.08


class Clearings(NamedTuple):
    """Polygons in tangent planes, shared by visible points that lie close together (clearing.find_clearings)."""

    of_point: np.ndarray  # (m,) i32, row of each visible point; (0,): every disc is whole
    origin: np.ndarray  # (k, 3) f64, a point inside [m]
    line: np.ndarray  # (k, MOST_LINES, 4) f32: unit vector outward in the plane, distance from the origin [m]
    count: np.ndarray  # (k,) i32, how many lines
    work: np.ndarray  # (MOST_LINES, 4) f64, the lines near one point, as `lines_near` leaves them


def no_clearings() -> Clearings:
    """Every disc is whole."""
    return Clearings(
        np.zeros(0, np.int32), np.zeros((0, 3)), np.zeros((0, MOST_LINES, 4), np.float32), np.zeros(0, np.int32),
        np.zeros((MOST_LINES, 4)),
    )  # fmt: skip


@kernel
def lines_near(clearings, m, p, r):
    """How many lines come within r of visible point m at p; they are left in `work`, with distances from p."""
    if len(clearings.of_point) == 0:
        return 0
    row = clearings.of_point[m]
    away = sub(p, load3(clearings.origin, row))
    found = 0
    for j in range(clearings.count[row]):
        a = load3(clearings.line[row], j)
        distance = float(clearings.line[row, j, 3]) - dot(a, away)
        if distance < r:
            for c in range(3):
                clearings.work[found, c] = a[c]
            clearings.work[found, 3] = max(distance, 1e-6 * r)
            found += 1
    return found


@inlined
def beyond(work, count, x, y, z):
    """Whether the offset (x, y, z) from the point lies beyond one of its lines."""
    for j in range(count):
        if work[j, 0] * x + work[j, 1] * y + work[j, 2] * z > work[j, 3]:
            return True
    return False


@kernel
def free_shares(work, count, n, r):
    """Integrals of K and K_4 of `gather` over what the lines leave of the disc, as parts of the whole disc's.

    In polar coordinates around p the integral is the mean over angles of Q(y), y = min(rho / r, 1)^2, with

        Q = 2 y - y^2 for K,  Q_4 = 6 y - 9 y^2 + 4 y^3 for K_4

    and along a line at distance d, d(angle) = d ds / (d^2 + s^2) makes both polynomials in s. Q_4 is never negative.
    """
    angle, part, part4 = 0.0, 0.0, 0.0
    inv = 1.0 / (r * r)
    for i in range(count):
        d = work[i, 3]
        s0, s1 = _open_stretch(work, count, n, i, math.sqrt(max(r * r - d * d, 0.0)))
        if s1 <= s0:
            continue
        angle += math.atan2(s1, d) - math.atan2(s0, d)
        y0 = d * d * inv
        m1, m3, m5 = s1 - s0, (s1**3 - s0**3) / 3.0, (s1**5 - s0**5) / 5.0
        once = y0 * m1 + inv * m3  # of y, along the line
        twice = y0 * y0 * m1 + 2.0 * y0 * inv * m3 + inv * inv * m5
        part += d * inv * (2.0 * m1 - once)
        part4 += d * inv * (6.0 * m1 - 9.0 * once + 4.0 * twice)
    free = 1.0 - angle / (2.0 * math.pi)
    return free + part / (2.0 * math.pi), free + part4 / (2.0 * math.pi)


@kernel
def _open_stretch(work, count, n, i, half):
    """The stretch [s0, s1] of line i, measured from its foot, within `half` of it and inside all other lines."""
    a, d = load3(work, i), work[i, 3]
    t = cross(n, a)
    s0, s1 = -half, half
    for j in range(count):
        if j == i:
            continue
        b = load3(work, j)
        slope, room = dot(b, t), work[j, 3] - d * dot(b, a)
        if slope > 1e-9:
            s1 = min(s1, room / slope)
        elif slope < -1e-9:
            s0 = max(s0, room / slope)
        elif room < 0.0 or (room == 0.0 and j < i):
            return 0.0, 0.0
    return s0, s1
