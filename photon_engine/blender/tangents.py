"""Tangents of a UV layer per triangle corner, after MikkTSpace, without its limit to triangles and quads.

Blender's ``Mesh.calc_tangents`` refuses faces with more than four corners and writes into the mesh it is asked about.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel
from ..vec import add, cross, dot, load3, normalize, scale, store3, sub

MIX = np.uint64(0xBF58476D1CE4E5B9)
SHIFT = np.uint64(29)
NEGATIVE_ZERO = np.uint32(0x80000000)


def corner_tangents(
    positions: np.ndarray, triangles: np.ndarray, normals: np.ndarray | None, uv: np.ndarray
) -> np.ndarray:
    """Tangent and bitangent sign, (T, 3, 4) f32; the bitangent is ``sign * cross(n, t)``.

    [Mikkelsen 2008, Simulation of Wrinkled Surfaces Revisited]: the direction of growing u of each triangle, projected
    on the plane of the corner's normal, is averaged by corner angle over triangles that share position, normal, UV and
    handedness. positions (V, 3), triangles (T, 3), normals (T, 3, 3) or None for flat faces, uv (T, 3, 2).
    """
    n_tris = len(triangles)
    n = np.empty((n_tris, 3, 3), np.float32)
    out = np.empty((n_tris, 3, 4), np.float32)
    if normals is None:
        flat_normals(positions, triangles, n)
    else:
        n[:] = normals
    corner_directions(positions, triangles, n, uv, out)
    key = np.empty(n_tris * 3, np.uint64)
    words = (np.ascontiguousarray(a, np.float32).view(np.uint32) for a in (n, uv, out))
    corner_keys(triangles, *words, key)
    # an open-addressing table at most half full
    size = 1 << (2 * len(key)).bit_length()
    total = np.zeros((len(key), 3))
    group = np.empty(len(key), np.int32)
    add_groups(key, out.reshape(-1, 4), np.zeros(size, np.uint64), np.empty(size, np.int32), (group, total))
    write_tangents(group, total, n.reshape(-1, 3), out.reshape(-1, 4))
    return out


@kernel
def flat_normals(positions, triangles, n):
    """Geometric normals at all corners."""
    for t in range(len(triangles)):
        p0 = load3(positions, triangles[t, 0])
        e1 = sub(load3(positions, triangles[t, 1]), p0)
        e2 = sub(load3(positions, triangles[t, 2]), p0)
        for c in range(3):
            store3(n[t], c, normalize(cross(e1, e2)))


@kernel
def across(v, n):
    """Unit part of v in the plane of the unit normal n; zero when there is none."""
    return normalize(sub(v, scale(n, dot(v, n))))


@kernel
def corner_directions(positions, triangles, n, uv, out):
    """Each corner's direction of growing u times its angle, and the triangle's handedness, in out (T, 3, 4)."""
    for t in range(len(triangles)):
        p0 = load3(positions, triangles[t, 0])
        p1 = load3(positions, triangles[t, 1])
        p2 = load3(positions, triangles[t, 2])
        corners = (p0, p1, p2, p0, p1)
        u1 = float(uv[t, 1, 0]) - float(uv[t, 0, 0])
        v1 = float(uv[t, 1, 1]) - float(uv[t, 0, 1])
        u2 = float(uv[t, 2, 0]) - float(uv[t, 0, 0])
        v2 = float(uv[t, 2, 1]) - float(uv[t, 0, 1])
        area = u1 * v2 - v1 * u2
        sign = 1.0 if area >= 0.0 else -1.0
        along_u = scale(sub(scale(sub(p1, p0), v2), scale(sub(p2, p0), v1)), sign)
        if area == 0.0:  # no direction: such a triangle takes its neighbours'
            along_u = (0.0, 0.0, 0.0)
        for c in range(3):
            normal = load3(n[t], c)
            forward = across(sub(corners[c + 1], corners[c]), normal)
            backward = across(sub(corners[c + 2], corners[c]), normal)
            angle = math.acos(min(1.0, max(-1.0, dot(forward, backward))))
            store3(out[t], c, scale(across(along_u, normal), angle))
            out[t, c, 3] = sign


@kernel
def mix(key, word):
    """Stir one word into a 64-bit hash."""
    bits = np.uint32(0) if word == NEGATIVE_ZERO else word  # -0 and 0 are one
    return (key ^ (key >> SHIFT) ^ np.uint64(bits)) * MIX


@kernel
def corner_keys(triangles, n, uv, out, key):
    """A hash of position, normal, UV and handedness of each corner, never 0; the floats come as their bits.

    Among three million corners the chance that any two differ and have one hash is 3e-7.
    """
    for t in range(len(triangles)):
        for c in range(3):
            k = np.uint64(triangles[t, c])
            for j in range(3):
                k = mix(k, n[t, c, j])
            k = mix(mix(k, uv[t, c, 0]), uv[t, c, 1])
            key[3 * t + c] = mix(k, out[t, c, 3]) | np.uint64(1)


@kernel
def add_groups(key, weighted, table, table_group, result):
    """Number the distinct keys in result[0] and add up their directions in result[1]; ``table`` is scratch."""
    group, total = result
    mask = np.uint64(len(table) - 1)
    count = 0
    for i in range(len(key)):
        slot = (key[i] >> np.uint64(20)) & mask
        while table[slot] != 0 and table[slot] != key[i]:
            slot = (slot + np.uint64(1)) & mask
        if table[slot] == 0:
            table[slot] = key[i]
            table_group[slot] = count
            count += 1
        group[i] = table_group[slot]
        store3(total, group[i], add(load3(total, group[i]), load3(weighted, i)))


@kernel
def write_tangents(group, total, n, out):
    """Unit sums of the groups; where a group has no direction, any that lies across the normal."""
    for i in range(len(group)):
        tangent = normalize(load3(total, group[i]))
        normal = load3(n, i)
        if dot(tangent, tangent) == 0.0:
            tangent = across((1.0, 0.0, 0.0) if abs(normal[0]) < 0.9 else (0.0, 1.0, 0.0), normal)
        store3(out, i, tangent)
