"""Voronoi cells in one to four dimensions, on Blender's lattice of jittered points [Worley 1996].

A place is four doubles (x, y, z, w) as in `perlin.py`. Unused coordinates are 0 and their cells are not searched.
"""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel
from .hashing import (
    PCG_TO_UNIT,
    color_of,
    pcg2,
    pcg3,
    pcg4,
    random1,
    random2,
    random3,
    random4,
    word,
)
from .perlin import lerp, moved, scaled

EUCLIDEAN, MANHATTAN, CHEBYCHEV, MINKOWSKI = range(4)
F1, F2, SMOOTH_F1, DISTANCE_TO_EDGE, N_SPHERE_RADIUS = range(5)
HUGE = 3.0e38
# rows of the parameters of `voronoi_rows`
SCALE, DETAIL, ROUGHNESS, LACUNARITY, SMOOTHNESS, EXPONENT, RANDOMNESS = range(7)
N_PARAMETERS = 7
# rows of its output
DISTANCE, RED, X, RADIUS = 0, 1, 4, 8
N_OUTPUTS = 9


@kernel
def minus(a, b):
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3])


@kernel
def dot4(a, b):
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@kernel
def jitter(law, cell):
    """Where in [0, 1]^dims the point of a cell lies; law: (dims, words, ...) with words 0 for hashes of floats."""
    dims, words = law[0], law[1]
    x, y, z, w = cell
    if dims == 1:
        return (0.0, 0.0, 0.0, random1(w))
    if words:
        i, j, k, m = word(int(x)), word(int(y)), word(int(z)), word(int(w))
        if dims == 2:
            a, b = pcg2(i, j)
            return (a * PCG_TO_UNIT, b * PCG_TO_UNIT, 0.0, 0.0)
        if dims == 3:
            a, b, c = pcg3(i, j, k)
            return (a * PCG_TO_UNIT, b * PCG_TO_UNIT, c * PCG_TO_UNIT, 0.0)
        a, b, c, d = pcg4(i, j, k, m)
        return (a * PCG_TO_UNIT, b * PCG_TO_UNIT, c * PCG_TO_UNIT, d * PCG_TO_UNIT)
    if dims == 2:
        return (random2(x, y), random3(x, y, 1.0), 0.0, 0.0)
    if dims == 3:
        return (random3(x, y, z), random4(x, y, z, 1.0), random4(x, y, z, 2.0), 0.0)
    return (random4(x, y, z, w), random4(w, x, y, z), random4(z, w, x, y), random4(y, z, w, x))


@kernel
def cell_color(law, cell):
    """The colour of a cell."""
    dims, words = law[0], law[1]
    if dims == 1 or not words:
        return color_of(dims, cell)
    i, j, k = word(int(cell[0])), word(int(cell[1])), word(int(cell[2]))
    if dims == 4:
        a, b, c, _ = pcg4(i, j, k, word(int(cell[3])))
    else:
        a, b, c = pcg3(i, j, word(0) if dims == 2 else k)
    return (a * PCG_TO_UNIT, b * PCG_TO_UNIT, c * PCG_TO_UNIT)


@kernel
def distance(law, d):
    """Length of a difference by the metric; law: (dims, words, metric, exponent, ...)."""
    x, y, z, w = abs(d[0]), abs(d[1]), abs(d[2]), abs(d[3])
    if law[0] == 1:
        return w
    metric, exponent = law[2], law[3]
    if metric == EUCLIDEAN:
        return math.sqrt(dot4(d, d))
    if metric == MANHATTAN:
        return x + y + z + w
    if metric == CHEBYCHEV:
        return max(max(x, y), max(z, w))
    total = x**exponent + y**exponent
    if law[0] > 2:
        total += z**exponent
    if law[0] > 3:
        total += w**exponent
    return total ** (1.0 / exponent)


@kernel
def reach(dims, axis, size):
    """How far to look along an axis: `size` cells, 0 along unused ones."""
    used = axis == 3 if dims == 1 else axis < dims
    return size if used else 0


@kernel
def base_of(dims, p):
    """The cell of a place, and the place within it."""
    x, y, z, w = p
    if dims == 1:
        cell = (0.0, 0.0, 0.0, np.floor(w))
    else:
        cell = (
            np.floor(x), np.floor(y), np.floor(z) if dims > 2 else 0.0, np.floor(w) if dims > 3 else 0.0
        )
    local = (0.0 if dims == 1 else x - cell[0], 0.0 if dims == 1 else y - cell[1],
             z - cell[2] if dims > 2 else 0.0, w - cell[3] if dims in (1, 4) else 0.0)
    return cell, local


@kernel
def point_of(law, cell, offset):
    """The point of the cell at an offset, relative to the cell."""
    return moved(offset, scaled(jitter(law, moved(cell, offset)), law[4]))


