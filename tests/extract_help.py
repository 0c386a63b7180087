"""Blender scenes for the tests of extraction."""

import bpy

from photon_engine.blender.extract import extract_scene
from photon_engine.issues import IssueLog
from photon_engine.scene.typed import check_record
from photon_engine.scene.validate import check_scene


def empty_scene():
    """An empty scene with a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.camera = link(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    return scene


def link(ob, collection=None):
    (collection or bpy.context.scene.collection).objects.link(ob)
    return ob


def cube(name="Cube", collection=None):
    """A cube with one quad a side."""
    me = bpy.data.meshes.new(name)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    me.from_pydata(corners, [], faces)
    return link(bpy.data.objects.new(name, me), collection)


def extract(issues=None):
    """The scene as a viewport depsgraph gives it, checked for consistency."""
    data = extract_scene(bpy.context.evaluated_depsgraph_get(), issues if issues is not None else IssueLog())
    check_record(data)
    check_scene(data)
    return data


def names(data):
    return sorted(instance.name for instance in data.instances)


def messages(issues, name):
    return " ".join(i.message for i in issues if i.object == name)
