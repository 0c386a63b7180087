"""Groups, reroutes, muted nodes and links, conversions, outputs, against Cycles."""

from __future__ import annotations

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from photon_engine.blender.images import ImageTable  # noqa: E402
from photon_engine.blender.node_trees import material_graph, world_graph  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.scene.data import Material  # noqa: E402
from photon_engine.shading.material import compile_material  # noqa: E402
from photon_engine.shading.program import constant_background  # noqa: E402
from tests.node_patch import EDGES, TOLERANCE, Patch, channel, feed, new, out, ramp  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


KINDS = {"VALUE": "NodeSocketFloat", "INT": "NodeSocketInt", "BOOLEAN": "NodeSocketBool", "VECTOR": "NodeSocketVector",
         "RGBA": "NodeSocketColor"}


def new_group(name: str, inputs: dict, outputs: dict):
    """A node group with sockets by name and kind, and its two ends."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for direction, sockets in (("INPUT", inputs), ("OUTPUT", outputs)):
        for label, kind in sockets.items():
            group.interface.new_socket(name=label, in_out=direction, socket_type=KINDS[kind])
    return group, group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")


def place(tree, group):
    """A group node."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    return node


@pytest.mark.parametrize("inner", KINDS)
def test_group_converts(patch, inner):
    """A colour that passes a group's sockets of another kind is converted there."""
    group, start, end = new_group("Through", {"A": inner}, {"B": "RGBA"})
    group.links.new(start.outputs[0], end.inputs[0])

    def build(tree):
        node = place(tree, group)
        tree.links.new(ramp(tree, (0.0, 0.9, 0.2), (2.1, 1.1, 3.8)), node.inputs[0])
        return node.outputs[0]

    patch.compare(build, outliers=EDGES if inner in ("INT", "BOOLEAN") else 0)


def test_nested_groups(patch):
    """Two instances of a group in a group, with their own values, two outputs, and unlinked ends."""
    low, start, end = new_group("Low", {"A": "VALUE", "B": "VALUE"}, {"Sum": "VALUE", "Own": "RGBA"})
    add = feed(low, new(low, "ShaderNodeMath", operation="ADD"), Value=start.outputs[0], Value_001=start.outputs[1])
    low.links.new(add.outputs[0], end.inputs[0])
    end.inputs[1].default_value = (0.3, 0.5, 0.7, 1.0)
    high, start, end = new_group("High", {"X": "VALUE"}, {"Y": "RGBA"})
    one, two = place(high, low), place(high, low)
    one.inputs[1].default_value, two.inputs[1].default_value = 0.25, -0.5
    high.links.new(start.outputs[0], one.inputs[0])
    high.links.new(one.outputs[0], two.inputs[0])
    mix = new(high, "ShaderNodeMix", data_type="RGBA", blend_type="ADD")
    feed(high, mix, Factor_Float=1.0, A_Color=two.outputs[0], B_Color=one.outputs[1])
    high.links.new(out(mix, "Result_Color"), end.inputs[0])

    def build(tree):
        first, second = place(tree, high), place(tree, high)
        tree.links.new(channel(tree, ramp(tree), 0), first.inputs[0])
        second.inputs[0].default_value = 0.4
        node = new(tree, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
        feed(tree, node, Factor_Float=0.8, A_Color=first.outputs[0], B_Color=second.outputs[0])
        return out(node, "Result_Color")

    patch.compare(build)


def test_reroutes(patch):
    def build(tree):
        first, second = tree.nodes.new("NodeReroute"), tree.nodes.new("NodeReroute")
        tree.links.new(ramp(tree), first.inputs[0])
        tree.links.new(first.outputs[0], second.inputs[0])
        return second.outputs[0]

    patch.compare(build)


def test_unlinked_reroute(patch):
    def build(tree):
        reroute = tree.nodes.new("NodeReroute")
        add = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=channel(tree, ramp(tree), 0))
        add.inputs[1].default_value = 0.7
        tree.links.new(reroute.outputs[0], add.inputs[1])
        return add.outputs[0]

    patch.compare(build)


@pytest.mark.parametrize("kind", ["ShaderNodeMath", "ShaderNodeMix", "ShaderNodeInvert", "ShaderNodeTexImage",
                                  "ShaderNodeTexChecker", "ShaderNodeGroup"])
