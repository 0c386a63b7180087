"""Which visible points share a clearing, and what the rays around its origin say of walls and rims."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.surface import corners, face_normal, surface_point
from ..jit import inlined, kernel
from ..sampling.rng import mix, uniform
from ..vec import add, basis, cross, dot, load3, madd, normalize, scale, store3, sub
from .clipping import MOST_LINES

SAME_SURFACE = 0.5  # cosine between normals beyond which a photon lies on another face
DIMENSION = 12288  # random numbers: after those of secondary rays
FAN = MOST_LINES  # rays around an origin
CELL = 0.5  # edge of the cells whose points share a clearing, in radii
# rays reach so many radii: to the disc's border as seen from the cell's other corner, and so much farther that at
# least one of eight meets every long wall that cuts the disc
REACH = (1.0 + CELL * math.sqrt(2.0)) / math.cos(math.pi / FAN)
LIFT = 0.03  # rays run so many radii above and below the tangent plane
GAP = 0.05  # a surface that goes on behind a slit of so many radii has no rim there
SLOPE = 0.1  # how far a sheet may leave the tangent plane by distance, where its continuation is looked for
MOST_BENT = 0.15  # so many radii a sharing point may lie beside the tangent plane,
ALIKE = 0.9  # and its normal has this cosine
FAR = 0.7  # of the reach: a wall so far off may be met by one ray only,
WIDE = 0.2  # and so may a nearer one, but it has at least a triangle so many radii wide
NOTHING, WALL, EXIT, END, RIM = 0, 1, 2, 3, 4  # what is known in one direction


class Sites(NamedTuple):
    """Visible points of a batch, as far as clearings need them."""

    p: np.ndarray  # (m, 3) f64 [m]
    n: np.ndarray  # (m, 3) f64, geometric normal on the seen side
    radius: np.ndarray  # (m,) f64, how far points look around them, positive [m]
    prim: np.ndarray  # (m,) i32
    key: np.ndarray  # (m,) u64, random numbers
    cell: np.ndarray  # (m,) u64, hash of (radius, cell of space, main axis of n)


class Fan(NamedTuple):
    """What is known in each direction around the origins of clearings."""

    site: np.ndarray  # (k,) i32, the point that is the origin
    direction: np.ndarray  # (k, FAN, 3) f32, unit, in the tangent plane
    line: np.ndarray  # (k, FAN, 4) f32, as in Clearings
    state: np.ndarray  # (k, FAN) u8, one of the constants above
    bracket: np.ndarray  # (k, FAN, 2) f64, distances between which a surface ends [m]
    last: np.ndarray  # (k, FAN) i32, the triangle of a wall, or the one met at the nearer distance


def empty_sites(n: int) -> Sites:
    """Room for n visible points."""
    prim = np.empty(n, np.int32)
    return Sites(np.empty((n, 3)), np.empty((n, 3)), np.empty(n), prim, np.empty(n, np.uint64), np.empty(n, np.uint64))


def empty_fan(site: np.ndarray) -> Fan:
    """Around the given points."""
    k = len(site)
    return Fan(
        site, np.empty((k, FAN, 3), np.float32), np.zeros((k, FAN, 4), np.float32), np.zeros((k, FAN), np.uint8),
        np.zeros((k, FAN, 2)), np.full((k, FAN), -1, np.int32),
    )  # fmt: skip


@kernel
def place_sites(surfaces, points, pixels, most, sites):
    """Fill the sites of visible points that look `pixels` footprints around them, at most so far [m]."""
    for m in range(len(points.hit)):
        i = points.hit[m]
        prim = surfaces.prim[i]
        p, ng, _ = surface_point(surfaces.geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
        n = ng if dot(load3(points.wo, m), ng) >= 0.0 else scale(ng, -1.0)
        store3(sites.p, m, p)
        store3(sites.n, m, n)
        sites.prim[m] = prim
        sites.key[m] = points.key[m]
        sites.radius[m] = max(min(pixels * float(points.footprint[m]), most), 1e-6 * most)


@kernel
def find_cells(sites):
    """Round the sites' radii up to powers of sqrt(2), so that many are the same, and say which cell each is in."""
    for m in range(len(sites.prim)):
        level = math.ceil(2.0 * math.log2(sites.radius[m]) - 1e-9)
        sites.radius[m] = 2.0 ** (0.5 * level)
        sites.cell[m] = _cell_hash(load3(sites.p, m), load3(sites.n, m), CELL * sites.radius[m], level)


