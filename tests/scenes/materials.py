"""Each material on a ball under a soft lamp."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

from sample_blends.builders import materials
from sample_blends.builders.materials import maker, mix, new_material

from . import stage

BLUE, RED, GOLD = (0.2, 0.35, 0.7), (0.75, 0.15, 0.1), (1.0, 0.77, 0.34)
DIFFUSE, GLOSSY = "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy"
PRINCIPLED, GLASS = "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfGlass"
TRANSLUCENT, TRANSPARENT = "ShaderNodeBsdfTranslucent", "ShaderNodeBsdfTransparent"


def added():
    """Add Shader of a diffuse and a weak emission."""
    material, nodes, links, output = new_material("Added")
    add = nodes.new("ShaderNodeAddShader")
    links.new(maker(DIFFUSE, Color=BLUE)(nodes, links), add.inputs[0])
    links.new(maker("ShaderNodeEmission", Color=GOLD, Strength=0.3)(nodes, links), add.inputs[1])
    links.new(add.outputs[0], output.inputs["Surface"])
    return material


def grouped():
    """A node group (with an unlinked default), a reroute, a muted Math node, and Math and Mix Colour on the way."""
    tree = bpy.data.node_groups.new("Paint", "ShaderNodeTree")
    tree.interface.new_socket(name="Color", in_out="INPUT", socket_type="NodeSocketColor")
    rough = tree.interface.new_socket(name="Roughness", in_out="INPUT", socket_type="NodeSocketFloat")
    rough.default_value = 0.35
    tree.interface.new_socket(name="Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    inner = tree.nodes.new("ShaderNodeBsdfPrincipled")
    reroute = tree.nodes.new("NodeReroute")
    tree.links.new(start.outputs["Color"], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], inner.inputs["Base Color"])
    tree.links.new(start.outputs["Roughness"], inner.inputs["Roughness"])
    tree.links.new(inner.outputs[0], end.inputs["Surface"])

    material, nodes, links, output = new_material("Grouped")
    group = nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    group.inputs["Roughness"].default_value = 0.35
    value = nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = 0.3
    math = nodes.new("ShaderNodeMath")
    math.operation = "MULTIPLY"
    math.inputs[1].default_value = 2.0
    muted = nodes.new("ShaderNodeMath")  # passes its first input on
    muted.operation = "ADD"
    muted.inputs[1].default_value = 5.0
    muted.mute = True
    blend = nodes.new("ShaderNodeMix")
    blend.data_type = "RGBA"
    first, second = [s for s in blend.inputs if s.type == "RGBA" and s.enabled][:2]
    first.default_value, second.default_value = (*RED, 1.0), (*BLUE, 1.0)
    links.new(value.outputs[0], math.inputs[0])
    links.new(math.outputs[0], muted.inputs[0])
    links.new(muted.outputs[0], blend.inputs[0])
    links.new(next(s for s in blend.outputs if s.type == "RGBA" and s.enabled), group.inputs["Color"])
    links.new(group.outputs[0], output.inputs["Surface"])
    return material


def nested_mix():
    """A mix of mixes, sharp and rough lobes together."""
    material, nodes, links, output = new_material("Nested")
    inner, outer = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeMixShader")
    inner.inputs[0].default_value, outer.inputs[0].default_value = 0.3, 0.6
    links.new(maker(DIFFUSE, Color=RED)(nodes, links), inner.inputs[1])
    links.new(maker(GLOSSY, Color=GOLD, Roughness=0.0)(nodes, links), inner.inputs[2])
    links.new(inner.outputs[0], outer.inputs[1])
    links.new(maker(GLOSSY, Color=(0.9, 0.9, 0.9), Roughness=0.35)(nodes, links), outer.inputs[2])
    links.new(outer.outputs[0], output.inputs["Surface"])
    return material


def coated(**inputs):
    """Principled with a coat."""
    return materials.principled("Coated", Base_Color=RED, Roughness=0.5, Coat_Weight=1.0, **inputs)


def emissive():
    """Principled that glows and reflects."""
    return materials.principled("Glow", Base_Color=BLUE, Emission_Color=(*GOLD, 1.0), Emission_Strength=0.5)


P = partial(materials.principled, "Principled")
S = partial(materials.shader, "Material")
MAKERS: dict[str, Callable] = {
    "diffuse": partial(S, DIFFUSE, Color=BLUE, Roughness=0.0),
    "diffuse_rough": partial(S, DIFFUSE, Color=GOLD, Roughness=0.8),
    "mirror": partial(S, GLOSSY, Color=GOLD, Roughness=0.0),
    "glossy_02": partial(S, GLOSSY, "GGX", Color=GOLD, Roughness=0.2),
    "glossy_06": partial(S, GLOSSY, "GGX", Color=GOLD, Roughness=0.6),
    "glossy_multiscatter": partial(S, GLOSSY, "MULTI_GGX", Color=GOLD, Roughness=0.8),
    "glass_clear": partial(S, GLASS, IOR=1.5, Roughness=0.0),
    "glass_tinted": partial(S, GLASS, Color=(0.6, 0.9, 0.7), IOR=1.8, Roughness=0.0),
    "glass_rough": partial(S, GLASS, "GGX", Color=(0.9, 0.9, 1.0), IOR=1.45, Roughness=0.3),
    "glass_multiscatter": partial(S, GLASS, "MULTI_GGX", Color=(0.9, 0.9, 1.0), IOR=1.45, Roughness=0.5),
    "refraction": partial(S, "ShaderNodeBsdfRefraction", "GGX", Color=(0.9, 0.8, 0.6), IOR=1.3, Roughness=0.0),
    "refraction_rough": partial(S, "ShaderNodeBsdfRefraction", "GGX", Color=(0.9, 0.8, 0.6), IOR=1.4, Roughness=0.3),
    "translucent": partial(S, TRANSLUCENT, Color=(0.6, 0.8, 0.3)),
    "transparent": partial(S, TRANSPARENT, Color=(0.9, 0.6, 0.3)),
    "emission": partial(S, "ShaderNodeEmission", Color=GOLD, Strength=1.5),
    "principled_default": P,
    "principled_rough": partial(P, Base_Color=BLUE, Roughness=1.0),
    "principled_smooth": partial(P, Base_Color=RED, Roughness=0.0),
    "principled_diffuse_roughness": partial(P, Base_Color=GOLD, Roughness=0.6, Diffuse_Roughness=0.8),
    "principled_metal": partial(P, Base_Color=GOLD, Metallic=1.0, Roughness=0.3),
    "principled_metal_tint": partial(
        P, Base_Color=GOLD, Metallic=1.0, Roughness=0.2, Specular_Tint=(0.4, 0.7, 1.0, 1.0)
    ),
    "principled_half_metal": partial(P, Base_Color=GOLD, Metallic=0.5, Roughness=0.4),
    "principled_ior": partial(P, Base_Color=BLUE, Roughness=0.2, IOR=2.0),
    "principled_specular_level": partial(P, Base_Color=BLUE, Roughness=0.25, Specular_IOR_Level=1.0),
    "principled_specular_tint": partial(P, Base_Color=BLUE, Roughness=0.25, Specular_Tint=(1.0, 0.3, 0.2, 1.0)),
    "principled_multiscatter": partial(S, PRINCIPLED, "MULTI_GGX", Base_Color=GOLD, Metallic=1.0, Roughness=0.8),
    "principled_ggx": partial(S, PRINCIPLED, "GGX", Base_Color=GOLD, Metallic=0.6, Roughness=0.7),
    "principled_transmission": partial(P, Base_Color=(0.7, 0.9, 0.8), Transmission_Weight=1.0, Roughness=0.0),
    "principled_frosted": partial(P, Base_Color=(0.7, 0.9, 0.8), Transmission_Weight=1.0, Roughness=0.35),
    "principled_half_transmission": partial(P, Base_Color=RED, Transmission_Weight=0.5, Roughness=0.2),
    "principled_coat": partial(coated, Coat_Roughness=0.1),
    "principled_coat_sharp": partial(coated, Coat_Roughness=0.0),
    "principled_coat_tint": partial(coated, Coat_Roughness=0.2, Coat_IOR=1.8, Coat_Tint=(0.5, 0.8, 0.4, 1.0)),
    "principled_emission": emissive,
    "principled_alpha": partial(P, Base_Color=RED, Alpha=0.5),
    "alpha_mix": partial(mix, "Veil", 0.5, maker(TRANSPARENT), maker(DIFFUSE, Color=RED)),
    "leaf_mix": partial(
        mix, "Leaf", 0.5, maker(DIFFUSE, Color=(0.3, 0.6, 0.1)), maker(TRANSLUCENT, Color=(0.7, 0.8, 0.2))
    ),
    "nested_mix": nested_mix,
    "fresnel_mix": partial(
        mix, "Varnish", maker("ShaderNodeFresnel", IOR=1.5), maker(DIFFUSE, Color=RED), maker(GLOSSY, Roughness=0.15)
    ),
    "facing_mix": partial(
        mix, "Pearl", maker("ShaderNodeLayerWeight", "Facing", Blend=0.4), maker(DIFFUSE, Color=BLUE),
        maker(GLOSSY, Color=GOLD, Roughness=0.3),
    ),
    "layer_fresnel_mix": partial(
        mix, "Shell", maker("ShaderNodeLayerWeight", "Fresnel", Blend=0.4), maker(DIFFUSE, Color=BLUE),
        maker(GLOSSY, Roughness=0.3),
    ),
    "added": added,
    "grouped": grouped,
}


def ball(name: str) -> None:
    """The ball with one of MAKERS."""
    stage.pedestal(name)  # first an empty file, then its material
    bpy.data.objects["Ball"].data.materials.append(MAKERS[name]())


def no_material(name: str) -> None:
    """A mesh without any material: grey."""
    stage.pedestal(name)


def unlinked(name: str) -> None:
    """A material whose output has nothing linked: black."""
    stage.pedestal(name)
    bpy.data.objects["Ball"].data.materials.append(new_material("Nothing")[0])


SCENES: dict[str, Callable[[], None]] = {
    **{name: partial(ball, name) for name in MAKERS},
    "no_material": partial(no_material, "no_material"),
    "unlinked_output": partial(unlinked, "unlinked_output"),
}

