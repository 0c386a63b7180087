"""Lamps of the evaluated scene in Cycles' units."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..issues import IssueLog
from ..lights.bake import bake_beam
from ..scene.data import Graph, Image, Light
from ..shading.fallback import report_counts
from ..shading.program import compile_graph
from ..shading.registry import REGISTRY

MOST_BOUNCES = 1024  # Cycles' default for a light's own limit, which means no limit


def extract_light(
    ob: Any, matrix: np.ndarray, graph: Graph | None, issues: IssueLog, images: list[Image] | None = None
) -> Light | None:
    """A lamp object at ``matrix`` (local to world, scale included); None when it gives no light, with an issue.

    ``graph`` is the lamp's node tree: its emission multiplies the lamp's strength, as in Cycles, by a map where it
    varies smoothly with direction alone, else at every sample;  ``images``: those that its nodes name.
    """
    data = ob.data
    if _is_portal(data):
        issues.warn(ob.name, "light portals are not supported yet: the portal is ignored")
        return None
    strength = lamp_strength(data)
    if (strength < 0.0).any() or not np.isfinite(strength).all():
        issues.warn(ob.name, "its strength is negative or undefined: it is left out", "use a positive power")
        return None
    light = Light(
        name=ob.name,
        kind=data.type,
        matrix=matrix,
        strength=tuple(float(v) for v in strength),
        normalize=data.normalize,
        cast_shadow=data.use_shadow,
        visible_camera=ob.visible_camera,
    )
    _SHAPES[data.type](light, data)
    if graph is not None:
        _apply_nodes(light, graph, images or [], issues)
    if any(value < 0.0 or not math.isfinite(value) for value in light.strength):
        issues.warn(ob.name, "its nodes give a negative or undefined light: it is left out", "use positive values")
        return None
    _report_unsupported(ob, issues)
    return light


def lamp_strength(data: Any) -> np.ndarray:
    """S = energy 2^exposure colour (times the temperature's colour if on), (3,) linear RGB [W; sun W/m^2]."""
    strength = data.energy * 2.0**data.exposure * np.array(data.color, np.float64)
    if data.use_temperature:
        strength *= np.array(data.temperature_color, np.float64)
    return strength


def _set_ball(light: Light, data: Any) -> None:
    """POINT."""
    light.radius = data.shadow_soft_size
    light.soft_falloff = data.use_soft_falloff


def _set_spot(light: Light, data: Any) -> None:
    """SPOT."""
    _set_ball(light, data)
    light.spot_size = data.spot_size
    light.spot_blend = data.spot_blend


def _set_sun(light: Light, data: Any) -> None:
    """SUN."""
    light.angle = data.angle


def _set_area(light: Light, data: Any) -> None:
    """AREA: the second side counts only for rectangle and ellipse."""
    light.shape = data.shape
    light.size = (data.size, data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size)
    light.spread = min(data.spread, math.pi)


_SHAPES = {"POINT": _set_ball, "SPOT": _set_spot, "SUN": _set_sun, "AREA": _set_area}


def _is_portal(data: Any) -> bool:
    """Whether Cycles would use this area light as a portal."""
    cycles = getattr(data, "cycles", None)
    return data.type == "AREA" and cycles is not None and getattr(cycles, "is_portal", False)


def constant_emission(graph: Graph, name: str, issues: IssueLog) -> tuple[float, float, float] | None:
    """What a lamp's or world's nodes emit, linear RGB, when it is the same everywhere; None when it varies.

    A graph with a node that shading does not know may vary, whatever stands in for that node.
    """
    if graph.surface is None:
        return (0.0, 0.0, 0.0)
    if any(node.type not in REGISTRY for node in graph.nodes):
        return None
    program = compile_graph(graph, name, [], issues)
    return tuple(float(c) for c in program.emission()[0]) if program.constant else None


def _apply_nodes(light: Light, graph: Graph, images: list[Image], issues: IssueLog) -> None:
    """What a lamp's nodes multiply its strength by: a colour, a map of shares by direction, or the nodes themselves."""
    if graph.surface is None:
        what = "the light's nodes are not connected to an output: it is dark"
        issues.warn(light.name, what, "connect an Emission node")
        light.strength = (0.0, 0.0, 0.0)
        return
    report_counts(graph, light.name, issues)
    factor = constant_emission(graph, light.name, issues)
    if factor is None:
        if not all(node.type in REGISTRY for node in graph.nodes):
            compile_graph(graph, light.name, images, issues)  # says what stands in for which node
        beam = bake_beam(light, graph, images)
        if beam is None:
            light.graph = graph
            return
        if (beam == beam[0, 0]).all():
            factor = tuple(float(c) for c in beam[0, 0])
        else:
            factor = (float(beam.max()),) * 3
            light.beam = beam / np.float32(factor[0])
    light.strength = tuple(s * f for s, f in zip(light.strength, factor, strict=True))


def _report_unsupported(ob: Any, issues: IssueLog) -> None:
    """Settings of a lamp that have no effect."""
    hidden = [ray for ray in ("diffuse", "glossy", "transmission") if not getattr(ob, f"visible_{ray}")]
    if hidden:
        issues.warn(ob.name, f"Ray Visibility > {', '.join(hidden)} is not supported: the light shines on all surfaces")
    report_light_linking(ob, issues)
    cycles = getattr(ob.data, "cycles", None)
    if cycles is not None and getattr(cycles, "max_bounces", MOST_BOUNCES) < MOST_BOUNCES:
        issues.warn(ob.name, "a light's own Max Bounces is not supported: Light Paths > Bounces applies")


def report_light_linking(ob: Any, issues: IssueLog) -> None:
    """Say so when an object takes part in light or shadow linking."""
    linking = getattr(ob, "light_linking", None)
    if linking is not None and (linking.receiver_collection or linking.blocker_collection):
        issues.warn(ob.name, "light and shadow linking are not supported yet: the light reaches everything")
