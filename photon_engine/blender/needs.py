"""Which mesh data a material's graph reads."""

from __future__ import annotations

from collections.abc import Iterable

from ..scene.data import Graph, Node
from .meshes import MeshNeeds

# textures that look things up by UV or direction when no vector is linked; all others use Generated
NOT_GENERATED = ("ShaderNodeTexImage", "ShaderNodeTexEnvironment", "ShaderNodeTexCoord", "ShaderNodeTexSky")


def merge_needs(needs: Iterable[MeshNeeds]) -> MeshNeeds:
    """All that any of the materials needs."""
    out = MeshNeeds()
    for item in needs:
        out = MeshNeeds(
            out.generated or item.generated, out.attributes | item.attributes, out.tangents | item.tangents
        )
    return out


def needs_of(graph: Graph) -> MeshNeeds:
    """What the graph reads of a mesh beyond positions, normals and UVs."""
    read = {(socket.node, socket.output) for node in graph.nodes for socket in node.inputs.values() if socket.node >= 0}
    return merge_needs(_needs_of_node(node, i, read) for i, node in enumerate(graph.nodes))


def _needs_of_node(node: Node, index: int, read: set[tuple[int, str]]) -> MeshNeeds:
    """What one node reads; ``read`` holds the outputs that something is linked to."""
    props = node.props
    if node.type == "ShaderNodeTexCoord":
        return MeshNeeds(generated=(index, "Generated") in read)
    if node.type.startswith("ShaderNodeTex") and node.type not in NOT_GENERATED:
        vector = node.inputs.get("Vector")
        return MeshNeeds(generated=vector is not None and vector.node < 0)
    if node.type == "ShaderNodeNormalMap" and props.get("space", "TANGENT") == "TANGENT":
        return MeshNeeds(tangents=frozenset({props.get("uv_map", "")}))
    if node.type == "ShaderNodeTangent":
        if props.get("direction_type") == "UV_MAP":
            return MeshNeeds(tangents=frozenset({props.get("uv_map", "")}))
        return MeshNeeds(generated=True)
    if node.type == "ShaderNodeAttribute" and props.get("attribute_type", "GEOMETRY") == "GEOMETRY":
        return MeshNeeds(attributes=frozenset({props.get("attribute_name", "")}) - {""})
    if node.type == "ShaderNodeVertexColor":
        return MeshNeeds(attributes=frozenset({props.get("layer_name", "")}))
    return MeshNeeds()
