"""Settings of the scene, the view layer and objects that this engine does not heed: each is named once."""

from __future__ import annotations

from typing import Any

from ..issues import IssueLog
from .passes import wanted_passes

# passes of Blender and Cycles; this engine has its own, chosen under View Layer > Photon Map
PASS_FLAGS = "use_pass_", "pass_"
REMEDY = "blender -b FILE -E PHOTON_MAP -f 1 does it"
OWN_FLAGS = {"use_pass_combined", "use_pass_cryptomatte_accurate"}


def report_scene(scene: Any, layer: Any, issues: IssueLog) -> None:
    """What of the scene's and view layer's settings has no effect."""
    passes = foreign_passes(layer)
    if passes:
        text = f"these passes are not made: {', '.join(passes)}"
        issues.warn(layer.name, text, "choose passes of Photon Map's own in the View Layer tab")
    cycles = getattr(scene, "cycles", None)
    if getattr(cycles, "use_fast_gi", False):
        issues.info(scene.name, "Fast GI Approximation has no effect: light between surfaces is computed")
    if scene.render.use_simplify and cycles is not None:
        ignored = [text for name, text in (("use_camera_cull", "Camera Culling"), ("use_distance_cull",
                   "Distance Culling")) if getattr(cycles, name, False)]  # fmt: skip
        if getattr(cycles, "texture_limit_render", "OFF") != "OFF":
            ignored.append("Texture Limit")
        if ignored:
            issues.info(scene.name, f"Simplify > {', '.join(ignored)} has no effect: nothing is left out")


def report_afterwards(scene: Any, issues: IssueLog) -> None:
    """What Blender would do besides or after rendering, and the command line does not."""
    render = scene.render
    if render.use_multiview:
        issues.warn(scene.name, "stereo views are not supported yet: one view is rendered")
    if render.use_freestyle:
        issues.info(scene.name, "Freestyle lines are not drawn here", REMEDY)
    nodes = scene.compositing_node_group if hasattr(scene, "compositing_node_group") else scene.use_nodes
    if render.use_compositing and nodes:
        issues.info(scene.name, "compositing nodes are not run here", REMEDY)
    if render.use_sequencer and scene.sequence_editor is not None and len(scene.sequence_editor.strips):
        issues.info(scene.name, "the video sequence is not made here: its scene is rendered")


def foreign_passes(layer: Any) -> list[str]:
    """Names of passes that the view layer asks of other engines, light groups and shader AOVs among them."""
    own = {item.name for item in wanted_passes(layer)} if hasattr(layer, "photon_map") else set()
    found = []
    for owner in (layer, getattr(layer, "cycles", None)):
        for item in owner.bl_rna.properties if owner is not None else ():
            name = item.identifier
            asked = name.startswith(PASS_FLAGS) and name not in OWN_FLAGS and getattr(owner, name) is True
            if asked and item.name not in own:
                found.append(item.name or name)
    found += [f"light group {group.name}" for group in layer.lightgroups]
    return found + [f"AOV {aov.name}" for aov in layer.aovs]


def report_object(ob: Any, name: str, issues: IssueLog) -> None:
    """What of a mesh object's settings has no effect. name : of the object or instance, for messages"""
    if ob.shadow_terminator_shading_offset != 0.0:
        issues.warn(name, "Shadow Terminator > Shading Offset is not supported: it has no effect")
    if ob.is_shadow_catcher:
        issues.warn(name, "shadow catchers are not supported yet: it is rendered as an ordinary object")
    if not getattr(ob, "visible_raycast", True):  # since Blender 5.2
        issues.warn(name, "Ray Visibility > Raycast is not supported: Raycast nodes see it")
    adaptive = getattr(getattr(ob, "cycles", None), "use_adaptive_subdivision", False)  # Blender 4.5
    for modifier in ob.modifiers:
        if not modifier.show_render:
            continue
        if modifier.type == "SUBSURF" and (adaptive or getattr(modifier, "use_adaptive_subdivision", False)):
            issues.warn(name, "Adaptive Subdivision is not supported: it is divided by Levels Render", "raise them")
        elif modifier.type == "FLUID" and _is_smoke(modifier):
            issues.warn(name, "smoke and fire are not supported yet: they are not rendered")


def report_material(material: Any, issues: IssueLog) -> None:
    """What of a material's settings has no effect."""
    if not getattr(getattr(material, "cycles", None), "use_bump_map_correction", True):
        issues.warn(material.name, "Bump Map Correction cannot be switched off: bumps are corrected")
    if not getattr(material, "use_transparent_shadow", True):
        issues.warn(material.name, "Transparent Shadows cannot be switched off: light passes where it is transparent")


def _is_smoke(modifier: Any) -> bool:
    """Whether a fluid modifier fills its object with gas."""
    domain = modifier.domain_settings if modifier.fluid_type == "DOMAIN" else None
    return domain is not None and domain.domain_type == "GAS"
