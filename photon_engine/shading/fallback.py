"""Nodes and settings that are not supported yet: said once, and something plain in their place."""

from __future__ import annotations

import numpy as np

from ..bsdf import recipes
from ..issues import IssueLog
from ..scene.data import Graph, Node
from .ies import MISSING, parse_ies
from .nodes.light_path import LIGHT_PATH_COUNTS
from .registry import REGISTRY, SCALARS, NodeKind, f32

GREY = 0.8  # Blender's default base colour
MIDDLE = 0.5  # of an unknown texture
COLOR_INPUTS = ("Base Color", "Color")
# nodes that are known and left out, with the reason
NOT_SUPPORTED = {
    "ShaderNodeBsdfHair": "hair is not supported yet",
    "ShaderNodeBsdfHairPrincipled": "hair is not supported yet",
    "ShaderNodeBsdfRayPortal": "portals are not supported yet",
    "ShaderNodeVolumeInfo": "volume grids are not supported yet",
    "ShaderNodeTexPointDensity": "of Blender 4.5; Cycles' own point density is not supported",
    "ShaderNodeOutputAOV": "shader AOVs are not supported yet",
    "ShaderNodeScript": "OSL is not supported",
    "ShaderNodeEeveeSpecular": "EEVEE only",
    "ShaderNodeShaderToRGB": "EEVEE only",
    "ShaderNodeSqueeze": "Freestyle only",
    "ShaderNodeOutputLineStyle": "Freestyle only",
    "ShaderNodeUVAlongStroke": "Freestyle only",
}
# on surfaces and in the world it is Quadratic
LAMP_OUTPUTS = {
    "ShaderNodeLightFalloff": {"Linear", "Constant"},
}
RAYCAST_OUTPUTS = {"Is Hit", "Self Hit", "Hit Distance", "Hit Position", "Hit Normal"}


def report_unsupported(item: Node, used: set[str], material: str, issues: IssueLog) -> None:
    """Warn, once by material and node, about what will look different."""
    where = f"{material} > {item.name}"
    if item.type not in REGISTRY:
        issues.warn(where, f"the node type {item.type} is not supported yet", _replacement(item))
        return
    if item.type == "ShaderNodeRaycast" and used - RAYCAST_OUTPUTS:
        issues.warn(where, "attributes where its ray hits are not supported yet", "they are 0")
    if item.type == "ShaderNodeTexIES" and (problem := ies_problem(item.props.get("text", ""))):
        issues.warn(where, f"the photometric file cannot be read: {problem}", f"{MISSING:g} is used, as Cycles does")
    if scatters_by_profile(item):
        issues.warn(
            where, "Christensen-Burley subsurface scattering is not supported",
            "Random Walk (Legacy) of the same radius is used",
        )  # fmt: skip


def scatters_by_profile(item: Node) -> bool:
    """Whether a node may scatter below its surface by Christensen's and Burley's profile."""
    if item.type == "ShaderNodeSubsurfaceScattering":
        return item.props.get("falloff") == "BURLEY"
    deep, wall = item.inputs.get("Subsurface Weight"), item.inputs.get("Thin Wall")
    if deep is None or item.props.get("subsurface_method") != "BURLEY":
        return False
    if wall is not None and wall.node < 0 and wall.value:
        return False  # a thin wall scatters diffusely on both sides
    return deep.node >= 0 or bool(deep.value)


def used_outputs(graph: Graph) -> list[set[str]]:
    """Which outputs of each node something reads."""
    used: list[set[str]] = [set() for _ in graph.nodes]
    sockets = [socket for item in graph.nodes for socket in item.inputs.values()]
    for socket in [*sockets, *(end for end in (graph.surface, graph.volume, graph.displacement) if end is not None)]:
        if socket.node >= 0:
            used[socket.node].add(socket.output)
    return used


def report_falloff(graph: Graph, material: str, issues: IssueLog) -> None:
    """Warn, once by material and node, about what lamps alone can compute."""
    for item, used in zip(graph.nodes, used_outputs(graph), strict=True):
        where = f"{material} > {item.name}"
        for output in sorted(LAMP_OUTPUTS.get(item.type, set()) & used):
            issues.warn(where, f"the output {output} is supported of lamps only", "Quadratic is used instead")
        smooth = item.inputs.get("Smooth") if item.type == "ShaderNodeLightFalloff" and used else None
        if smooth is not None and (smooth.node >= 0 or smooth.value):
            issues.warn(where, "Smooth is supported of lamps only", "it has no effect")


def report_counts(graph: Graph, name: str, issues: IssueLog) -> None:
    """Warn, once by node, about bounces that are asked for where not only eye paths see what glows."""
    for item, used in zip(graph.nodes, used_outputs(graph), strict=True):
        counts = sorted(used & LIGHT_PATH_COUNTS.keys()) if item.type == "ShaderNodeLightPath" else []
        if counts:
            text = f"{', '.join(counts)}: bounces are not counted where light is sampled, nor by photons"
            issues.warn(f"{name} > {item.name}", text, "Ray Depth is 1 there, other counts are 0")


def ies_problem(text: str) -> str:
    """Why an IES Texture's text cannot be used; empty: it can."""
    if not text:
        return "there is none"
    try:
        parse_ies(text)
    except ValueError as error:
        return str(error)
    return ""


def _replacement(item: Node) -> str:
    """What stands in for an unknown node."""
    if "SHADER" in item.output_kinds.values():
        name = next((name for name in COLOR_INPUTS if name in item.inputs), None)
        return f"a diffuse surface of its {name} is used" if name else f"a grey diffuse surface of {GREY} is used"
    return f"its outputs are {MIDDLE}, vectors 0"


def fallback_kind(item: Node) -> NodeKind:
    """A node kind for an unknown type: a diffuse of its colour, or middle values."""

    def function(x, props, points):
        if "SHADER" not in item.output_kinds.values():
            return {name: _middle(kind) for name, kind in item.output_kinds.items()}
        color = next((x[name] for name in COLOR_INPUTS if x.get(name) is not None), np.full((1, 3), GREY, f32))
        lobes = recipes.diffuse(color, np.zeros(1, f32), None)
        return {name: lobes for name, kind in item.output_kinds.items() if kind == "SHADER"}

    return NodeKind(function, lambda node, used: False, lambda node, used: set())


def _middle(kind: str):
    """The value of an unknown texture's output."""
    if kind in SCALARS:
        return np.full(1, MIDDLE, f32)
    return np.full((3, 1), 0.0 if kind == "VECTOR" else MIDDLE, f32)
