"""Lamps of the evaluated scene in Cycles' units."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..issues import IssueLog
from ..lights.beams import axes_of, local_directions
from ..scene.data import BEAM, Graph, Image, Light
from ..shading.beam import bake_beam
from ..shading.program import compile_graph
from ..shading.registry import REGISTRY

WHITE = (1.0, 1.0, 1.0)
MOST_BOUNCES = 1024  # Cycles' default for a light's own limit, which means no limit


def extract_light(
    ob: Any, matrix: np.ndarray, graph: Graph | None, issues: IssueLog, images: list[Image] | None = None
) -> Light | None:
    """A lamp object at ``matrix`` (local to world, scale included); None when it gives no light, with an issue.

    ``graph`` is the lamp's node tree: its emission multiplies the lamp's strength, as in Cycles, by a map where it
    varies with direction;  ``images``: those that its nodes name.
    """
    data = ob.data
    if _is_portal(data):
        issues.warn(ob.name, "light portals are not supported yet: the portal is ignored")
        return None
    factor, beam = _tree_factor(ob, matrix, graph, images or [], issues)
    strength = lamp_strength(data) * np.array(factor)
    if (strength < 0.0).any() or not np.isfinite(strength).all():
        issues.warn(ob.name, "its strength is negative or undefined: it is left out", "use a positive power")
        return None
    light = Light(
        name=ob.name,
        kind=data.type,
        matrix=matrix,
        strength=tuple(float(v) for v in strength),
        normalize=data.normalize,
        beam=beam,
        cast_shadow=data.use_shadow,
        visible_camera=ob.visible_camera,
    )
    _SHAPES[data.type](light, data)
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


def _tree_factor(
    ob: Any, matrix: np.ndarray, graph: Graph | None, images: list[Image], issues: IssueLog
) -> tuple[tuple[float, float, float], np.ndarray | None]:
    """What a lamp's nodes multiply its strength by: a colour, and a map of shares where that varies with direction."""
    if graph is None:
        return WHITE, None
    if graph.surface is None:
        issues.warn(ob.name, "the light's nodes are not connected to an output: it is dark", "connect an Emission node")
        return (0.0, 0.0, 0.0), None
    factor = constant_emission(graph, ob.name, issues)
    if factor is not None:
        return factor, None
    beam, local = None, local_directions(*BEAM[:2])
    if all(node.type in REGISTRY for node in graph.nodes):
        beam = bake_beam(graph, ob.name, ob.data.type, matrix, images, local.reshape(-1, 3) @ axes_of(matrix))
    if beam is None:
        text = "light nodes that vary otherwise than with direction are not supported yet: they are ignored"
        issues.warn(ob.name, text)
        return WHITE, None
    most = float(beam.max())
    if most <= 0.0:
        return (0.0, 0.0, 0.0), None
    return (most, most, most), (beam / np.float32(most)).reshape(*local.shape)


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
