"""Trees that are not as they should be: cycles, broken links, nodes of add-ons, said once and as in Cycles."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from photon_engine.blender.extract import extract_scene  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402
from photon_engine.transport.renderer import Renderer  # noqa: E402
from tests.node_patch import Patch, channel, feed, new, ramp  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("reports"))


def math(tree, a, b=0.5):
    """An Add node."""
    return feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=a, Value_001=b)


def test_a_cycle_is_cut_and_named(patch):
    """Blender marks a link of the cycle; what it fed keeps its own value."""
    def build(tree):
        first = math(tree, channel(tree, ramp(tree), 0), 0.25)
        second = math(tree, first.outputs[0])
        tree.links.new(second.outputs[0], first.inputs[1])
        return second.outputs[0]

    patch.wire(build)
    value, issues = patch.ours()
    assert [str(issue).count("a cycle or wrong types") for issue in issues] == [1]
    assert "it is ignored" in str(next(iter(issues))) and np.isfinite(value).all() and np.ptp(value) > 0.1


def test_a_link_of_wrong_types_is_named(patch):
    """A shader cannot be a number."""
    def build(tree):
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        return math(tree, channel(tree, ramp(tree), 1), shader.outputs[0]).outputs[0]

    patch.wire(build)
    value, issues = patch.ours()
    assert len(issues) <= 1 and np.isfinite(value).all()
    theirs = patch.cycles()
    np.testing.assert_allclose(value, theirs, atol=1e-3)


def test_groups_of_add_ons_are_groups(patch):
    """A custom group node is entered as in Cycles."""
    group = bpy.data.node_groups.new("Inside", "ShaderNodeTree")
    group.interface.new_socket(name="A", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket(name="B", in_out="OUTPUT", socket_type="NodeSocketFloat")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    group.links.new(math(group, start.outputs[0]).outputs[0], end.inputs[0])

    class AddOnNode(bpy.types.ShaderNodeCustomGroup):
        bl_idname, bl_label = "TestAddOnNode", "Add-on"

    bpy.utils.register_class(AddOnNode)
    try:
        def build(tree):
            node = tree.nodes.new("TestAddOnNode")
            node.node_tree = group
            tree.links.new(channel(tree, ramp(tree), 0), node.inputs[0])
            return node.outputs[0]

        assert not len(patch.compare(build))
    finally:
        bpy.utils.unregister_class(AddOnNode)


def test_a_forgotten_add_on_is_named_once(patch):
    """By material and node; the rest of the tree is used."""
    class Forgotten(bpy.types.ShaderNode):
        bl_idname, bl_label = "TestForgottenNode", "Forgotten"

        def init(self, context):
            """Two outputs."""
            self.outputs.new("NodeSocketFloat", "Value")
            self.outputs.new("NodeSocketColor", "Color")

    bpy.utils.register_class(Forgotten)

    def build(tree):
        node = tree.nodes.new("TestForgottenNode")
        both = math(tree, node.outputs[0], node.outputs[1])
        return math(tree, both.outputs[0], channel(tree, ramp(tree), 0)).outputs[0]

    try:
        patch.wire(build)
    finally:
        bpy.utils.unregister_class(Forgotten)
    value, issues = patch.ours()
    named = [str(issue) for issue in issues]
    assert len(named) == 1 and "Patch > Forgotten" in named[0] and "its outputs are 0.5" in named[0]
    np.testing.assert_allclose(value[:, 0], 1.0 + ramp_value(patch), atol=1e-3)


def ramp_value(patch) -> np.ndarray:
    """The first channel of `ramp` where Cycles' samples lie."""
    return -0.5 + 2.0 * 0.5 * (patch.places[:, 0] + 1.0)


def test_the_engine_names_what_it_cannot_do_once(patch):
    """One message for a material on two objects."""
    patch.wire(lambda tree: tree.nodes.new("ShaderNodeVolumeInfo").outputs["Density"])
    twin = patch.object.copy()
    patch.scene.collection.objects.link(twin)
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    issues = IssueLog()
    renderer = Renderer(extract_scene(graph, issues), Settings(), issues)
    renderer.prepare(lambda text: None)
    renderer.close()
    bpy.data.objects.remove(twin)
    assert [str(issue).count("ShaderNodeVolumeInfo is not supported") for issue in issues] == [1]
