"""Surfaces in one place, of which at least one refracts: water that fills a glass to its wall, a block on a table.

A ray that meets one of two coincident triangles starts anew beyond both and never meets the other: it would leave a
water that it never entered, or fall through the table. So refracting bodies that touch something are grown by a hair,
a few times the offset of a ray's origin (8 micrometres in a scene of 1 m): every ray then meets both surfaces, always
in the same order, and refracts in the end as at the common surface [Snell's law through parallel layers].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .flatten import Flattened, Geometry
from .islands import island_roots
from .surface import RELATIVE_OFFSET

STEPS = 4.0  # by how many offsets of a ray's origin a body grows
NORMAL_GRID = 1e-4  # normals of one plane agree to this
MOST_STRETCH = 4.0  # of a corner's way over that of its faces
LOOK = np.array([0.3642, 0.4913, 0.7913])  # no face of a made object is at right angles to it


class Faces(NamedTuple):
    """What is asked of triangles."""

    body: np.ndarray  # (T,) i64, connected part of an instance
    normal: np.ndarray  # (T, 3) f64, unit; zero for a triangle without area
    low: np.ndarray  # (T, 3) f64, box
    high: np.ndarray  # (T, 3) f64
    corner: np.ndarray  # (T, 3) f64, one of its corners


def spread_touching(flat: Flattened, refracts: np.ndarray) -> Flattened:
    """The same triangles, bodies that refract and touch others grown by a hair; refracts : (T,) bool."""
    geometry = flat.geometry
    if not refracts.any():
        return flat
    bodies = bodies_of(geometry)
    faces = _faces(geometry, bodies[geometry.triangles[:, 0]])
    away = np.abs(faces.corner).max(axis=1)  # far things have long steps, near ones must not
    reach = 0.5 * (faces.high - faces.low).max(axis=1)
    same_plane = RELATIVE_OFFSET * max(float(np.median(away[refracts])), 0.125 * float(reach.max()))
    near = _neighbours(touching_pairs(faces, refracts, same_plane))
    levels = _levels(near, set(faces.body[refracts].tolist()))
    if not levels:
        return flat
    positions = geometry.positions.copy()
    order = np.argsort(faces.body, kind="stable")
    runs = {body: order[slice(*np.searchsorted(faces.body, [body, body + 1], sorter=order))] for body in near}
    for body, level in levels.items():
        mine = runs[body]
        corners = geometry.triangles[mine]
        widest = max(float(reach[runs[other]].max()) for other in (body, *near[body]))  # rays leave either
        step = RELATIVE_OFFSET * max(float(away[mine].max()), 0.125 * widest)
        vertices, local = np.unique(corners, return_inverse=True)
        way = outward(local.reshape(-1, 3), faces.normal[mine], len(vertices))
        positions[vertices] = (positions[vertices] + level * STEPS * step * way).astype(np.float32)
    return Flattened(**{**vars(flat), "geometry": geometry._replace(positions=positions)})


def bodies_of(geometry: Geometry) -> np.ndarray:
    """Number of the connected body that each vertex belongs to, (V,) i64."""
    t = geometry.triangles
    return island_roots(len(geometry.positions), np.concatenate([t[:, :2], t[:, 1:]]))


def _faces(geometry: Geometry, body: np.ndarray) -> Faces:
    """Normals and boxes of all triangles."""
    corner = geometry.positions[geometry.triangles].astype(np.float64)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    return Faces(body, normal / np.where(size > 0.0, size, 1.0), corner.min(axis=1), corner.max(axis=1), corner[:, 0])


def touching_pairs(faces: Faces, refracts: np.ndarray, step: float) -> set[tuple[int, int]]:
    """Pairs of bodies with faces in one plane whose boxes meet there, at least one of the two faces refracting.

    step : distance [m] within which planes are one;  a pair too many does no harm.
    """
    normal = faces.normal * np.where(faces.normal @ LOOK < 0.0, -1.0, 1.0)[:, None]
    distance = (normal * faces.corner).sum(axis=1)
    pairs: set[tuple[int, int]] = set()
    coarse = np.rint(normal / NORMAL_GRID).astype(np.int64)
    for shift in (0.0, 0.5):  # planes on each side of a grid line are together on the other grid
        key = _hash(coarse, np.floor(distance / (2.0 * step) + shift).astype(np.int64))
        index, plane = _shared_planes(key, faces.body)
        some = Faces(*(field[index] for field in faces))
        pairs |= _pairs_in_planes(some, refracts[index], plane, step)
    return pairs


def _shared_planes(key: np.ndarray, body: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles (n,) in planes of several bodies, and for each the number of its plane; by the planes' keys."""
    order = np.argsort(key)
    sorted_key, sorted_body = key[order], body[order]
    mixed = (sorted_key[1:] == sorted_key[:-1]) & (sorted_body[1:] != sorted_body[:-1])
    index = order[np.isin(sorted_key, sorted_key[1:][mixed])] if mixed.any() else order[:0]
    return index, np.unique(key[index], return_inverse=True)[1]