def test_muted_node(patch, kind):
    """A muted node passes its matching input on; one without such an input gives nothing."""
    def build(tree):
        node = tree.nodes.new(kind)
        if kind == "ShaderNodeGroup":
            node.node_tree = new_group("Muted", {"A": "VECTOR"}, {"B": "VECTOR"})[0]
        if kind == "ShaderNodeMix":
            node.data_type = "RGBA"
        own = ("VALUE",) if kind == "ShaderNodeMath" else ("VECTOR", "RGBA")
        socket = next(s for s in node.inputs if not s.is_unavailable and s.type in own)
        tree.links.new(ramp(tree), socket)
        node.mute = True
        add = new(tree, "ShaderNodeVectorMath", operation="ADD")
        result = next(s for s in node.outputs if not s.is_unavailable)
        return feed(tree, add, Vector=result, Vector_001=ramp(tree, (0.0, 0.1, 0.2), (0.3, 0.2, 0.1))).outputs[0]

    patch.compare(build)


def test_muted_link(patch):
    def build(tree):
        add = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=channel(tree, ramp(tree), 0))
        add.inputs[1].default_value = 0.3
        tree.links.new(channel(tree, ramp(tree), 1), add.inputs[1]).is_muted = True
        return add.outputs[0]

    patch.compare(build)


def test_cycle_is_reported(patch):
    def build(tree):
        one = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=channel(tree, ramp(tree), 0))
        two = feed(tree, new(tree, "ShaderNodeMath", operation="MULTIPLY"), Value=one.outputs[0], Value_001=0.25)
        tree.links.new(two.outputs[0], one.inputs[1])
        return one.outputs[0]

    patch.wire(build)
    value, issues = patch.ours()
    assert any("cycle" in str(issue) for issue in issues)
    assert np.ptp(value) > 0.5


@pytest.mark.parametrize("source", ["VALUE", "VECTOR", "RGBA"])
@pytest.mark.parametrize("target", ["VALUE", "VECTOR", "RGBA"])
def test_implicit_conversion(patch, source, target):
    def build(tree):
        vector = ramp(tree)
        if source == "VALUE":
            vector = channel(tree, vector, 0)
        if source == "RGBA":
            vector = feed(tree, tree.nodes.new("ShaderNodeGamma"), Color=vector, Gamma=1.0).outputs[0]
        if target == "VALUE":
            return feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=vector, Value_001=0.1).outputs[0]
        if target == "VECTOR":
            node = new(tree, "ShaderNodeVectorMath", operation="ADD")
            return feed(tree, node, Vector=vector, Vector_001=(0.1, 0.2, 0.3)).outputs[0]
        return feed(tree, tree.nodes.new("ShaderNodeInvert"), Color=vector, Fac=0.7).outputs[0]

    patch.compare(build)


def test_output_for_cycles(patch):
    """Of several outputs the active one for Cycles counts, then the active one for all."""
    tree = patch.material.node_tree
    tree.nodes.clear()
    for target, strength in (("EEVEE", 1.0), ("ALL", 2.0), ("CYCLES", 3.0)):
        output, emission = new(tree, "ShaderNodeOutputMaterial", target=target), tree.nodes.new("ShaderNodeEmission")
        emission.inputs["Strength"].default_value = strength
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
    for expected in (3.0, 2.0):
        issues = IssueLog()
        graph = material_graph(patch.material, ImageTable(issues), issues)
        program = compile_material(Material("Patch", graph), [], issues)
        np.testing.assert_allclose(program.emission(), [[expected] * 3])
        ours = [node for node in tree.nodes if getattr(node, "target", "") == "CYCLES"]
        for node in ours:
            tree.nodes.remove(node)


def test_no_output(patch):
    patch.material.node_tree.nodes.clear()
    issues = IssueLog()
    assert material_graph(patch.material, ImageTable(issues), issues).surface is None
    assert "no active output" in str(next(iter(issues)))


def test_world_without_links():
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 2.0
    issues = IssueLog()
    graph = world_graph(world, ImageTable(issues), issues)
    np.testing.assert_allclose(constant_background(graph), (0.2, 0.4, 0.6), rtol=1e-6)


def test_back_side(patch):
    """From below: normals turn to the eye, Fresnel inverts the index."""
    def build(tree):
        fresnel = feed(tree, tree.nodes.new("ShaderNodeFresnel"), IOR=1.6)
        side = tree.nodes.new("ShaderNodeNewGeometry")
        split = feed(tree, tree.nodes.new("ShaderNodeSeparateXYZ"), Vector=out(side, "Normal"))
        node = tree.nodes.new("ShaderNodeCombineXYZ")
        return feed(tree, node, X=fresnel.outputs[0], Y=split.outputs[2], Z=out(side, "Backfacing")).outputs[0]

    patch.wire(build)
    patch.camera.location, patch.camera.rotation_euler = (0.0, 0.0, -2.0), (0.0, math.pi, 0.0)
    try:
        theirs = patch.cycles()
        ours, _ = patch.ours(back=True)
    finally:
        patch.camera.location, patch.camera.rotation_euler = (0.0, 0.0, 2.0), (0.0, 0.0, 0.0)
    assert np.abs(ours - theirs).max() < TOLERANCE
