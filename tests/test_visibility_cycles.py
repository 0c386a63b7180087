"""Ray Visibility, and what a view layer includes, as in Cycles; what is not heeded is named."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from photon_engine.blender.unsupported import report_afterwards  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from tests.extract_help import cube, empty_scene, extract, link, messages  # noqa: E402
from tests.stability.lab import shoot  # noqa: E402
from tests.test_light_path_cycles import cycles, plate, scene_with_camera, through  # noqa: E402

SIDES = [0, 1, 2, 13, 14, 15]  # columns of the picture: an edge lies in the middle
WORLD = (0.2, 0.4, 0.6, 1.0)
MIRROR = "ShaderNodeBsdfAnisotropic", {"Roughness": 0.0}
PANE = "ShaderNodeBsdfGlass", {"Roughness": 0.0, "IOR": 1.0001}


def stage(kind: str, inputs: dict):
    """Half of the picture shows the world, half a surface; above and below it are dark plates. Returns the plates."""
    scene = scene_with_camera(1.0)
    world = scene.world = bpy.data.worlds.new("World")
    if not world.node_tree:
        world.use_nodes = True
    next(n for n in world.node_tree.nodes if n.type == "BACKGROUND").inputs["Color"].default_value = WORLD
    plate(kind, 5.0, 0.0, through(kind, **inputs), x=5.0)
    dark = through("ShaderNodeBsdfDiffuse", Color=(0.01, 0.01, 0.01, 1.0))
    return [plate("Plate", 5.0, z, dark, x=5.0) for z in (-2.0, 3.0)]


@pytest.mark.parametrize("case", ["mirror sees", "mirror", "pane", "world", "sky", "solid"])
def test_pictures(tmp_path, case):
    plates = stage(*(PANE if case == "pane" else MIRROR))
    flag = {"mirror": "visible_glossy", "pane": "visible_transmission"}.get(case)
    for item in plates:
        if flag:
            setattr(item, flag, False)
    if case == "world":
        bpy.context.scene.world.cycles_visibility.camera = False
        for item in plates:
            item.hide_render = item.hide_viewport = True
    bpy.context.view_layer.use_sky = case != "sky"
    bpy.context.view_layer.use_solid = case != "solid"
    theirs, issues = cycles(tmp_path, 16), IssueLog()
    data = extract(issues)
    found = shoot(data, 2, caustic_photons=0, diffuse_photons=0).mean()
    assert np.abs(found - theirs)[:, SIDES].max() < 7e-3  # the light of the dark plates: noise of 0.6 * 0.01 at most
    lit = {"mirror sees": (1, 0), "mirror": (1, 1), "pane": (1, 1), "world": (0, 1), "sky": (0, 0), "solid": (1, 1)}
    assert [bool(found[:, side].mean() > 0.1) for side in (0, 15)] == [bool(x) for x in lit[case]]
    assert ("rough ones" in messages(issues, "Plate")) == (flag is not None)


def test_what_is_not_heeded_is_named():
    scene = empty_scene()
    layer, ball = bpy.context.view_layer, cube("Ball")
    layer.use_pass_mist = layer.use_pass_cryptomatte_object = True
    layer.lightgroups.add(name="Sunny")
    layer.aovs.add().name = "Mask"
    scene.render.use_simplify = scene.cycles.use_fast_gi = True
    scene.cycles.texture_limit_render, scene.cycles.use_camera_cull = "128", True
    modifier = ball.modifiers.new("Subdivision", "SUBSURF")
    (modifier if hasattr(modifier, "use_adaptive_subdivision") else ball.cycles).use_adaptive_subdivision = True
    material = through("ShaderNodeBsdfDiffuse")
    ball.data.materials.append(material)
    material.cycles.use_bump_map_correction = material.use_transparent_shadow = False
    if hasattr(ball, "visible_raycast"):  # since 5.2
        ball.visible_raycast = False
    ball.visible_diffuse, ball.is_shadow_catcher, ball.shadow_terminator_shading_offset = False, True, 0.5
    issues = IssueLog()
    extract(issues)
    of_scene, of_layer, of_ball, of_material = (
        messages(issues, name) for name in (scene.name, layer.name, "Ball", material.name)
    )
    assert "Bump Map Correction" in of_material and "Transparent Shadows" in of_material
    assert ("Raycast" in of_ball) == hasattr(ball, "visible_raycast")
    for word in ("Fast GI", "Camera Culling", "Texture Limit"):
        assert word in of_scene
    for word in ("Mist", "Cryptomatte", "light group Sunny", "AOV Mask"):
        assert word in of_layer
    for word in ("diffuse", "Adaptive Subdivision", "shadow catcher", "Shading Offset"):
        assert word in of_ball


def test_nothing_is_said_of_a_new_scene():
    empty_scene()
    cube().data.materials.append(through("ShaderNodeBsdfDiffuse"))
    issues = IssueLog()
    extract(issues)
    report_afterwards(bpy.context.scene, issues)
    assert not list(issues)


def test_what_glows_is_seen_by_all_rays_and_named():
    empty_scene()
    ball = cube("Ball")
    ball.data.materials.append(through("ShaderNodeEmission"))
    ball.visible_glossy = False
    issues = IssueLog()
    data = extract(issues)
    assert "glows" in messages(issues, "Ball") and len(data.materials[0].graph.nodes) == 1


def test_objects_share_a_material_that_some_rays_do_not_see_in_one_of_them():
    empty_scene()
    material = through("ShaderNodeBsdfDiffuse")
    for name in ("Seen", "Hidden"):
        cube(name).data.materials.append(material)
    bpy.data.objects["Hidden"].visible_glossy = False
    data = extract()
    worn = {item.name: data.materials[item.materials[0]] for item in data.instances}
    kinds = {name: [node.type for node in item.graph.nodes] for name, item in worn.items()}
    assert "ShaderNodeLightPath" in kinds["Hidden"] and "ShaderNodeLightPath" not in kinds["Seen"]
    assert worn["Hidden"].name == worn["Seen"].name


def test_the_command_line_says_what_it_does_not_do():
    scene = empty_scene()
    scene.render.use_multiview = scene.render.use_freestyle = True
    if hasattr(scene, "compositing_node_group"):
        scene.compositing_node_group = bpy.data.node_groups.new("Nodes", "CompositorNodeTree")
    else:
        scene.use_nodes = True
    scene.sequence_editor_create()
    editor = scene.sequence_editor
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    strips.new_effect(name="Colour", type="COLOR", channel=1, frame_start=1, **_length())
    link(bpy.data.objects.new("Empty", None))
    issues = IssueLog()
    report_afterwards(scene, issues)
    said = messages(issues, scene.name)
    assert all(word in said for word in ("stereo", "compositing", "video sequence", "Freestyle"))


def _length() -> dict[str, int]:
    """How long a strip is, in the words of this version."""
    return {"length": 10} if bpy.app.version >= (5, 0, 0) else {"frame_end": 10}
