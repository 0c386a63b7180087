"""The world: light from infinity."""

from __future__ import annotations

from typing import Any

from ..issues import IssueLog
from ..scene.data import Graph, World
from ..shading.fallback import report_counts
from .lights import MOST_BOUNCES, constant_emission
from .visibility import dark


def extract_world(world: Any | None, graph: Graph | None, issues: IssueLog) -> World:
    """The world's graph, and its constant radiance: black for a graph that varies, which is evaluated by direction."""
    if world is None or graph is None:
        return World()
    _report_unsupported(world, graph, issues)
    report_counts(graph, world.name, issues)
    if not _sees(world, "camera"):
        graph = dark(graph, ("camera",))
    color = constant_emission(graph, world.name, issues)
    return World(name=world.name, graph=graph, color=(0.0, 0.0, 0.0) if color is None else color)


def _report_unsupported(world: Any, graph: Graph, issues: IssueLog) -> None:
    """Settings of the world that have no effect."""
    if graph.volume is not None:
        issues.warn(world.name, "world volumes are not supported yet: the air is clear")
    hidden = [ray for ray in ("diffuse", "glossy", "transmission") if not _sees(world, ray)]
    if hidden:
        issues.warn(world.name, f"Ray Visibility > {', '.join(hidden)} is not supported: such rays see the world")
    cycles = getattr(world, "cycles", None)
    if cycles is not None and getattr(cycles, "max_bounces", MOST_BOUNCES) < MOST_BOUNCES:
        issues.warn(world.name, "the world's own Max Bounces is not supported: Light Paths > Bounces applies")


def _sees(world: Any, ray: str) -> bool:
    """Ray Visibility of the world, a setting of Cycles."""
    return getattr(getattr(world, "cycles_visibility", None), ray, True)
