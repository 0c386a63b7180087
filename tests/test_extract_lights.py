"""Lamps and the world from Blender, in Cycles' units."""

import math

import bpy
import numpy as np
import pytest

from photon_engine.issues import IssueLog
from tests.extract_help import empty_scene, extract, link, messages


@pytest.fixture(autouse=True, name="scene")
def fresh_scene():
    return empty_scene()


def lamp(kind, **values):
    """A lamp object with those properties."""
    data = bpy.data.lights.new("Lamp", kind)
    for name, value in values.items():
        setattr(data, name, value)
    return link(bpy.data.objects.new("Lamp", data))


def test_lamps_of_each_kind():
    lamp("POINT", energy=3.0, color=(1.0, 0.5, 0.25), exposure=1.0, shadow_soft_size=0.2, use_soft_falloff=False)
    light = extract().lights[0]
    assert light.strength == pytest.approx((6.0, 3.0, 1.5))
    assert (light.kind, light.soft_falloff, light.normalize) == ("POINT", False, True)
    assert light.radius == pytest.approx(0.2)
    bpy.data.lights.remove(bpy.data.lights["Lamp"])

    lamp("SPOT", spot_size=1.0, spot_blend=0.3, normalize=False)
    light = extract().lights[0]
    assert (light.spot_size, light.spot_blend) == pytest.approx((1.0, 0.3))
    assert light.soft_falloff and not light.normalize
    bpy.data.lights.remove(bpy.data.lights["Lamp"])

    lamp("SUN", angle=0.02, use_temperature=True, temperature=3000.0, energy=2.0)
    light = extract().lights[0]
    assert light.angle == pytest.approx(0.02)
    # Blender's colour of a black body of 3000 K, rendered and measured with Cycles
    assert light.strength == pytest.approx((2 * 1.7708, 2 * 0.8443, 2 * 0.2722), rel=1e-3)


@pytest.mark.parametrize(("shape", "size"), [
    ("SQUARE", (2.0, 2.0)), ("DISK", (2.0, 2.0)), ("RECTANGLE", (2.0, 3.0)), ("ELLIPSE", (2.0, 3.0)),
])  # fmt: skip
def test_area_lamps_keep_their_size_apart_from_their_scale(shape, size):
    ob = lamp("AREA", shape=shape, size=2.0, size_y=3.0, spread=1.0)
    ob.scale = (2.0, 3.0, 4.0)
    light = extract().lights[0]
    assert (light.shape, light.size) == (shape, size)
    assert light.spread == pytest.approx(1.0)
    np.testing.assert_allclose(np.linalg.norm(light.matrix[:3, :3], axis=0), (2.0, 3.0, 4.0), rtol=1e-6)
    assert extract().lights[0].spread <= math.pi


def test_lamp_nodes_multiply():
    ob = lamp("POINT", energy=2.0)
    ob.data.use_nodes = True
    emission = ob.data.node_tree.nodes["Emission"]
    emission.inputs["Color"].default_value = (1.0, 0.5, 0.0, 1.0)
    emission.inputs["Strength"].default_value = 3.0
    assert extract().lights[0].strength == pytest.approx((6.0, 3.0, 0.0))
    falloff = ob.data.node_tree.nodes.new("ShaderNodeLightFalloff")
    ob.data.node_tree.links.new(falloff.outputs["Quadratic"], emission.inputs["Strength"])
    assert extract().lights[0].strength == pytest.approx((200.0, 100.0, 0.0))  # the node's strength is 100
    ob.data.node_tree.links.new(falloff.outputs["Linear"], emission.inputs["Strength"])
    light = extract(IssueLog()).lights[0]
    assert light.strength == pytest.approx((2.0, 2.0, 2.0)) and light.graph is not None  # evaluated at every sample


