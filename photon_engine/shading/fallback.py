"""Nodes and settings that are not supported yet: said once, and something plain in their place."""

from __future__ import annotations

import numpy as np

from ..bsdf import recipes
from ..issues import IssueLog
from ..scene.data import Graph, Node
from .ies import MISSING, parse_ies
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
# on surfaces; lamps have them
UNSUPPORTED_OUTPUTS = {
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


def report_surface_outputs(graph: Graph, material: str, issues: IssueLog) -> None:
    """Warn, once by material and node, about outputs that lamps alone can compute."""
    used = {(socket.node, socket.output) for item in graph.nodes for socket in item.inputs.values()}
    for index, item in enumerate(graph.nodes):
        for output in sorted(UNSUPPORTED_OUTPUTS.get(item.type, ())):
            if (index, output) in used:
                where = f"{material} > {item.name}"
                issues.warn(where, f"the output {output} is supported of lamps only", "Quadratic is used instead")


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