def _hash(normal: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """One number for a plane's four; a clash makes a pair too many."""
    key = distance * np.int64(0x1D8AF066D3F6E7A5)
    for k, factor in enumerate((0x2545F4914F6CDD1D, 0x369DEA0F31A53F85, 0x27BB2EE687B0B0FD)):
        key = (key ^ (key >> 29)) + normal[:, k] * np.int64(factor)
    return key


def _pairs_in_planes(faces: Faces, refracts: np.ndarray, plane: np.ndarray, step: float) -> set[tuple[int, int]]:
    """`touching_pairs` when the plane (T,) of each face is known."""
    if len(plane) == 0:
        return set()
    refracting = np.zeros(plane.max() + 1, bool)
    refracting[plane[refracts]] = True
    index = np.flatnonzero(refracting[plane] & faces.normal.any(axis=1))
    order = index[np.lexsort((faces.body[index], plane[index]))]
    if len(order) == 0:
        return set()
    first = np.flatnonzero(np.diff(plane[order], prepend=-1) | np.diff(faces.body[order], prepend=-1))
    low, high = np.minimum.reduceat(faces.low[order], first), np.maximum.reduceat(faces.high[order], first)
    clear = np.logical_or.reduceat(refracts[order], first)
    of_plane, of_body = plane[order][first], faces.body[order][first]
    found: set[tuple[int, int]] = set()
    for begin, end in _runs(of_plane):
        for i in range(begin, end):
            meets = ((low[i] <= high[i + 1 : end] + step) & (high[i] >= low[i + 1 : end] - step)).all(axis=1)
            for j in i + 1 + np.flatnonzero(meets & (clear[i] | clear[i + 1 : end])):
                found.add((int(of_body[i]), int(of_body[j])))
    return found


def _runs(values: np.ndarray) -> list[tuple[int, int]]:
    """Spans of equal neighbours of at least two."""
    edges = np.flatnonzero(np.diff(values)) + 1
    starts, ends = np.concatenate([[0], edges]), np.concatenate([edges, [len(values)]])
    several = ends - starts > 1
    return list(zip(starts[several].tolist(), ends[several].tolist(), strict=True))


def _neighbours(pairs: set[tuple[int, int]]) -> dict[int, set[int]]:
    """Which bodies each body touches."""
    near: dict[int, set[int]] = {}
    for a, b in pairs:
        near.setdefault(a, set()).add(b)
        near.setdefault(b, set()).add(a)
    return near


def _levels(near: dict[int, set[int]], refracting: set[int]) -> dict[int, int]:
    """How many hairs each body grows: refracting ones differ from all they touch, the others stay as they are."""
    levels: dict[int, int] = dict.fromkeys(near.keys() - refracting, 0)
    for body in sorted(near.keys() & refracting):
        taken = {levels[other] for other in near[body] if other in levels}
        levels[body] = next(level for level in range(len(taken) + 1) if level not in taken)
    return {body: level for body, level in levels.items() if level}


def outward(triangles: np.ndarray, normals: np.ndarray, count: int) -> np.ndarray:
    """For each vertex the way (count, 3) that moves its faces outward by about 1 each.

    triangles : (T, 3) indices;  normals : (T, 3), unit. A corner of a box goes along its diagonal, by its length.
    """
    total, way = np.zeros((count, 3)), np.zeros((count, 3))
    distinct = np.unique(np.column_stack([np.repeat(np.rint(normals / NORMAL_GRID), 3, axis=0), triangles.ravel()]),
                         axis=0)  # fmt: skip
    of_vertex, unit = distinct[:, 3].astype(np.intp), distinct[:, :3] * NORMAL_GRID
    np.add.at(total, of_vertex, unit)  # each direction once, however many triangles have it
    size = np.linalg.norm(total, axis=1, keepdims=True)
    mean = total / np.where(size > 0.0, size, 1.0)
    least = np.ones(count)
    np.minimum.at(least, of_vertex, (mean[of_vertex] * unit).sum(axis=1))
    way[:] = mean / np.maximum(least, 1.0 / MOST_STRETCH)[:, None]
    return way
