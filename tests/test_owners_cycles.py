"""What nodes of a lamp ask about their object, and those of the world, which is none: one value each, as in Cycles."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from photon_engine.shading.material import compile_material  # noqa: E402
from photon_engine.shading.points import sky_points  # noqa: E402
from photon_engine.shading.program import compile_graph  # noqa: E402
from tests.extract_help import IssueLog, extract, link  # noqa: E402
from tests.node_patch import feed, new, out  # noqa: E402
from tests.test_lights_cycles import add_lamp, render, scene  # noqa: E402, F401

ASKED = [
    *(("ShaderNodeObjectInfo", name, {}) for name in ("Location", "Color", "Alpha", "Object Index", "Material Index",
                                                      "Random")),
    *(("ShaderNodeAttribute", output, {"attribute_type": kind, "attribute_name": name})
      for kind, name in (("OBJECT", "of object"), ("OBJECT", "of data"), ("OBJECT", "none"), ("INSTANCER", "of parent"),
                         ("VIEW_LAYER", "of scene"), ("VIEW_LAYER", "none"), ("GEOMETRY", "none"))
      for output in ("Color", "Alpha")),
    ("ShaderNodeAttribute", "Fac", {"attribute_type": "OBJECT", "attribute_name": "of data"}),
    ("ShaderNodeParticleInfo", "Random", {}), ("ShaderNodeVertexColor", "Alpha", {}),
]  # fmt: skip
LIFT = 0.5  # added to what is asked: black would tell little


def ask(tree, shader, question):
    """The shader's colour is what a node says of its owner, and LIFT."""
    kind, output, props = question
    add = feed(tree, new(tree, "ShaderNodeVectorMath", operation="ADD"), Vector=out(new(tree, kind, **props), output),
               Vector_001=(LIFT,) * 3)
    tree.links.new(add.outputs[0], next(n for n in tree.nodes if n.type == shader).inputs["Color"])


@pytest.fixture
def small(scene):  # noqa: F811
    """64 pixels and one sample of each: nothing here is noisy."""
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.cycles.samples = 1
    scene["of scene"] = 0.43
    return scene


@pytest.mark.parametrize("instanced", [False, True])
def test_lamps(small, tmp_path, instanced):
    """Of an instanced lamp the colour is the instancer's, the index its own."""
    lamp = add_lamp(small, "POINT", (0.3, 0.2, 2.0), (0.0, 0.0, 0.0), shadow_soft_size=0.0)
    lamp["of object"], lamp.data["of data"] = [0.1, 0.7, 0.2, 0.6], 0.29
    lamp.color, lamp.pass_index = (0.25, 0.5, 0.75, 0.6), 3
    if instanced:
        group = bpy.data.collections.new("Group")
        small.collection.objects.unlink(lamp)
        group.objects.link(lamp)
        parent = link(bpy.data.objects.new("Parent", None))
        parent.instance_type, parent.instance_collection = "COLLECTION", group
        parent.color, parent.pass_index, parent["of parent"] = (0.9, 0.8, 0.7, 0.4), 5, 0.37
    plain, dark = np.array(extract().lights[0].strength), render(small, tmp_path)
    lamp.data.use_nodes = True
    for question in ASKED:
        ask(lamp.data.node_tree, "EMISSION", question)
        issues = IssueLog()
        light = extract(issues).lights[0]
        theirs = (render(small, tmp_path) / dark).mean((0, 1)) - LIFT
        assert light.graph is None and light.beam is None and not len(issues)
        np.testing.assert_allclose(np.array(light.strength) / plain - LIFT, theirs, atol=1e-4, err_msg=str(question))


def test_the_world(small, tmp_path):
    world = small.world = bpy.data.worlds.new("World")
    if not world.node_tree:
        world.use_nodes = True
    world.cycles.sampling_method = "NONE"  # it is only looked at
    bpy.data.objects["Floor"].hide_render = True
    for question in ASKED:
        ask(world.node_tree, "BACKGROUND", question)
        data = extract()
        program = compile_graph(data.world.graph, "World", [], IssueLog())
        found = program.emission(sky_points(np.array([[0.0, 0.0, -1.0]])))[0]
        np.testing.assert_allclose(found, render(small, tmp_path).mean((0, 1)), atol=1e-4, err_msg=str(question))


@pytest.mark.parametrize("owner", ["lamp", "world", "mesh"])
def test_bounces_that_are_not_counted_are_named(small, owner):
    """What glows is asked by eye paths, whose bounces are known, and by light sampling and photons, without."""
    if owner == "lamp":
        block = add_lamp(small, "POINT").data
        block.use_nodes = True
    elif owner == "world":
        block = small.world = bpy.data.worlds.new("World")
        if not block.node_tree:
            block.use_nodes = True
    else:
        block = bpy.data.objects["Floor"].data.materials[0]
        tree = block.node_tree
        tree.links.new(tree.nodes.new("ShaderNodeEmission").outputs[0], tree.nodes["Material Output"].inputs[0])
    for output, named in (("Ray Depth", True), ("Transparent Depth", True), ("Ray Length", False),
                          ("Is Camera Ray", False)):
        ask(block.node_tree, "BACKGROUND" if owner == "world" else "EMISSION", ("ShaderNodeLightPath", output, {}))
        issues = IssueLog()
        for material in extract(issues).materials:
            compile_material(material, [], issues)
        said = [issue.message for issue in issues if issue.object.startswith(f"{block.name} > Light Path")]
        assert len(issues) == len(said) == named and all(output in message for message in said)
