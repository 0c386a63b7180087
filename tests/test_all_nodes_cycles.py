"""Every node that Blender knows: supported, or listed with the reason; supported ones agree with Cycles.

Cases come from Blender's own definitions: each choice of each setting, and a varying link to each input.
"""

from __future__ import annotations

from pathlib import Path

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from photon_engine.shading.fallback import LAMP_OUTPUTS, NOT_SUPPORTED  # noqa: E402
from photon_engine.shading.registry import REGISTRY  # noqa: E402
from scripts.node_table import STRUCTURE, node_types, table  # noqa: E402
from tests.node_patch import SIZE, TOLERANCE, Patch, feed, new, ramp  # noqa: E402

NODES = Path(__file__).parent.parent / "docs" / "nodes.md"
LINKED = ("VECTOR", "RGBA", "VALUE")
# what reads the mesh or the object goes through the whole engine
ENGINE = {
    "ShaderNodeAttribute", "ShaderNodeCameraData", "ShaderNodeHairInfo", "ShaderNodeLightPath",
    "ShaderNodeNewGeometry", "ShaderNodeNormalMap",
    "ShaderNodeObjectInfo", "ShaderNodeParticleInfo", "ShaderNodePointInfo", "ShaderNodeTangent", "ShaderNodeTexCoord",
    "ShaderNodeUVMap", "ShaderNodeVectorTransform", "ShaderNodeVertexColor", "ShaderNodeWireframe",
}
# their own tests: of a surface, a lamp, rays, and of hashes that no neighbouring float shares
ELSEWHERE = {
    "ShaderNodeAmbientOcclusion", "ShaderNodeBevel", "ShaderNodeRaycast",
    "ShaderNodeBump", "ShaderNodeDisplacement", "ShaderNodeLightFalloff", "ShaderNodeTexWhiteNoise",
    "ShaderNodeVectorDisplacement",
}


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


def test_every_node_is_known():
    unknown = [name for name in node_types() if name not in REGISTRY and name not in NOT_SUPPORTED | STRUCTURE]
    assert not unknown, f"Blender has nodes that we neither support nor list: {unknown}"
    assert not set(REGISTRY) & set(NOT_SUPPORTED)


def test_table_is_current():
    """The table is made from Blender 5.2; 4.5's nodes are all in it."""
    text = NODES.read_text()
    if bpy.app.version >= (5, 2, 0):
        assert text == table(), "run scripts/node_table.py"
    assert all(f"`{name}`" in text for name in node_types())


def supported() -> list[str]:
    """Types that give values rather than shaders."""
    tree = bpy.data.materials.new("Types")
    tree.use_nodes = True
    out = []
    for name in node_types():
        if name in REGISTRY and name not in ELSEWHERE:
            node = tree.node_tree.nodes.new(name)
            if node.outputs and all(socket.type in LINKED for socket in node.outputs):
                out.append(name)
    return out


def variants(kind: str) -> list[tuple[str, str]]:
    """(setting, choice) of every choice of every setting, and (input, "") of every input."""
    cases = []
    base = {item.identifier for item in bpy.types.ShaderNode.bl_rna.properties}
    for item in getattr(bpy.types, kind).bl_rna.properties:
        if item.type == "ENUM" and item.identifier not in base and not item.is_readonly:
            cases += [(item.identifier, choice.identifier) for choice in item.enum_items]
    tree = bpy.data.materials.new("Inputs")
    tree.use_nodes = True
    node = tree.node_tree.nodes.new(kind)
    sockets = [s.identifier for s in node.inputs if s.type in LINKED and not s.is_unavailable]
    return cases + [("", identifier) for identifier in sockets] or [("", "")]


def build_with(kind: str, setting: str, choice: str):
    """A tree that shows all outputs of the node at once, for node_patch."""
    def build(tree):
        node = new(tree, kind, **({setting: choice} if setting else {}))
        sockets = [s for s in node.inputs if s.type in LINKED and not s.is_unavailable]
        linked = next((s for s in sockets if not setting and s.identifier == choice), sockets[0] if sockets else None)
        total = ramp(tree, (0.0, 0.0, 0.0), (0.02, 0.01, 0.0))
        if linked is not None:
            tree.links.new(ramp(tree, (0.05, 0.1, 0.15), (0.9, 0.8, 0.7)), linked)
        left_out = LAMP_OUTPUTS.get(kind, set())
        for k, output in enumerate(s for s in node.outputs if not s.is_unavailable and s.identifier not in left_out):
            squashed = new(tree, "ShaderNodeVectorMath", operation="SINE")  # keeps kelvins and counts within bounds
            tree.links.new(output, squashed.inputs[0])
            add = new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD")
            feed(tree, add, Vector=squashed.outputs[0], Vector_001=(0.5, 0.4 - 0.1 * k, 0.3), Vector_002=total)
            total = add.outputs[0]
        return total

    return build


@pytest.mark.parametrize("kind", supported())
def test_node(patch, kind):
    """All settings and all inputs of a node, one after the other."""
    for setting, choice in variants(kind):
        if (kind, choice) == ("ShaderNodeTexImage", "CLIP") and bpy.app.version < (5, 0):
            continue  # without an image 4.5 leaves its outputs unwritten: they show what another node left there
        compare = patch.compare_engine if kind in ENGINE else patch.compare
        try:
            # edges of cells, bricks and steps: 18 pixels; the sine of 4.5's bright Nishita sky: 50
            compare(build_with(kind, setting, choice), TOLERANCE, outliers=2 * SIZE, flat=None)
        except AssertionError as error:
            raise AssertionError(f"{kind} {setting} {choice}: {error}") from error
