"""The world: light from infinity."""

from __future__ import annotations

from typing import Any

from ..issues import IssueLog
from ..scene.data import Graph, World
from .lights import constant_emission


def extract_world(world: Any | None, graph: Graph | None, issues: IssueLog) -> World:
    """The world's constant radiance; a graph that varies is kept, reported, and its unlinked Background used."""
    if world is None or graph is None:
        return World()
    _report_unsupported(world, graph, issues)
    color = constant_emission(graph, world.name, issues)
    if color is None:
        color = fallback_color(graph)
        shown = ", ".join(f"{c:.3g}" for c in color)
        issues.warn(world.name, "world nodes that vary are not supported yet",
                    f"the constant colour ({shown}) is used instead")  # fmt: skip
    return World(name=world.name, graph=graph, color=color)


def fallback_color(graph: Graph) -> tuple[float, float, float]:
    """Radiance of the first Background that is reached, its linked inputs replaced by the values under the links."""
    for node in reversed(graph.nodes):
        if node.type not in ("ShaderNodeEmission", "ShaderNodeBackground"):
            continue
        color, strength = node.inputs["Color"].value, node.inputs["Strength"].value
        if color is not None and strength is not None:
            return tuple(float(c) * float(strength) for c in color[:3])
    return (0.0, 0.0, 0.0)


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
