"""Subsurface scattering: laws, radii against the size of the body, textures and bumps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import bpy

from sample_blends.builders.materials import new_material, set_inputs

from . import stage

SKIN, JADE, WAX = (0.8, 0.5, 0.35), (0.3, 0.7, 0.45), (0.9, 0.75, 0.5)
RED_DEEP = (1.0, 0.35, 0.2)  # radii


def walking(method: str, **inputs):
    """A Subsurface Scattering material; Blender 4 has the older random walk under the newer one's name."""
    material, nodes, links, output = new_material(method)
    node = nodes.new("ShaderNodeSubsurfaceScattering")
    node.falloff = named(method)
    set_inputs(node, **inputs)
    links.new(node.outputs[0], output.inputs["Surface"])
    return material


def named(method: str) -> str:
    """A random walk's name in this Blender."""
    return "RANDOM_WALK" if method == "RANDOM_WALK_LEGACY" and bpy.app.version < (5, 0, 0) else method


def put(material) -> None:
    """Onto the ball."""
    bpy.data.objects["Ball"].data.materials.append(material)


def subsurface(name: str) -> None:
    """A radius of a seventh of the ball's."""
    stage.pedestal(name)
    put(walking("RANDOM_WALK", Color=JADE, Radius=RED_DEEP, Scale=0.08, Anisotropy=0.3))


def subsurface_large(name: str) -> None:
    """Free paths of the ball's size, by the older law: light comes through."""
    stage.pedestal(name)
    put(walking("RANDOM_WALK_LEGACY", Color=WAX, Radius=RED_DEEP, Scale=6.0, Roughness=0.3))


def subsurface_skin(name: str) -> None:
    """Principled under its specular layer, the law for skin, a small radius, bumps, on a smooth monkey."""
    scene = stage.pedestal(name)
    bpy.data.objects.remove(bpy.data.objects["Ball"])
    material, nodes, links, output = new_material("Skin")
    node = nodes.new("ShaderNodeBsdfPrincipled")
    node.subsurface_method = "RANDOM_WALK_SKIN"
    set_inputs(
        node, Base_Color=SKIN, Roughness=0.5, Subsurface_Weight=0.8, Subsurface_Radius=RED_DEEP, Subsurface_Scale=0.04
    )
    noise, bump = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeBump")
    set_inputs(noise, Scale=9.0)
    set_inputs(bump, Strength=0.4, Distance=0.05)
    links.new(noise.outputs["Fac" if "Fac" in noise.outputs else "Factor"], bump.inputs["Height"])
    links.new(bump.outputs[0], node.inputs["Normal"])
    links.new(node.outputs[0], output.inputs["Surface"])
    bpy.ops.mesh.primitive_monkey_add(size=1.1, location=(0.0, 0.0, 0.6), rotation=(-0.5, 0.0, 0.3))
    bpy.ops.object.shade_smooth()
    item = bpy.context.object
    item.modifiers.new("Finer", "SUBSURF").render_levels = 1
    item.data.materials.append(material)
    assert item.name in scene.objects


def subsurface_textured(name: str) -> None:
    """Half of it diffuse, both parts in the colours of a checker."""
    stage.pedestal(name)
    material, nodes, links, output = new_material("Painted")
    checker, deep = nodes.new("ShaderNodeTexChecker"), nodes.new("ShaderNodeSubsurfaceScattering")
    matte, half = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeMixShader")
    deep.falloff = named("RANDOM_WALK_LEGACY")
    set_inputs(checker, Color1=SKIN, Color2=JADE, Scale=4.0)
    set_inputs(deep, Radius=RED_DEEP, Scale=1.0)
    links.new(checker.outputs["Color"], deep.inputs["Color"])
    links.new(checker.outputs["Color"], matte.inputs["Color"])
    links.new(deep.outputs[0], half.inputs[1])
    links.new(matte.outputs[0], half.inputs[2])
    links.new(half.outputs[0], output.inputs["Surface"])
    put(material)


SCENES: dict[str, Callable[[], None]] = {
    f.__name__: partial(f, f.__name__)
    for f in (subsurface, subsurface_large, subsurface_skin, subsurface_textured)
}