@inlined
def _cell_hash(p, n, edge, level):
    """Hash of a cell of space at one level of radii, and of the side that a normal mainly faces."""
    axis = 0 if abs(n[0]) >= max(abs(n[1]), abs(n[2])) else 1 if abs(n[1]) >= abs(n[2]) else 2
    side = 2 * axis + (1 if n[axis] > 0.0 else 0)
    h = mix(np.uint64(np.int64(level) * 8 + side + (1 << 40)))
    for c in range(3):
        h = mix(h + np.uint64(np.int64(math.floor(p[c] / edge)) + (1 << 62)))
    return h


@kernel
def share(sites, rest, first, table, of_point, origins):
    """Let the points `rest` share origins by their cells; out: how many origins there are, from `first` on.

    The first point of a cell is its origin. table (power of two,) i32: work space; of_point : the origin's number.
    """
    table[:] = -1
    mask = len(table) - 1
    count = first
    for m in rest:
        slot = np.int64(sites.cell[m] & np.uint64(mask))
        while table[slot] >= 0 and sites.cell[origins[table[slot]]] != sites.cell[m]:
            slot = (slot + 1) & mask
        if table[slot] < 0:
            table[slot] = count
            origins[count] = m
            count += 1
        of_point[m] = table[slot]
    return count


@kernel
def aim(sites, fan, o, d, t_max):
    """Rays around each origin: FAN above the tangent plane, then FAN below it."""
    for k in range(len(fan.site)):
        m = fan.site[k]
        p, n, r = load3(sites.p, m), load3(sites.n, m), sites.radius[m]
        s, t = basis(n)
        turn = uniform(sites.key[m], DIMENSION)
        for j in range(FAN):
            angle = 2.0 * math.pi * (j + turn) / FAN
            w = add(scale(s, math.cos(angle)), scale(t, math.sin(angle)))
            store3(fan.direction[k], j, w)
            for side in range(2):
                ray = (2 * k + side) * FAN + j
                store3(o, ray, madd(p, LIFT * r * (1 - 2 * side), n))
                store3(d, ray, w)
                t_max[ray] = np.float32(REACH * r)


@kernel
def judge(geometry, sites, fan, hits):
    """What the rays of `aim` met: walls, ways out of the solid below, or nothing."""
    for k in range(len(fan.site)):
        m = fan.site[k]
        p, n, reach = load3(sites.p, m), load3(sites.n, m), REACH * sites.radius[m]
        for j in range(FAN):
            w = load3(fan.direction[k], j)
            above, below = 2 * k * FAN + j, (2 * k + 1) * FAN + j
            nearest = reach
            for side in range(2):
                ray = below if side else above
                if hits.prim[ray] < 0:
                    continue
                lift = LIFT * sites.radius[m] * (1 - 2 * side)
                met = madd(madd(p, lift, n), float(hits.t[ray]), w)
                found, a, distance = _line(geometry, hits.prim[ray], sub(met, p), n, w, side)
                along = distance / dot(a, w) if dot(a, w) > 1e-9 else 0.0
                if found and along < nearest:
                    nearest = along
                    fan.last[k, j] = hits.prim[ray]
                    _note(fan, k, j, EXIT if side and dot(a, w) > 0.0 else WALL, a, distance)
            if hits.prim[above] < 0 and hits.prim[below] < 0:
                end = madd(p, reach, w)
                fan.state[k, j] = NOTHING if _within(geometry, sites.prim[m], n, end) else END
                fan.bracket[k, j, 1] = reach
                fan.last[k, j] = sites.prim[m]


