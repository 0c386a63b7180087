"""The world: light from infinity."""

from __future__ import annotations

from typing import Any

from ..issues import IssueLog
from ..scene.data import Graph, World
from .lights import constant_emission


def extract_world(world: Any | None, graph: Graph | None, issues: IssueLog) -> World:
    """The world's graph, and its constant radiance: black for a graph that varies, which is evaluated by direction."""
    if world is None or graph is None:
        return World()
    _report_unsupported(world, graph, issues)
    color = constant_emission(graph, world.name, issues)
    return World(name=world.name, graph=graph, color=(0.0, 0.0, 0.0) if color is None else color)


def _report_unsupported(world: Any, graph: Graph, issues: IssueLog) -> None:
    """Settings of the world that have no effect."""
    if graph.volume is not None:
        issues.warn(world.name, "world volumes are not supported yet: the air is clear")
    visibility = getattr(world, "cycles_visibility", None)
    hidden = [
        ray for ray in ("camera", "diffuse", "glossy", "transmission")
        if visibility is not None and not getattr(visibility, ray, True)
    ]  # fmt: skip
    if hidden:
        issues.warn(world.name, f"Ray Visibility > {', '.join(hidden)} is not supported: the world is seen by all rays")
