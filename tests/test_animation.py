"""Animations in Blender with Persistent Data: what stands still is read and built for the first frame only."""

from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest

import photon_engine
from photon_engine.blender import images, keep, meshes
from photon_engine.geometry import kept
from photon_engine.transport import standing

WORK = {
    "meshes": (meshes, "extract_mesh"), "images": (images, "read_image"), "triangles": (kept, "flatten"),
    "tree": (kept, "Intersector"), "materials": (standing, "compile_material"), "emitters": (standing, "find_emitters"),
    "sky": (standing, "build_sky"), "lights": (standing, "build_lights"), "casters": (standing, "_casters"),
    "targets": (standing, "build_targets"),
}  # fmt: skip


@pytest.fixture
def counts(monkeypatch):
    """How often each kind of work was done."""
    done = dict.fromkeys(WORK, 0)

    def counted(name, function):
        def call(*arguments, **named):
            done[name] += 1
            return function(*arguments, **named)

        return call

    for name, (module, attribute) in WORK.items():
        monkeypatch.setattr(module, attribute, counted(name, getattr(module, attribute)))
    return done


def painted():
    """A material with an image in the file."""
    image = bpy.data.images.new("Paint", 4, 4)
    image.pixels.foreach_set(np.linspace(0.1, 1.0, 64, dtype=np.float32))
    image.update()
    image.pack()
    material = bpy.data.materials.new("Painted")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    material.node_tree.links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material


def shining(kind, socket, value):
    """A material of one shader node."""
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    tree = material.node_tree
    shader = tree.nodes.new(kind)
    shader.inputs[socket].default_value = value
    tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material


@pytest.fixture
def scene(tmp_path):
    """A textured floor, a glass ball, a glowing cube, a lamp, a gradient for a sky; three frames of 10 x 10 pixels."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    photon_engine.register()
    scene = bpy.context.scene
    # most of the triangles, so that positions are relative to its middle whatever else moves
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=10, y_subdivisions=10, size=12.0)
    bpy.context.object.data.materials.append(painted())
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.7, location=(0.0, 0.0, 1.0))
    bpy.context.object.name = "Ball"
    bpy.context.object.data.materials.append(shining("ShaderNodeBsdfGlass", "Roughness", 0.0))
    bpy.ops.mesh.primitive_cube_add(size=0.3, location=(2.0, 0.0, 3.0))  # higher than the ball ever is
    bpy.context.object.data.materials.append(shining("ShaderNodeEmission", "Strength", 5.0))
    bpy.ops.object.light_add(type="POINT", location=(0.0, 1.0, 4.0))
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    gradient = tree.nodes.new("ShaderNodeTexGradient")
    tree.links.new(gradient.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    bpy.ops.object.camera_add(location=(0.0, 0.0, 7.0))
    scene.camera = bpy.context.object
    scene.render.resolution_x = scene.render.resolution_y = 10
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.engine = "PHOTON_MAP"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    settings = scene.photon_map
    settings.passes, settings.caustic_photons, settings.diffuse_photons = 1, 400, 400
    yield scene
    photon_engine.unregister()


def pictures(scene, folder: Path, persistent: bool) -> list[np.ndarray]:
    """The frames of an animation."""
    keep._drop_all()
    scene.render.use_persistent_data = persistent
    scene.render.filepath = str(folder / f"{persistent}_")
    bpy.ops.render.render(animation=True)
    return [picture(folder / f"{persistent}_{frame:04d}.exr") for frame in (1, 2, 3)]


def picture(path: Path) -> np.ndarray:
    """The pixels of a file that Blender wrote."""
    pixels = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)
    assert pixels.shape[:2] == (10, 10) and pixels[..., :3].any()
    return pixels


def move(ob, axis):
    """Another place in each of three frames."""
    for frame in (1, 3):
        ob.location[axis] += 0.1 * frame
        ob.keyframe_insert("location", frame=frame)


def test_a_moving_camera_costs_nothing_but_rays(scene, counts, tmp_path):
    move(scene.camera, 0)
    frames = pictures(scene, tmp_path, persistent=True)
    once = {**dict.fromkeys(WORK, 1), "meshes": 3, "materials": 3}
    assert counts == once
    fresh = []
    for frame in (1, 2, 3):
        keep._drop_all()
        scene.render.use_persistent_data = False
        scene.frame_set(frame)
        scene.render.filepath = str(tmp_path / f"alone_{frame}.exr")
        bpy.ops.render.render(write_still=True)
        fresh.append(picture(tmp_path / f"alone_{frame}.exr"))
    for one, alone in zip(frames, fresh, strict=True):
        np.testing.assert_array_equal(one, alone)
    assert counts == {name: 4 * count for name, count in once.items()}  # they were made anew


def test_a_moving_object_costs_what_depends_on_it(scene, counts, tmp_path):
    move(bpy.data.objects["Ball"], 2)
    frames = pictures(scene, tmp_path, persistent=True)
    thrice = {"triangles", "tree", "casters", "targets"}
    assert counts == {
        **dict.fromkeys(WORK, 1), "meshes": 3, "materials": 3, **dict.fromkeys(thrice, 3)
    }  # fmt: skip
    for one, fresh in zip(frames, pictures(scene, tmp_path, persistent=False), strict=True):
        np.testing.assert_array_equal(one, fresh)


def rendered(scene, path: Path) -> np.ndarray:
    """One picture, with what the last one left."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return picture(path)


def test_persistent_data_keeps_all_between_renders_until_an_image_changes(scene, counts, tmp_path):
    scene.render.use_persistent_data = True
    one = rendered(scene, tmp_path / "one.exr")
    once = dict(counts)
    np.testing.assert_array_equal(rendered(scene, tmp_path / "two.exr"), one)
    assert counts == once
    image = bpy.data.images["Paint"]
    image.pixels.foreach_set(np.linspace(1.0, 0.1, 64, dtype=np.float32))
    image.update()
    edits = [lambda: None, image.pack, lambda: image.save(filepath=str(tmp_path / "paint.png")), image.reload]
    for i, edit in enumerate(edits):  # painted, packed, then in a file, which is read again
        edit()
        painted = rendered(scene, tmp_path / f"painted_{i}.exr")
        keep._drop_all()
        np.testing.assert_array_equal(rendered(scene, tmp_path / "fresh.exr"), painted)
        assert not np.array_equal(painted, one)


def test_a_file_that_is_written_again_and_reloaded_is_read_again(scene, counts, tmp_path):
    scene.render.use_persistent_data = True
    image, path = bpy.data.images["Paint"], tmp_path / "paint.png"
    image.save(filepath=str(path))
    image.unpack(method="REMOVE")
    image.filepath = str(path)
    image.reload()
    one = rendered(scene, tmp_path / "one.exr")
    read = counts["images"]
    other = bpy.data.images.new("Other", 4, 4)
    other.pixels.foreach_set(np.linspace(1.0, 0.1, 64, dtype=np.float32))
    other.save(filepath=str(path))
    bpy.data.images.remove(other)
    image.reload()
    assert not np.array_equal(rendered(scene, tmp_path / "two.exr"), one) and counts["images"] == read + 1
    rendered(scene, tmp_path / "three.exr")
    assert counts["images"] == read + 1