@kernel
def nearest(law, p):
    """Distances to the two nearest points, their cells' offsets and places."""
    dims = law[0]
    cell, local = base_of(dims, p)
    best, second = HUGE, HUGE
    best_at = best_point = second_at = second_point = (0.0, 0.0, 0.0, 0.0)
    rx, ry, rz, rw = reach(dims, 0, 1), reach(dims, 1, 1), reach(dims, 2, 1), reach(dims, 3, 1)
    for m in range(-rw, rw + 1):
        for k in range(-rz, rz + 1):
            for j in range(-ry, ry + 1):
                for i in range(-rx, rx + 1):
                    offset = (float(i), float(j), float(k), float(m))
                    point = point_of(law, cell, offset)
                    d = distance(law, minus(point, local))
                    if d < best:
                        second, second_at, second_point = best, best_at, best_point
                        best, best_at, best_point = d, offset, point
                    elif d < second:
                        second, second_at, second_point = d, offset, point
    return cell, best, best_at, best_point, second, second_at, second_point


@kernel
def smooth_f1(law, p, smoothness):
    """Distance, colour and place blended over the points around by a smooth minimum."""
    dims = law[0]
    cell, local = base_of(dims, p)
    d0, first = 0.0, True
    red, green, blue = 0.0, 0.0, 0.0
    place = (0.0, 0.0, 0.0, 0.0)
    rx, ry, rz, rw = reach(dims, 0, 2), reach(dims, 1, 2), reach(dims, 2, 2), reach(dims, 3, 2)
    for m in range(-rw, rw + 1):
        for k in range(-rz, rz + 1):
            for j in range(-ry, ry + 1):
                for i in range(-rx, rx + 1):
                    offset = (float(i), float(j), float(k), float(m))
                    point = point_of(law, cell, offset)
                    d = distance(law, minus(point, local))
                    h = 1.0
                    if not first:
                        t = min(max(0.5 + 0.5 * (d0 - d) / smoothness, 0.0), 1.0)
                        h = t * t * (3.0 - 2.0 * t)
                    first = False
                    fix = smoothness * h * (1.0 - h)
                    d0 = lerp(d0, d, h) - fix
                    if h == 0.0:  # nothing of this cell is blended in
                        continue
                    fix /= 1.0 + 3.0 * smoothness
                    r, g, b = cell_color(law, moved(cell, offset))
                    red, green, blue = lerp(red, r, h) - fix, lerp(green, g, h) - fix, lerp(blue, b, h) - fix
                    fix_z = fix if dims > 2 else 0.0
                    place = (lerp(place[0], point[0], h) - fix, lerp(place[1], point[1], h) - fix,
                             lerp(place[2], point[2], h) - fix_z, lerp(place[3], point[3], h) - fix)
    return d0, (red, green, blue), moved(place, cell)


@kernel
def octave_of(law, feature, p, smoothness):
    """Distance, colour and place of F1, F2 or smooth F1."""
    if feature == SMOOTH_F1 and smoothness != 0.0:
        return smooth_f1(law, p, smoothness)
    cell, best, best_at, best_point, second, second_at, second_point = nearest(law, p)
    if feature == F2:
        best, best_at, best_point = second, second_at, second_point
    return best, cell_color(law, moved(cell, best_at)), moved(best_point, cell)


@kernel
def edge_distance(law, p):
    """Distance to the nearest wall between cells [Quilez, Voronoi borders]."""
    dims = law[0]
    cell, local = base_of(dims, p)
    if dims == 1:
        middle = point_of(law, cell, (0.0, 0.0, 0.0, 0.0))[3]
        left, right = point_of(law, cell, (0.0, 0.0, 0.0, -1.0))[3], point_of(law, cell, (0.0, 0.0, 0.0, 1.0))[3]
        return min(abs(0.5 * (middle + left) - local[3]), abs(0.5 * (middle + right) - local[3]))
    rz, rw = reach(dims, 2, 1), reach(dims, 3, 1)
    best = HUGE
    to_best = (0.0, 0.0, 0.0, 0.0)
    for m in range(-rw, rw + 1):
        for k in range(-rz, rz + 1):
            for j in range(-1, 2):
                for i in range(-1, 2):
                    to = minus(point_of(law, cell, (float(i), float(j), float(k), float(m))), local)
                    d = dot4(to, to)
                    if d < best:
                        best, to_best = d, to
    wall = HUGE
    for m in range(-rw, rw + 1):
        for k in range(-rz, rz + 1):
            for j in range(-1, 2):
                for i in range(-1, 2):
                    to = minus(point_of(law, cell, (float(i), float(j), float(k), float(m))), local)
                    across = minus(to, to_best)
                    size = dot4(across, across)
                    if size > 0.0001:
                        wall = min(wall, 0.5 * dot4(moved(to_best, to), across) / math.sqrt(size))
    return wall


