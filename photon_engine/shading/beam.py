"""What a lamp's nodes make of its light by direction, as a map: photometric files above all."""

from __future__ import annotations

import numpy as np

from ..issues import IssueLog
from ..scene.data import Graph, Image
from .points import ObjectTable, ShadePoints, sky_points
from .program import Program, compile_graph

MEANS_NOTHING = {"trail", "bump"}  # needs that a map cannot answer
SAME = 1e-4  # of the largest value: float32 rounds coordinates that are moved


def bake_beam(
    graph: Graph, name: str, kind: str, matrix: np.ndarray, images: list[Image], directions: np.ndarray
) -> np.ndarray | None:
    """Emission (n, 3) f32 of a lamp's nodes along unit directions (n, 3) in the world; None: it varies otherwise too.

    kind : of the lamp: an area lamp has a normal of its own, others face whoever looks;  matrix (4, 4) : lamp to world
    """
    program = compile_graph(graph, name, images, IssueLog())
    by_distance = any(program.calls[index].node.type == "ShaderNodeLightFalloff" for index in program.live)
    if by_distance or program.needs & MEANS_NOTHING:
        return None
    values = [_emission(program, lamp_points(directions, kind, matrix, shift)) for shift in (0.0, 0.37)]
    close = np.abs(values[0] - values[1]).max() <= SAME * max(float(np.abs(values[0]).max()), 1e-30)
    return values[0] if close and np.isfinite(values[0]).all() else None


def _emission(program: Program, points: ShadePoints) -> np.ndarray:
    """Emission not below 0, (n, 3) f32."""
    return np.maximum(np.broadcast_to(program.emission(points), points.p.shape), 0.0).astype(np.float32)


def lamp_points(directions: np.ndarray, kind: str, matrix: np.ndarray, shift: float) -> ShadePoints:
    """What a lamp's nodes see; `shift` moves all that is not a direction, to find out whether it matters."""
    d = np.ascontiguousarray(directions, np.float32)
    linear = np.asarray(matrix, np.float64)[:3, :3]
    inverse = np.linalg.pinv(linear)
    n = np.broadcast_to((-linear[:, 2] / max(np.linalg.norm(linear[:, 2]), 1e-30)).astype(np.float32), d.shape)
    n = n if kind == "AREA" else d
    local = n @ linear
    points = sky_points(d)
    moved = np.full(d.shape, shift, np.float32)
    place = np.asarray(matrix, np.float32)[:3, 3]
    points.p, points.ng, points.ns, points.wo = place + moved, n, n, d
    points.generated, points.object = moved, moved
    points.corners = np.full((len(d), 3, 3), shift, np.float32)
    points.parametric, points.uvs = moved[:, :2], type(points.uvs)(moved[:, :2])
    points.normal_local = (local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-30)).astype(np.float32)
    points.objects = ObjectTable(
        linear[None].astype(np.float32), inverse[None].astype(np.float32), place[None], np.ones((1, 4), np.float32),
        np.zeros(1, np.float32), np.zeros(1, np.float32),
    )  # fmt: skip
    return points
