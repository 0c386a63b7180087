"""Bumps, an absorbing inside, and worlds that vary."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

from sample_blends.builders import materials
from sample_blends.builders.materials import new_material

from . import stage

ORANGE, SILVER = (0.8, 0.45, 0.15), (0.9, 0.9, 0.95)


def maths(nodes, links, operation: str, *values):
    """A Math node's output; values are sockets or numbers."""
    node = nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, values, strict=False):
        if isinstance(value, bpy.types.NodeSocket):
            links.new(value, socket)
        else:
            socket.default_value = value
    return node.outputs[0]


def waves(nodes, links):
    """A height of two crossing waves over Object coordinates."""
    split = nodes.new("ShaderNodeSeparateXYZ")
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Object"], split.inputs[0])
    parts = [maths(nodes, links, "SINE", maths(nodes, links, "MULTIPLY", split.outputs[k], 14.0)) for k in range(2)]
    return maths(nodes, links, "MULTIPLY", *parts)


def bumped(name: str, kind: str, color, displaced: str = "", **inputs) -> None:
    """The ball with a bumped shader, by a Bump node or by the material's displacement (its method)."""
    stage.pedestal(name)
    material, nodes, links, output = new_material("Bumped")
    material.displacement_method = displaced or "BUMP"
    shader = nodes.new(kind)
    shader.inputs["Color"].default_value = (*color, 1.0)
    for key, value in inputs.items():
        shader.inputs[key].default_value = value
    height = waves(nodes, links)
    node = nodes.new("ShaderNodeDisplacement" if displaced else "ShaderNodeBump")
    node.inputs["Scale" if displaced else "Distance"].default_value = 0.05
    links.new(height, node.inputs["Height"])
    links.new(node.outputs[0], output.inputs["Displacement"] if displaced else shader.inputs["Normal"])
    links.new(shader.outputs[0], output.inputs["Surface"])
    bpy.data.objects["Ball"].data.materials.append(material)


def absorbing_glass():
    """Clear glass with an absorbing inside."""
    material = materials.glass("Wine")
    tree = material.node_tree
    volume = tree.nodes.new("ShaderNodeVolumeAbsorption")
    volume.inputs["Color"].default_value = (0.8, 0.3, 0.2, 1.0)
    volume.inputs["Density"].default_value = 1.5
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(volume.outputs[0], output.inputs["Volume"])
    return material


def sky(name: str, sun: float) -> None:
    """The corner under a world that is blue above and dark below, with a glow of strength `sun` about a direction."""
    scene = stage.corner(name)
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    scene.world = world
    nodes, links = world.node_tree.nodes, world.node_tree.links
    split = nodes.new("ShaderNodeSeparateXYZ")
    coordinates = nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    links.new(coordinates, split.inputs[0])
    toward = nodes.new("ShaderNodeVectorMath")
    toward.operation = "DOT_PRODUCT"
    toward.inputs[1].default_value = (0.48, -0.6, 0.64)
    links.new(coordinates, toward.inputs[0])
    glow = maths(nodes, links, "POWER", maths(nodes, links, "MAXIMUM", toward.outputs["Value"], 0.0), 600.0)
    up = maths(nodes, links, "MAXIMUM", split.outputs[2], 0.0)
    color = nodes.new("ShaderNodeCombineXYZ")
    for k, share in enumerate((0.3, 0.5, 1.0)):
        blue = maths(nodes, links, "MULTIPLY", up, share)
        links.new(maths(nodes, links, "MULTIPLY_ADD", glow, sun * (1.0 - 0.2 * k), blue), color.inputs[k])
    background = next(node for node in nodes if node.type == "BACKGROUND")
    links.new(color.outputs[0], background.inputs["Color"])


def absorbing_ball(name: str) -> None:
    """A ball of clear glass whose inside absorbs: its rim is lighter than its middle."""
    stage.pedestal(name)
    bpy.data.objects["Ball"].data.materials.append(absorbing_glass())


SCENES: dict[str, Callable[[], None]] = {
    "bump_diffuse": partial(bumped, "bump_diffuse", "ShaderNodeBsdfDiffuse", ORANGE),
    "bump_glossy": partial(bumped, "bump_glossy", "ShaderNodeBsdfGlossy", SILVER, Roughness=0.35),
    "displacement_as_bump": partial(bumped, "displacement_as_bump", "ShaderNodeBsdfDiffuse", ORANGE, "BUMP"),
    "displacement_true": partial(bumped, "displacement_true", "ShaderNodeBsdfDiffuse", ORANGE, "DISPLACEMENT"),
    "absorbing_glass": partial(absorbing_ball, "absorbing_glass"),
    "world_gradient": partial(sky, "world_gradient", 0.0),
    "world_sun": partial(sky, "world_sun", 150.0),
}