@kernel
def sphere_radius(law, p):
    """Half the distance from the nearest point to the point nearest to it, both by Euclid."""
    dims = law[0]
    law = (law[0], law[1], EUCLIDEAN, law[3], law[4])
    cell, _, at, point, _, _, _ = nearest(law, p)
    best = HUGE
    rx, ry, rz, rw = reach(dims, 0, 1), reach(dims, 1, 1), reach(dims, 2, 1), reach(dims, 3, 1)
    for m in range(-rw, rw + 1):
        for k in range(-rz, rz + 1):
            for j in range(-ry, ry + 1):
                for i in range(-rx, rx + 1):
                    if i == 0 and j == 0 and k == 0 and m == 0:
                        continue
                    offset = moved(at, (float(i), float(j), float(k), float(m)))
                    to = minus(point_of(law, cell, offset), point)
                    best = min(best, dot4(to, to))
    return 0.5 * math.sqrt(best)


@kernel
def fractal_cells(law, feature, p, shape):
    """Octaves of F1, F2 or smooth F1; shape: detail, roughness, lacunarity, smoothness.

    out : distance, colour, place, sum of the weights
    """
    detail, roughness, lacunarity, smoothness = shape
    if detail == 0.0 or roughness == 0.0:
        d, color, place = octave_of(law, feature, p, smoothness)
        return d, color, place, 1.0
    weight, weights, scale, total = 1.0, 0.0, 1.0, 0.0
    color, place = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    for i in range(math.ceil(detail) + 1):
        d, c, at = octave_of(law, feature, scaled(p, scale), smoothness)
        share = 1.0 if i <= detail else detail - math.floor(detail)
        weights += weight * share
        total += d * weight * share
        color = (color[0] + c[0] * weight * share, color[1] + c[1] * weight * share, color[2] + c[2] * weight * share)
        way = minus(scaled(at, 1.0 / scale), place)
        place = moved(place, scaled(way, weight * share))
        scale *= lacunarity
        weight *= roughness
    return total, color, place, weights


@kernel
def fractal_edge(law, p, shape, largest):
    """Octaves of the distance to the edge, and the largest value that they can have."""
    detail, roughness, lacunarity, _ = shape
    if detail == 0.0 or roughness == 0.0:
        return edge_distance(law, p), largest
    weight, scale, value, bound = 1.0, 1.0, 8.0, largest
    for i in range(math.ceil(detail) + 1):
        d = edge_distance(law, scaled(p, scale))
        if i <= detail:
            bound = lerp(bound, largest / scale, weight)
            value = lerp(value, min(value, d / scale), weight)
            scale *= lacunarity
            weight *= roughness
        else:
            rest = detail - math.floor(detail)
            bound = lerp(bound, lerp(bound, largest / scale, weight), rest)
            value = lerp(value, min(value, lerp(value, min(value, d / scale), weight)), rest)
    return value, bound


@kernel
def voronoi_rows(places, parameters, switches, out):
    """Voronoi textures of a batch.

    places : (4, n) f32;  parameters : (N_PARAMETERS, n | 1) f32;  switches : feature, metric, dims, words, normalize
    out : (N_OUTPUTS, n) f32: distance, colour, place, radius
    """
    feature, metric, dims, words, normalize = switches
    step = 0 if parameters.shape[1] == 1 else 1
    for i in range(places.shape[1]):
        q = parameters[:, i * step]
        randomness = min(max(float(q[RANDOMNESS]), 0.0), 1.0)
        law = (dims, words, metric, float(q[EXPONENT]), randomness)
        shape = (min(max(float(q[DETAIL]), 0.0), 15.0), min(max(float(q[ROUGHNESS]), 0.0), 1.0), float(q[LACUNARITY]),
                 min(max(0.5 * float(q[SMOOTHNESS]), 0.0), 0.5))
        p = (float(places[0, i]), float(places[1, i]), float(places[2, i]), float(places[3, i]))
        if not math.isfinite(p[0] + p[1] + p[2] + p[3]):
            p = (0.0, 0.0, 0.0, 0.0)
        half = 0.5 + 0.5 * randomness
        if feature == DISTANCE_TO_EDGE:
            value, bound = fractal_edge(law, p, shape, half)
            out[DISTANCE, i] = value / bound if normalize else value
        elif feature == N_SPHERE_RADIUS:
            out[RADIUS, i] = sphere_radius(law, p)
        else:
            value, color, place, weights = fractal_cells(law, feature, p, shape)
            largest = distance(law, (half, half, half if dims > 2 else 0.0, half if dims in (1, 4) else 0.0))
            largest *= 2.0 if feature == F2 else 1.0
            out[DISTANCE, i] = value / (weights * largest) if normalize else value
            for k in range(3):
                out[RED + k, i] = color[k] / weights if normalize else color[k]
            for k in range(4):
                out[X + k, i] = place[k] / q[SCALE] if q[SCALE] != 0.0 else 0.0
