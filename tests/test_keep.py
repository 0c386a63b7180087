"""Frames of an animation: only what Blender evaluated anew is extracted, and only what moved is built into a tree."""

import bpy
import numpy as np
import pytest

from photon_engine.blender.extract import extract_scene
from photon_engine.blender.keep import Keep
from photon_engine.geometry.kept import Kept
from photon_engine.issues import IssueLog


class Recorder(bpy.types.RenderEngine):
    """Extracts each frame with what the frame before left, and without."""

    bl_idname = "PHOTON_MAP_KEEP_TEST"
    bl_label = "Keep"
    keep = None
    frames: list = []  # noqa: RUF012

    def render(self, depsgraph):
        cls = type(self)
        before = cls.keep.extracted, cls.keep.geometry.built
        cls.keep.begin(depsgraph, animation=self.is_animation)
        scene = extract_scene(depsgraph, IssueLog(), keep=cls.keep)
        cls.keep.geometry.flatten(scene, IssueLog())
        cls.keep.geometry.intersector()
        done = cls.keep.extracted - before[0], cls.keep.geometry.built - before[1]
        cls.frames.append((*done, scene, extract_scene(depsgraph, IssueLog())))
        self.end_result(self.begin_result(0, 0, 8, 8))


@pytest.fixture
def animation(tmp_path):
    """A still cube and a moving camera, three frames; fill in what else moves, then call it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.camera_add()
    scene.camera = bpy.context.object
    move(scene.camera)
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.filepath = str(tmp_path / "frame_")
    bpy.utils.register_class(Recorder)

    def run(persistent):
        scene.render.use_persistent_data = persistent
        scene.render.engine = Recorder.bl_idname
        Recorder.keep, Recorder.frames = Keep(), []
        Recorder.keep.geometry = Kept()
        bpy.ops.render.render(animation=True)
        for _, _, kept, anew in Recorder.frames:
            for a, b in zip(kept.meshes, anew.meshes, strict=True):
                np.testing.assert_array_equal(a.positions, b.positions)
                np.testing.assert_array_equal(a.triangles, b.triangles)
        return [frame[:2] for frame in Recorder.frames]

    yield run
    bpy.utils.unregister_class(Recorder)
    Recorder.frames = []


def move(ob):
    """Another place in each of three frames."""
    for frame in (1, 3):
        ob.location.x = frame
        ob.keyframe_insert("location", frame=frame)


def test_a_moving_camera_costs_no_extraction_and_no_tree(animation):
    assert animation(persistent=True) == [(1, 1), (0, 0), (0, 0)]


def test_without_persistent_data_the_tree_is_kept(animation):
    assert animation(persistent=False) == [(1, 1), (1, 0), (1, 0)]


def test_a_moving_object_costs_a_tree_but_no_extraction(animation):
    bpy.ops.mesh.primitive_cube_add()
    move(bpy.context.object)
    assert animation(persistent=True) == [(2, 1), (0, 1), (0, 1)]


def test_what_deforms_is_read_again(animation):
    bpy.ops.mesh.primitive_monkey_add()
    bpy.context.object.modifiers.new("Wave", "WAVE")
    bpy.ops.mesh.primitive_cube_add()
    ob = bpy.context.object
    ob.shape_key_add(name="Basis")
    key = ob.shape_key_add(name="Up")
    key.data[0].co.z = 3.0
    for frame, value in ((1, 0.0), (3, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bones = bpy.data.armatures.new("Bones")
    rig = bpy.data.objects.new("Rig", bones)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bones.edit_bones.new("Bone").tail = (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_cube_add()
    skin = bpy.context.object
    skin.vertex_groups.new(name="Bone").add(range(8), 1.0, "ADD")
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    pose = rig.pose.bones["Bone"]
    for frame in (1, 3):
        pose.location.x = frame
        pose.keyframe_insert("location", frame=frame)
    done = animation(persistent=True)
    assert done[0] == (4, 1) and all(extracted == 3 and built == 1 for extracted, built in done[1:])