@inlined
def _note(fan, k, j, state, a, distance):
    """Keep a line."""
    fan.state[k, j] = state
    for c in range(3):
        fan.line[k, j, c] = np.float32(a[c])
    fan.line[k, j, 3] = np.float32(distance)


@kernel
def _line(geometry, prim, met, n, w, side):
    """Where a facet's plane cuts the tangent plane: (whether it is a wall or rim, outward unit vector, distance).

    met : a point of the facet, from the origin;  side : 0 met from outside, 1 from within the solid. Under a wall that
    leans over the origin, rays start behind the wall and meet it from there: its foot lies the other way.
    """
    a, b, c = corners(geometry, prim)
    facet = face_normal(a, b, c)
    if (dot(facet, w) > 0.0) != (side == 1):
        facet = scale(facet, -1.0)
    cosine = dot(facet, n)
    flat = madd(facet, -cosine, n)
    size = math.sqrt(dot(flat, flat))
    if cosine > SAME_SURFACE or size < 0.1:
        return False, (0.0, 0.0, 0.0), 0.0
    out = scale(flat, (1.0 if side else -1.0) / size)
    distance = dot(facet, met) / dot(facet, out)
    if distance < 0.0:
        return True, scale(out, -1.0), -distance
    return True, out, distance


@kernel
def _within(geometry, prim, n, q):
    """Whether a point, moved along n, lies on a triangle."""
    a, b, c = corners(geometry, prim)
    ab, bc, ca = sub(b, a), sub(c, b), sub(a, c)
    x, y, z = dot(cross(ab, sub(q, a)), n), dot(cross(bc, sub(q, b)), n), dot(cross(ca, sub(q, c)), n)
    return (x >= 0.0 and y >= 0.0 and z >= 0.0) or (x <= 0.0 and y <= 0.0 and z <= 0.0)


@kernel
def probe(sites, fan, step, owner, o, d, t_max):
    """Rays down onto the surface; out: how many. owner : FAN k + j of each.

    step 0: just behind the ways out and at the ends of free directions; later: in the middle of the brackets.
    """
    count = 0
    for k in range(len(fan.site)):
        m = fan.site[k]
        p, n, r = load3(sites.p, m), load3(sites.n, m), sites.radius[m]
        for j in range(FAN):
            state = fan.state[k, j]
            w = load3(fan.direction[k], j)
            if state == EXIT and step == 0:
                cosine = max(dot(load3(fan.line[k], j), w), 0.1)
                at, depth = (float(fan.line[k, j, 3]) + GAP * r) / cosine, LIFT * r
            elif state == END and step == 0:
                at, depth = fan.bracket[k, j, 1], SLOPE * fan.bracket[k, j, 1]
            elif state == RIM and step > 0:
                at = 0.5 * (fan.bracket[k, j, 0] + fan.bracket[k, j, 1])
                depth = SLOPE * at + LIFT * r
            else:
                continue
            store3(o, count, madd(madd(p, at, w), depth, n))
            store3(d, count, scale(n, -1.0))
            t_max[count] = np.float32(2.0 * depth)
            owner[count] = k * FAN + j
            count += 1
    return count


@kernel
def answer(geometry, sites, fan, step, owner, hits):
    """What the rays of `probe` met; out: how many rims are still to be found."""
    for i in range(len(owner)):
        k, j = owner[i] // FAN, owner[i] % FAN
        prim = hits.prim[i]
        goes_on = False
        if prim >= 0:
            a, b, c = corners(geometry, prim)
            goes_on = abs(dot(face_normal(a, b, c), load3(sites.n, fan.site[k]))) > SAME_SURFACE
        if step == 0:
            if goes_on:
                fan.state[k, j] = NOTHING
            elif fan.state[k, j] == END:
                fan.state[k, j] = RIM
        elif goes_on:
            fan.bracket[k, j, 0] = 0.5 * (fan.bracket[k, j, 0] + fan.bracket[k, j, 1])
            fan.last[k, j] = prim
        else:
            fan.bracket[k, j, 1] = 0.5 * (fan.bracket[k, j, 0] + fan.bracket[k, j, 1])
    rims = 0
    for k in range(len(fan.site)):
        for j in range(FAN):
            rims += fan.state[k, j] == RIM
    return rims


