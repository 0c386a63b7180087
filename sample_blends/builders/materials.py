"""Materials of the sample scenes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy
import numpy as np

Color = Sequence[float]


def new_material(name: str, color: Color = (0.8, 0.8, 0.8)):
    """A material with only an output node; returns (material, nodes, links, output)."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = (*color[:3], 1.0)
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree.nodes, tree.links, tree.nodes.new("ShaderNodeOutputMaterial")


def shader(name: str, node_type: str, distribution: str = "", **inputs):
    """A material of one shader node; inputs by socket name with underscores for spaces.

    distribution : of the microfacets, GGX or MULTI_GGX; empty: as Blender makes the node
    """
    material, nodes, links, output = new_material(name, inputs.get("Color", (0.8, 0.8, 0.8)))
    node = nodes.new(node_type)
    if distribution:
        node.distribution = distribution
    set_inputs(node, **inputs)
    links.new(node.outputs[0], output.inputs["Surface"])
    return material


def set_inputs(node, **inputs) -> None:
    """Constant inputs by socket name with underscores for spaces; three numbers for a colour are enough."""
    for key, value in inputs.items():
        socket = node.inputs[key.replace("_", " ")]
        if socket.type == "RGBA" and len(value) == 3:
            value = (*value, 1.0)
        socket.default_value = value


def diffuse(name: str, color: Color):
    """Lambert."""
    return shader(name, "ShaderNodeBsdfDiffuse", Color=color, Roughness=0.0)


def glass(name: str, color: Color = (1.0, 1.0, 1.0), ior: float = 1.5, roughness: float = 0.0):
    """Glass BSDF."""
    return shader(name, "ShaderNodeBsdfGlass", Color=color, IOR=ior, Roughness=roughness)


def glossy(name: str, color: Color, roughness: float = 0.0):
    """Glossy BSDF."""
    return shader(name, "ShaderNodeBsdfGlossy", Color=color, Roughness=roughness)


def principled(name: str, **inputs):
    """Principled BSDF, default values but for the inputs given."""
    return shader(name, "ShaderNodeBsdfPrincipled", **inputs)


def add_image(name: str, pixels: np.ndarray, is_data: bool = False):
    """A packed 8-bit image from pixels (h, w, 3) in [0, 1] (sRGB values unless data), bottom row first."""
    h, w, _ = pixels.shape
    image = bpy.data.images.new(name, w, h, alpha=False, is_data=is_data)
    full = np.ones((h, w, 4), np.float32)
    full[:, :, :3] = pixels
    image.pixels.foreach_set(full.ravel())
    image.update()
    image.pack()
    return image


def textured_diffuse(name: str, image, interpolation: str = "Linear"):
    """Lambert coloured by an image through the active UV layer."""
    material, nodes, links, output = new_material(name)
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    texture.interpolation = interpolation
    node = nodes.new("ShaderNodeBsdfDiffuse")
    links.new(texture.outputs["Color"], node.inputs["Color"])
    links.new(node.outputs[0], output.inputs["Surface"])
    return material


def mix(name: str, factor: float | Callable, first: Callable, second: Callable):
    """Mix Shader; each argument makes a node from (nodes, links) and returns the output socket to use."""
    material, nodes, links, output = new_material(name)
    node = nodes.new("ShaderNodeMixShader")
    if callable(factor):
        links.new(factor(nodes, links), node.inputs[0])
    else:
        node.inputs[0].default_value = factor
    links.new(first(nodes, links), node.inputs[1])
    links.new(second(nodes, links), node.inputs[2])
    links.new(node.outputs[0], output.inputs["Surface"])
    return material


def maker(node_type: str, output: int | str = 0, **inputs) -> Callable:
    """For `mix`: a function that makes a node with constant inputs and returns an output socket."""

    def make(nodes, links):
        node = nodes.new(node_type)
        set_inputs(node, **inputs)
        return node.outputs[output]

    return make
