"""Repeat zones, closures, bundles, menus and constants in shader trees against Cycles (Blender 5)."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import Patch, channel, feed, new, ramp  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0), reason="Blender 5 has them first")


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("resolved"))


def math(tree, operation, a, b):
    """A Math node of two inputs."""
    return feed(tree, new(tree, "ShaderNodeMath", operation=operation), Value=a, Value_001=b).outputs[0]


def repeat(tree, start, turns):
    """A repeat zone: value -> value * 1.3 + 0.1."""
    first, last = tree.nodes.new("GeometryNodeRepeatInput"), tree.nodes.new("GeometryNodeRepeatOutput")
    first.pair_with_output(last)
    last.repeat_items.new("FLOAT", "Value")
    tree.links.new(start, first.inputs["Value"])
    grown = math(tree, "MULTIPLY", first.outputs["Value"], 1.3)
    tree.links.new(math(tree, "ADD", grown, 0.1), last.inputs["Value"])
    first.inputs["Iterations"].default_value = turns
    return last.outputs["Value"]


def closure(tree, value):
    """A closure that squares, evaluated."""
    first, last = tree.nodes.new("NodeClosureInput"), tree.nodes.new("NodeClosureOutput")
    first.pair_with_output(last)
    last.input_items.new("FLOAT", "In")
    last.output_items.new("FLOAT", "Out")
    tree.links.new(math(tree, "MULTIPLY", first.outputs["In"], first.outputs["In"]), last.inputs["Out"])
    evaluate = tree.nodes.new("NodeEvaluateClosure")
    evaluate.input_items.new("FLOAT", "In")
    evaluate.output_items.new("FLOAT", "Out")
    tree.links.new(last.outputs["Closure"], evaluate.inputs["Closure"])
    tree.links.new(value, evaluate.inputs["In"])
    return evaluate.outputs["Out"]


def bundle(tree, value):
    """A bundle of two values, the second taken out again."""
    pack, unpack = tree.nodes.new("NodeCombineBundle"), tree.nodes.new("NodeSeparateBundle")
    for node in (pack, unpack):
        for name in ("A", "B"):
            node.bundle_items.new("FLOAT", name)
    tree.links.new(math(tree, "ADD", value, 0.5), pack.inputs["A"])
    tree.links.new(value, pack.inputs["B"])
    tree.links.new(pack.outputs[0], unpack.inputs[0])
    return math(tree, "SUBTRACT", unpack.outputs["A"], math(tree, "MULTIPLY", unpack.outputs["B"], 0.25))


def chosen(tree, value):
    """Constants of the nodes that geometry nodes have too."""
    number, vector = tree.nodes.new("FunctionNodeInputInt"), tree.nodes.new("FunctionNodeInputVector")
    number.integer, vector.vector = 3, (0.2, 0.4, 0.6)
    scaled = new(tree, "ShaderNodeVectorMath", operation="SCALE")
    feed(tree, scaled, Vector=vector.outputs[0], Scale=math(tree, "MULTIPLY", value, number.outputs[0]))
    return scaled.outputs[0]


BUILDS = {
    "repeat": lambda tree, value: repeat(tree, value, 4),
    "repeat_never": lambda tree, value: repeat(tree, value, 0),
    "closure": closure,
    "bundle": bundle,
    "constants": chosen,
    "all": lambda tree, value: closure(tree, bundle(tree, repeat(tree, value, 2))),
}


@pytest.mark.parametrize("name", BUILDS)
def test_resolved(patch, name):
    issues = patch.compare(lambda tree: BUILDS[name](tree, channel(tree, ramp(tree), 0)))
    assert not len(issues)


@pytest.mark.parametrize("output", ["Seconds", "Frame"])
def test_scene_time(patch, output):
    """The one node of this kind that Blender leaves to the renderer."""
    patch.scene.frame_set(7)
    patch.scene.render.fps, patch.scene.render.fps_base = 30, 1.001
    patch.compare(lambda tree: tree.nodes.new("GeometryNodeInputSceneTime").outputs[output], flat=True)


def menu(tree, value):
    """The second of two choices."""
    node = new(tree, "GeometryNodeMenuSwitch", data_type="FLOAT")
    tree.links.new(value, node.inputs["B"])
    node.inputs["A"].default_value, node.inputs["Menu"].default_value = 7.0, "B"
    return node.outputs[0]


def test_menu(patch):
    patch.compare(lambda tree: menu(tree, channel(tree, ramp(tree), 1)))


def test_inside_a_group(patch):
    """The zone is in a group that is used twice, through the whole engine."""
    group = bpy.data.node_groups.new("Zone", "ShaderNodeTree")
    group.interface.new_socket(name="A", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket(name="B", in_out="OUTPUT", socket_type="NodeSocketFloat")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    group.links.new(repeat(group, start.outputs[0], 3), end.inputs[0])

    def build(tree):
        first, second = (new(tree, "ShaderNodeGroup", node_tree=group) for _ in range(2))
        tree.links.new(channel(tree, ramp(tree), 0), first.inputs[0])
        tree.links.new(math(tree, "MULTIPLY", first.outputs[0], 0.2), second.inputs[0])
        return second.outputs[0]

    patch.compare_engine(build)


def test_nodes_keep_their_names(patch):
    """What is reported names the node, not the number that Blender gave it while it resolved the tree."""
    def build(tree):
        value = tree.nodes.new("ShaderNodeVolumeInfo")
        value.name = "Dirt"
        return repeat(tree, value.outputs["Density"], 2)

    patch.wire(build)
    _, issues = patch.ours()
    assert [str(issue).count("Patch > Dirt") for issue in issues] == [1]
    assert np.isfinite(patch.ours()[0]).all()