@kernel
def draw_rims(geometry, sites, fan):
    """Lines of the rims: the side of the last triangle where a direction leaves it, else across the bracket."""
    for k in range(len(fan.site)):
        m = fan.site[k]
        p, n = load3(sites.p, m), load3(sites.n, m)
        for j in range(FAN):
            if fan.state[k, j] != RIM:
                continue
            w = load3(fan.direction[k], j)
            lo, hi = fan.bracket[k, j, 0], fan.bracket[k, j, 1]
            out, distance = w, 0.5 * (lo + hi)
            triangle = corners(geometry, fan.last[k, j])
            for c in range(3):
                a = sub(triangle[c], p)
                b = sub(triangle[(c + 1) % 3], p)
                side = normalize(cross(sub(b, a), n))
                if dot(side, w) < 0.0:
                    side = scale(side, -1.0)
                slope = dot(side, w)
                if slope > 1e-6 and lo <= dot(side, a) / slope <= hi and _crosses(a, b, w, n):
                    out, distance = side, dot(side, a)
            _note(fan, k, j, RIM, out, distance)


@inlined
def _crosses(a, b, w, n):
    """Whether the half-line along w crosses the stretch a b, as seen along n."""
    t = cross(n, w)
    return dot(a, t) * dot(b, t) <= 0.0


@kernel
def keep_lines(geometry, sites, fan, first, line, count):
    """Write the lines of each origin's fan as row first + k, each once.

    A small thing near by that only one ray met is taken for nothing: a line there would cut off more than it hides.
    """
    for k in range(len(fan.site)):
        r = sites.radius[fan.site[k]]
        n, reach = load3(sites.n, fan.site[k]), REACH * r
        kept = 0
        for j in range(FAN):
            state = fan.state[k, j]
            if state == NOTHING or state == END:
                continue
            a, distance = load3(fan.line[k], j), float(fan.line[k, j, 3])
            lonely = state == WALL and distance < FAR * reach and not _supported(fan, k, j, a)
            if lonely and _width(geometry, fan.last[k, j], cross(n, a)) < WIDE * r:
                continue
            known = False
            for i in range(kept):
                b = load3(line[first + k], i)
                known |= dot(a, b) > 0.999 and abs(distance - float(line[first + k, i, 3])) < 0.01 * reach
            if known:
                continue
            for c in range(3):
                line[first + k, kept, c] = np.float32(a[c])
            line[first + k, kept, 3] = np.float32(distance)
            kept += 1
        count[first + k] = kept


@kernel
def _width(geometry, prim, t):
    """How far a triangle extends along the unit vector t."""
    a, b, c = corners(geometry, prim)
    x, y, z = dot(a, t), dot(b, t), dot(c, t)
    return max(x, max(y, z)) - min(x, min(y, z))


@inlined
def _supported(fan, k, j, a):
    """Whether a neighbouring ray met a wall that faces nearly the same way."""
    for step in range(2):
        i = (j + 2 * step - 1) % FAN
        if fan.state[k, i] == WALL and dot(load3(fan.line[k], i), a) > 0.8:
            return True
    return False


@kernel
def outside(sites, rest, of_point, origins, line, count, left):
    """Points of `rest` whose clearing is not theirs, into `left`; out: how many."""
    found = 0
    for m in rest:
        row = of_point[m]
        k = origins[row]
        if k == m:
            continue
        n, r = load3(sites.n, k), sites.radius[m]
        away = sub(load3(sites.p, m), load3(sites.p, k))
        good = dot(n, load3(sites.n, m)) > ALIKE and abs(dot(n, away)) < MOST_BENT * r
        for j in range(count[row]):
            good &= dot(load3(line[row], j), away) <= float(line[row, j, 3])
        if not good:
            left[found] = m
            found += 1
    return found