def test_lamps_that_give_no_light_are_reported():
    ob = lamp("AREA")
    ob.data.cycles.is_portal = True
    issues = IssueLog()
    assert not extract(issues).lights and "portal" in messages(issues, "Lamp")
    ob.data.cycles.is_portal = False
    ob.data.energy = -1.0
    issues = IssueLog()
    assert not extract(issues).lights and "negative" in messages(issues, "Lamp")


def test_lamps_in_instanced_collections():
    collection = bpy.data.collections.new("Part")
    ob = lamp("POINT")
    bpy.context.scene.collection.objects.unlink(ob)
    collection.objects.link(ob)
    for i in range(2):
        empty = link(bpy.data.objects.new("Empty", None))
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", collection, (i, 0, 0)
    assert sorted(light.matrix[0, 3] for light in extract().lights) == [0.0, 1.0]


def test_light_linking_is_reported():
    ob = lamp("POINT")
    ob.light_linking.receiver_collection = bpy.data.collections.new("Some")
    issues = IssueLog()
    extract(issues)
    assert "linking" in messages(issues, "Lamp")


def world():
    world = bpy.data.worlds.new("World")
    if not world.node_tree:
        world.use_nodes = True
    bpy.context.scene.world = world
    return world, world.node_tree


def test_world_constant_and_varying():
    assert extract().world.color == (0.0, 0.0, 0.0)
    _, tree = world()
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    background.inputs["Strength"].default_value = 2.0
    issues = IssueLog()
    assert extract(issues).world.color == pytest.approx((0.2, 0.4, 0.6))
    assert not list(issues)
    rgb = tree.nodes.new("ShaderNodeRGB")
    rgb.outputs[0].default_value = (1.0, 0.5, 0.25, 1.0)
    tree.links.new(rgb.outputs[0], background.inputs["Color"])
    assert extract().world.color == pytest.approx((2.0, 1.0, 0.5))
    for kind in ("TexGradient", "TexEnvironment"):
        tree.links.new(tree.nodes.new(f"ShaderNode{kind}").outputs["Color"], background.inputs["Color"])
        issues = IssueLog()
        data = extract(issues)
        assert data.world.graph is not None
        assert data.world.color == (0.0, 0.0, 0.0), kind


@pytest.mark.parametrize(("output", "smooth", "constant"), [("Quadratic", 0.0, True), ("Linear", 0.0, False),
                                                            ("Quadratic", 0.5, False)])
def test_light_falloff(output, smooth, constant):
    """The quadratic falloff is the lamp's own; others vary with distance and are evaluated at every sample."""
    data = lamp("POINT").data
    data.use_nodes = True
    tree = data.node_tree
    emission = next(n for n in tree.nodes if n.type == "EMISSION")
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    falloff.inputs["Strength"].default_value, falloff.inputs["Smooth"].default_value = 3.0, smooth
    tree.links.new(falloff.outputs[output], emission.inputs["Strength"])
    issues = IssueLog()
    light = extract(issues).lights[0]
    plain = data.energy * np.array(data.color)
    assert light.strength == pytest.approx(plain * (3.0 if constant else 1.0))
    assert constant == (light.graph is None) and not list(issues)


def test_smooth_nodes_by_direction_become_a_map():
    """What jumps, or varies otherwise, is evaluated at every sample instead."""
    data = lamp("POINT").data
    data.use_nodes = True
    tree = data.node_tree
    emission = next(n for n in tree.nodes if n.type == "EMISSION")
    geometry, checker = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeTexChecker")
    for output, mapped in (("Incoming", True), ("Position", False)):
        tree.links.new(geometry.outputs[output], emission.inputs["Color"])
        data.shadow_soft_size = 0.5
        light = extract(IssueLog()).lights[0]
        assert (light.beam is not None) == mapped and (light.graph is None) == mapped
    tree.links.new(geometry.outputs["Incoming"], checker.inputs["Vector"])
    tree.links.new(checker.outputs["Color"], emission.inputs["Color"])
    assert extract(IssueLog()).lights[0].graph is not None
