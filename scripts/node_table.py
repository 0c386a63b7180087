"""Write docs/nodes.md: every shader node of Blender, supported or not. Run it with Blender 5.2's Python."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import bpy  # noqa: E402

import photon_engine.shading.material  # noqa: E402, F401  (fills the registry)
from photon_engine.blender.compat import RESOLVED_NODES  # noqa: E402
from photon_engine.shading.fallback import LAMP_OUTPUTS, NOT_SUPPORTED  # noqa: E402
from photon_engine.shading.registry import REGISTRY  # noqa: E402

# part of every tree: resolved before shading
STRUCTURE = {
    "NodeFrame": "drawing only", "NodeGroupInput": "groups are resolved", "NodeGroupOutput": "groups are resolved",
    "NodeReroute": "resolved", "ShaderNodeGroup": "groups are resolved, nested ones too",
    "ShaderNodeOutputMaterial": "surface, volume and displacement", "ShaderNodeOutputWorld": "surface",
    "ShaderNodeOutputLight": "surface",
}  # fmt: skip
RESOLVED = "by Blender: zones unrolled, closures and bundles put in place, constants folded"
STRUCTURE |= dict.fromkeys(sorted(RESOLVED_NODES), RESOLVED)
ABSTRACT = {"Node", "NodeInternal", "ShaderNode", "ShaderNodeCustomGroup", "NodeCustomGroup"}
# of Blender 4.5 alone
OLD_ONLY = {
    "ShaderNodeTexPointDensity", "ShaderNodeCombineHSV", "ShaderNodeCombineRGB", "ShaderNodeSeparateHSV",
    "ShaderNodeSeparateRGB",
}  # fmt: skip
# what a supported node does otherwise; renders report it too
PARTLY = {
    "ShaderNodeAmbientOcclusion": "all objects occlude, also those that cast no shadows",
    "ShaderNodeRaycast": "no attributes of what it hits",
    "ShaderNodeBevel": "after a diffuse bounce the surface's own normal",
    "ShaderNodeBsdfPrincipled": "subsurface: Christensen-Burley as Random Walk (Legacy)",
    "ShaderNodeSubsurfaceScattering": "Christensen-Burley as Random Walk (Legacy)",
    "ShaderNodeLightPath": "where light is sampled, and by photons, no bounces are counted",
    "ShaderNodeVolumeScatter": "only what it absorbs",
    "ShaderNodeVolumePrincipled": "only what it absorbs",
    "ShaderNodeVolumeCoefficients": "only what it absorbs",
}


def node_types() -> list[str]:
    """Types of nodes that this Blender lets into a shader tree."""
    material = bpy.data.materials.new("Node types")
    material.use_nodes = True
    nodes, found = material.node_tree.nodes, []
    for name in dir(bpy.types):
        kind = getattr(bpy.types, name)
        if not (isinstance(kind, type) and issubclass(kind, bpy.types.Node)) or name in ABSTRACT:
            continue
        try:
            nodes.new(name)
        except RuntimeError:
            continue
        found.append(name)
    bpy.data.materials.remove(material)
    return sorted(found)


def status(name: str) -> tuple[str, str]:
    """Whether a type is supported, and a remark."""
    if name in STRUCTURE:
        return "yes", STRUCTURE[name]
    if name not in REGISTRY:
        return "no", NOT_SUPPORTED.get(name, "")
    remarks = [PARTLY[name]] if name in PARTLY else []
    if outputs := LAMP_OUTPUTS.get(name):
        remarks.append(f"of lamps only: {', '.join(sorted(outputs))}")
    return "yes", "; ".join(remarks)


def table() -> str:
    """The page."""
    lines = [
        "# Shader nodes",
        "",
        "Made by `scripts/node_table.py` from Blender's own list. A node that is not supported is named in the",
        "messages of a render, with what stands in its place.",
        "",
        "| node | type | supported | remark |",
        "| --- | --- | --- | --- |",
    ]
    for name in sorted({*node_types(), *OLD_ONLY}):
        known = getattr(bpy.types, name, None)
        label = known.bl_rna.name if known is not None else name.removeprefix("ShaderNode")
        lines.append(f"| {label} | `{name}` | {' | '.join(status(name))} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (ROOT / "docs" / "nodes.md").write_text(table())
