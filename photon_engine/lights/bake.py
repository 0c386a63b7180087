"""Nodes of a lamp that vary smoothly with direction alone, as a map: photometric files above all."""

from __future__ import annotations

import math

import numpy as np

from ..issues import IssueLog
from ..scene.data import BEAM, Graph, Image, Light
from ..shading.points import ShadePoints
from ..shading.program import compile_graph
from ..shading.trail import DEPTH, TRANSPARENT_DEPTH
from .beams import axes_of, local_directions
from .nodes import emission_of, lamp_points, shine_direction

MEANS_NOTHING = {"camera", "bump", "rays"}  # needs that a map cannot answer
SAME = 1e-4  # of the largest value: float32 rounds coordinates that are moved
COARSE = 0.01  # of the largest value: a map is not used where it is farther off than that between its points
STEPS = 5  # every fifth point of the map, each way, is looked at for that
DISTANCES = (0.7, 3.1)  # [m]
TRAILS = (1 << DEPTH, 3 << DEPTH | 2 << TRANSPARENT_DEPTH)  # of paths that sample the lamp, or meet it


def bake_beam(light: Light, graph: Graph, images: list[Image]) -> np.ndarray | None:
    """Emission of a lamp's nodes by direction, BEAM f32; None: it varies otherwise too, or too fast for the map.

    Suns have none: no map is fine enough for their disks.
    """
    program = compile_graph(graph, light.name, images, IssueLog())
    if light.kind == "SUN" or program.needs & MEANS_NOTHING:
        return None
    frame = axes_of(light.matrix)
    d = local_directions(*BEAM[:2]).reshape(-1, 3) @ frame
    first, second = (emission_of(program, _somewhere(light, d, k)) for k in (0, 1))
    largest = float(np.abs(first).max())
    if np.abs(first - second).max() > SAME * max(largest, 1e-30):
        return None
    beam = first.reshape(BEAM)
    between, shown = _between(beam)
    d = between.reshape(-1, 3) @ frame
    lit = np.ones(len(d), bool) if light.kind == "POINT" else d @ shine_direction(light) > 0.0
    exact = emission_of(program, _somewhere(light, d, 0))
    return beam if np.abs(exact - shown)[lit].max() <= COARSE * max(largest, 1e-30) else None


def _between(beam: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Local directions (h, w, 3) in the middle of four points of the map, some of all, and what it shows there."""
    height, width = BEAM[:2]
    rows, columns = np.arange(0, height - 1, STEPS), np.arange(0, width, STEPS)
    theta = ((rows + 0.5) * math.pi / (height - 1))[:, None]
    phi = (columns + 0.5) * 2.0 * math.pi / width
    sine = np.sin(theta)
    d = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta) + 0.0 * phi], axis=-1)
    around = [beam[rows + i][:, (columns + j) % width] for i in (0, 1) for j in (0, 1)]
    return d, np.mean(around, axis=0).reshape(-1, 3)


def _somewhere(light: Light, d: np.ndarray, k: int) -> ShadePoints:
    """What the nodes see of light along d (n, 3) from one of two places on the lamp, distances and pasts."""
    matrix = np.asarray(light.matrix, np.float64)
    place, normal = np.broadcast_to(matrix[:3, 3], d.shape), d
    if light.kind == "AREA":
        normal = np.broadcast_to(shine_direction(light), d.shape)
        place = place + (0.31 * matrix[:3, 0] * light.size[0] - 0.17 * matrix[:3, 1] * light.size[-1]) * k
    elif light.radius > 0.0:
        side = np.cross(d, np.eye(3)[np.argmin(np.abs(d), axis=1)])
        side *= 0.6 * k / np.linalg.norm(side, axis=1, keepdims=True)
        if not light.soft_falloff:
            normal = (d + side) / np.linalg.norm(d + side, axis=1, keepdims=True)
            side = normal
        place = place + light.radius * side
    distance, trail = np.full(len(d), DISTANCES[k]), np.full(len(d), TRAILS[k])
    return lamp_points(light, place, normal, d, distance, trail)
