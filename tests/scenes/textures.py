"""Image textures, their mapping and normal maps, on the ball."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import bpy
import numpy as np

from sample_blends.builders import common, materials
from sample_blends.builders.materials import new_material

from . import stage


def letters(n: int = 16) -> np.ndarray:
    """An image without any symmetry, (n, n, 3): a gradient each way and a white L."""
    t = (np.arange(n) + 0.5) / n
    pixels = np.stack([np.tile(t, (n, 1)), np.tile(t[:, None], (1, n)), np.full((n, n), 0.2)], axis=-1)
    pixels[3:13, 3:6] = 1.0
    pixels[3:6, 3:11] = 1.0
    return pixels.astype(np.float32)


def ball_with(name: str, connect: Callable) -> None:
    """The ball with a material whose nodes `connect(nodes, links)` makes; it returns the shader's output."""
    stage.pedestal(name)
    material, nodes, links, output = new_material("Textured")
    links.new(connect(nodes, links), output.inputs["Surface"])
    bpy.data.objects["Ball"].data.materials.append(material)


def image_node(nodes, image=None, **values):
    """An Image Texture node."""
    node = nodes.new("ShaderNodeTexImage")
    node.image = image or materials.add_image("Letters", letters())
    for key, value in values.items():
        setattr(node, key, value)
    return node


def diffuse_of(color, nodes, links):
    """Lambert coloured by a socket; returns its output."""
    node = nodes.new("ShaderNodeBsdfDiffuse")
    links.new(color, node.inputs["Color"])
    return node.outputs[0]


def simple(nodes, links, **values):
    """An image through the active UVs."""
    return diffuse_of(image_node(nodes, **values).outputs["Color"], nodes, links)


def mapped(nodes, links, source="UV", vector_type="POINT", extension="REPEAT", scale=(3.0, 2.0, 1.0), **values):
    """An image through Texture Coordinate and Mapping."""
    coordinate, mapping = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
    mapping.vector_type = vector_type
    mapping.inputs["Rotation"].default_value = (0.2, -0.1, math.radians(30.0))
    mapping.inputs["Scale"].default_value = scale
    if "Location" in mapping.inputs and mapping.inputs["Location"].enabled:
        mapping.inputs["Location"].default_value = (0.3, -0.2, 0.1)
    texture = image_node(nodes, extension=extension, **values)
    links.new(coordinate.outputs[source], mapping.inputs["Vector"])
    links.new(mapping.outputs[0], texture.inputs["Vector"])
    return diffuse_of(texture.outputs["Color"], nodes, links)


def non_color(nodes, links):
    """An image whose numbers are taken as they are."""
    return diffuse_of(image_node(nodes, materials.add_image("Data", letters(), is_data=True)).outputs[0], nodes, links)


def alpha_cutout(nodes, links):
    """The image's alpha mixes with Transparent, in Principled's Alpha."""
    image = bpy.data.images.new("Cutout", 16, 16, alpha=True)
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[:, :, :3] = letters()
    t = np.arange(16) // 4 % 2
    pixels[:, :, 3] = np.where((t[:, None] + t[None, :]) % 2, 1.0, 0.25)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    texture = image_node(nodes, image)
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    links.new(texture.outputs["Alpha"], surface.inputs["Alpha"])
    return surface.outputs[0]


def rough_map(nodes, links):
    """Roughness and metalness from an image."""
    texture = image_node(nodes, materials.add_image("Data", letters(), is_data=True))
    surface = nodes.new("ShaderNodeBsdfPrincipled")
    materials.set_inputs(surface, Base_Color=(0.9, 0.6, 0.3), Metallic=0.7)
    links.new(texture.outputs["Color"], surface.inputs["Roughness"])
    return surface.outputs[0]


def bumps(n: int = 32, count: int = 4) -> np.ndarray:
    """A tangent-space normal map of round bumps."""
    t = (np.arange(n) + 0.5) / n * count % 1.0 * 2.0 - 1.0
    x, y = np.meshgrid(t, t)
    slope = np.where(x**2 + y**2 < 1.0, 0.6, 0.0)
    normal = np.stack([x * slope, y * slope + 0.1, np.ones_like(x)], axis=-1)
    return (0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)).astype(np.float32)


def normal_map(nodes, links, strength=1.0, space="TANGENT", shader="ShaderNodeBsdfDiffuse"):
    """A normal map on a shader."""
    texture = image_node(nodes, materials.add_image("Bumps", bumps(), is_data=True))
    node = nodes.new("ShaderNodeNormalMap")
    node.space = space
    node.inputs["Strength"].default_value = strength
    surface = nodes.new(shader)
    links.new(texture.outputs["Color"], node.inputs["Color"])
    links.new(node.outputs[0], surface.inputs["Normal"])
    return surface.outputs[0]


def second_layer(name: str) -> None:
    """A UV layer named by the UV Map node, another one active for rendering."""

    def connect(nodes, links):
        uv = nodes.new("ShaderNodeUVMap")
        uv.uv_map = "Second"
        texture = image_node(nodes)
        links.new(uv.outputs[0], texture.inputs["Vector"])
        return diffuse_of(texture.outputs["Color"], nodes, links)

    ball_with(name, connect)
    mesh = bpy.data.objects["Ball"].data
    first = np.empty(len(mesh.loops) * 2, np.float32)
    mesh.uv_layers[0].data.foreach_get("uv", first)
    layer = mesh.uv_layers.new(name="Second", do_init=False)
    layer.data.foreach_set("uv", (first.reshape(-1, 2)[:, ::-1] * (2.0, 3.0)).astype(np.float32).ravel())
    mesh.uv_layers[0].active_render = True


def textured_glow(name: str) -> None:
    """A textured surface as the only light."""
    scene = stage.corner(name)
    material, nodes, links, output = new_material("Screen")
    glow = nodes.new("ShaderNodeEmission")
    glow.inputs["Strength"].default_value = 8.0
    links.new(image_node(nodes).outputs["Color"], glow.inputs["Color"])
    links.new(glow.outputs[0], output.inputs["Surface"])
    common.quad(scene, "Screen", [(-0.9, 1.9, 0.9), (0.9, 1.9, 0.9), (0.9, 1.9, 2.2), (-0.9, 1.9, 2.2)][::-1], material)


BALLS: dict[str, Callable] = {
    "image_linear": simple,
    "image_closest": partial(simple, interpolation="Closest"),
    "image_cubic": partial(simple, interpolation="Cubic"),
    "image_non_color": non_color,
    "image_alpha": alpha_cutout,
    "mapping_repeat": mapped,
    "mapping_extend": partial(mapped, extension="EXTEND"),
    "mapping_clip": partial(mapped, extension="CLIP"),
    "mapping_mirror": partial(mapped, extension="MIRROR"),
    "mapping_texture": partial(mapped, vector_type="TEXTURE"),
    "mapping_vector": partial(mapped, vector_type="VECTOR"),
    "generated": partial(mapped, source="Generated"),
    "object_coordinates": partial(mapped, source="Object"),
    "roughness_map": rough_map,
    "normal_map": normal_map,
    "normal_map_weak": partial(normal_map, strength=0.4, shader="ShaderNodeBsdfPrincipled"),
    "normal_map_object": partial(normal_map, space="OBJECT", strength=0.6),
}
SCENES: dict[str, Callable[[], None]] = {
    **{name: partial(ball_with, name, connect) for name, connect in BALLS.items()},
    "uv_second_layer": partial(second_layer, "uv_second_layer"),
    "textured_glow": partial(textured_glow, "textured_glow"),
}
