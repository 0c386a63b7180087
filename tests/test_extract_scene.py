"""From Blender scenes to SceneData: what is seen, where, in which materials; lamps and world in Cycles' units."""

import math
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest

from photon_engine.blender.compat import DEFAULT_PRINCIPLED
from photon_engine.blender.extract import extract_scene
from photon_engine.issues import IssueLog, RenderError
from photon_engine.plan import make_plan
from photon_engine.scene.io import load_scene, save_scene
from photon_engine.settings import Settings
from tests.extract_help import cube, empty_scene, extract, link, messages, names

SHARED = Path(__file__).resolve().parents[2] / "shared" / "scenes"


@pytest.fixture(autouse=True, name="scene")
def fresh_scene():
    return empty_scene()


def test_every_kind_that_can_become_a_mesh():
    bpy.ops.object.text_add()
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.context.object.data.bevel_depth = 0.1
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    bpy.ops.object.metaball_add()
    bpy.ops.object.metaball_add(location=(0.5, 0.0, 0.0))
    cube().modifiers.new("Subdivision", "SUBSURF").levels = 2
    issues = IssueLog()
    data = extract(issues)
    assert names(data) == ["BézierCircle", "Cube", "Mball", "SurfSphere", "Text"]
    by_name = {i.name: data.meshes[i.mesh] for i in data.instances}
    assert len(by_name["Cube"].triangles) == 6 * 4**2 * 2
    assert not list(issues)


def test_instances_share_a_mesh_and_have_their_own_matrix(scene):
    collection = bpy.data.collections.new("Part")
    original = cube(collection=collection)
    original.location = (0.0, 0.0, 2.0)
    for i, scale in enumerate(((1, 1, 1), (-1, 1, 1))):
        empty = link(bpy.data.objects.new(f"Empty{i}", None))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.scale = (3.0 * i, 0.0, 0.0), scale
    data = extract()
    assert len(data.meshes) == 1 and len(data.instances) == 2
    assert names(data) == ["Empty0/Cube", "Empty1/Cube"]
    second = next(i for i in data.instances if i.name.startswith("Empty1"))
    expected = np.diag([-1.0, 1.0, 1.0, 1.0])
    expected[:3, 3] = (3.0, 0.0, 2.0)
    np.testing.assert_allclose(second.matrix, expected, atol=1e-6)
    assert len({i.random for i in data.instances}) == 2


def test_particles_instance_objects_and_hide_their_emitter():
    part = cube("Part")
    bpy.ops.mesh.primitive_plane_add()
    emitter = bpy.context.object
    emitter.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = emitter.particle_systems[0].settings
    settings.type, settings.count, settings.render_type, settings.instance_object = "HAIR", 5, "OBJECT", part
    emitter.show_instancer_for_viewport = False
    data = extract()
    assert names(data) == ["Part"] + ["Plane/Part"] * 5
    assert len(data.meshes) == 1


def geometry_nodes(ob, build):
    """Give an object a geometry-nodes modifier; ``build(nodes, links, input, output)`` fills it."""
    group = bpy.data.node_groups.new("Group", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket(name="Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    first, last = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    build(group.nodes, group.links, first.outputs[0], last.inputs[0])
    ob.modifiers.new("Nodes", "NODES").node_group = group


def test_geometry_nodes_instances_with_their_own_material():
    red = bpy.data.materials.new("Red")

    def build(nodes, links, source, target):
        box, paint = nodes.new("GeometryNodeMeshCube"), nodes.new("GeometryNodeSetMaterial")
        scatter, join = nodes.new("GeometryNodeInstanceOnPoints"), nodes.new("GeometryNodeJoinGeometry")
        paint.inputs["Material"].default_value = red
        links.new(box.outputs[0], paint.inputs[0])
        links.new(paint.outputs[0], scatter.inputs["Instance"])
        links.new(source, scatter.inputs["Points"])
        links.new(scatter.outputs[0], join.inputs[0])
        links.new(source, join.inputs[0])
        links.new(join.outputs[0], target)

    ob = cube()
    geometry_nodes(ob, build)
    data = extract()
    assert len(data.instances) == 9 and len(data.meshes) == 2
    base, *others = sorted(data.instances, key=lambda i: i.mesh)
    slots = data.meshes[others[0].mesh].material_index
    assert all(data.materials[others[0].materials[slot]].name == "Red" for slot in slots)
    assert all(data.materials[m].name == "(no material)" if DEFAULT_PRINCIPLED else m == -1 for m in base.materials)


def test_slots_of_object_and_data_and_indices_beyond_them():
    a, b = (bpy.data.materials.new(k) for k in "AB")
    first = cube("First")
    me = first.data
    for material in (a, a):
        me.materials.append(material)
    me.polygons.foreach_set("material_index", np.array([0, 1, 5, 0, 1, 0], np.int32))
    second = link(bpy.data.objects.new("Second", me))
    second.material_slots[1].link = "OBJECT"
    second.material_slots[1].material = b
    data = extract()
    assert len(data.meshes) == 1
    by_name = {i.name: [data.materials[m].name for m in i.materials] for i in data.instances}
    # slot 5 is beyond the last: Cycles uses the last
    assert by_name == {"First": ["A"] * 6, "Second": ["A"] + ["B"] * 5}


def test_materials_and_images_that_no_face_wears_are_not_read():
    """They are named only, unless another object wears them."""
    painted = bpy.data.materials.new("Painted")
    if not painted.node_tree:
        painted.use_nodes = True
    nodes, links = painted.node_tree.nodes, painted.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Paint", 4, 4)
    links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    first = cube("First")
    first.data.uv_layers.new(name="UVMap")
    for material in (painted, bpy.data.materials.new("Plain")):
        first.data.materials.append(material)
    first.data.polygons.foreach_set("material_index", np.ones(6, np.int32))
    data = extract()
    assert [m.name for m in data.materials] == ["Painted", "Plain"] and not data.images and not data.meshes[0].uvs
    assert not data.materials[0].graph.nodes and data.materials[1].graph.nodes
    assert make_plan(data, Settings()).unworn.reason == "Painted"
    cube("Second").data.materials.append(painted)
    data = extract()
    assert [m.name for m in data.materials] == ["Painted", "Plain"] and len(data.images) == 1
    assert data.materials[0].graph.nodes and make_plan(data, Settings()).unworn.reason == "there is none"
    first.data.polygons[0].material_index = 0
    data = extract()
    assert len(data.images) == 1 and all(mesh.uvs or mesh.name != first.data.name for mesh in data.meshes)


def test_material_override_of_the_view_layer(scene):
    ob = cube()
    ob.data.materials.append(bpy.data.materials.new("A"))
    bpy.context.view_layer.material_override = bpy.data.materials.new("Clay")
    data = extract()
    assert [m.name for m in data.materials] == ["Clay"]


def test_what_is_hidden_in_renders(scene):
    cube("Hidden").hide_render = True
    collection = bpy.data.collections.new("Off")
    scene.collection.children.link(collection)
    collection.hide_render = True
    both = cube("Both", collection)
    cube("Gone", collection)
    link(both)
    assert names(extract()) == ["Both"]


def test_visibility_holdout_and_indirect_only(scene):
    cube("NoCamera").visible_camera = False
    cube("NoShadow").visible_shadow = False
    cube("Hole").is_holdout = True
    invisible = cube("Invisible")
    for ray in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(invisible, f"visible_{ray}", False)
    cube("Odd").visible_glossy = False
    for name in ("HoleToo", "Indirect"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        cube(name, collection)
    layers = bpy.context.view_layer.layer_collection.children
    layers["HoleToo"].holdout = True
    layers["Indirect"].indirect_only = True
    issues = IssueLog()
    flags = {i.name: (i.holdout, i.visible_camera, i.visible_shadow) for i in extract(issues).instances}
    assert flags == {
        "NoCamera": (False, False, True), "NoShadow": (False, True, False), "Hole": (True, True, True),
        "HoleToo": (True, True, True), "Indirect": (False, False, True), "Odd": (False, True, True),
    }  # fmt: skip
    assert "glossy" in messages(issues, "Odd")


def test_holdout_of_an_instancer_reaches_its_instances():
    collection = bpy.data.collections.new("Part")
    cube(collection=collection)
    empty = link(bpy.data.objects.new("Empty", None))
    empty.instance_type, empty.instance_collection, empty.is_holdout = "COLLECTION", collection, True
    assert extract().instances[0].holdout


@pytest.mark.parametrize("kind", ["VOLUME", "CURVES", "POINTCLOUD"])
def test_unsupported_objects_are_named(kind):
    make = {"VOLUME": "volumes", "CURVES": "hair_curves", "POINTCLOUD": "pointclouds"}
    ob = link(bpy.data.objects.new("Thing", getattr(bpy.data, make[kind]).new("Thing")))
    assert ob.type == kind
    issues = IssueLog()
    assert not extract(issues).instances
    assert "not supported" in messages(issues, "Thing")


def test_strands_are_named():
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.modifiers.new("Hair", "PARTICLE_SYSTEM")
    bpy.context.object.particle_systems[0].settings.type = "HAIR"
    issues = IssueLog()
    assert names(extract(issues)) == ["Plane"]
    assert "hair" in messages(issues, "Plane")


def test_bad_meshes_are_left_out_with_their_instances():
    cube("Good")
    for name in ("Empty", "NaN"):
        me = cube(name).data
        if name == "NaN":
            me.vertices.foreach_set("co", np.full(24, np.nan, np.float32))
        else:
            me.clear_geometry()
    issues = IssueLog()
    data = extract(issues)
    assert names(data) == ["Good"] and len(data.meshes) == 1
    assert messages(issues, "NaN") and messages(issues, "Empty")


def test_needs_follow_the_materials():
    ob = cube()
    ob.data.uv_layers.new(name="UVMap")
    ob.data.attributes.new("heat", "FLOAT", "POINT")
    material = bpy.data.materials.new("A")
    if not material.node_tree:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    ob.data.materials.append(material)
    surface = nodes["Principled BSDF"]
    mesh = extract().meshes[0]
    assert mesh.generated is None and not mesh.attributes and not mesh.tangents and not mesh.uvs
    coordinates, read, bump = (nodes.new(f"ShaderNode{k}") for k in ("TexCoord", "VertexColor", "NormalMap"))
    read.layer_name = "heat"
    links.new(coordinates.outputs["Generated"], surface.inputs["Base Color"])
    links.new(read.outputs["Color"], surface.inputs["Roughness"])
    links.new(bump.outputs["Normal"], surface.inputs["Normal"])
    mesh = extract().meshes[0]
    np.testing.assert_allclose(mesh.generated, (mesh.positions + 1.0) / 2.0, atol=1e-6)
    assert list(mesh.attributes) == ["heat"] and list(mesh.tangents) == ["UVMap"] and list(mesh.uvs) == ["UVMap"]


def test_film_settings(scene):
    scene.cycles.film_exposure = 2.0
    scene.cycles.pixel_filter_type = "GAUSSIAN"
    scene.cycles.filter_width = 2.5
    scene.render.film_transparent = True
    frame = extract().frame
    assert (frame.exposure, frame.filter, frame.filter_width, frame.transparent) == (2.0, "GAUSSIAN", 2.5, True)
    scene.cycles.pixel_filter_type = "BOX"
    scene.update_tag()  # an add-on's property does not say by itself that it changed
    assert extract().frame.filter_width == 1.0


def test_another_camera_and_none(scene):
    other = link(bpy.data.objects.new("Other", bpy.data.cameras.new("Other")))
    data = extract_scene(bpy.context.evaluated_depsgraph_get(), IssueLog(), camera=other)
    assert data.camera.name == "Other"
    scene.camera = None
    with pytest.raises(RenderError, match="no camera"):
        extract()


def test_motion_blur_is_reported(scene):
    scene.render.use_motion_blur = True
    issues = IssueLog()
    extract(issues)
    assert "motion blur" in messages(issues, "Scene")


def test_undefined_transforms_are_reported():
    ob = cube()
    ob.matrix_world = [[math.nan] * 4] * 4
    ob.location = (math.nan, 0.0, 0.0)
    issues = IssueLog()
    assert not extract(issues).instances
    assert "transform" in messages(issues, "Cube")


def test_random_numbers_are_those_of_cycles(scene, tmp_path):
    """Object Info > Random of an object and two instances, as Cycles shows it."""
    material = bpy.data.materials.new("Random")
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    info, emission, output = (tree.nodes.new(f"ShaderNode{k}") for k in ("ObjectInfo", "Emission", "OutputMaterial"))
    tree.links.new(info.outputs["Random"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    collection = bpy.data.collections.new("Part")
    shown = [cube("Würfel"), cube("Cube.001", collection)]
    for i in range(2):
        empty = link(bpy.data.objects.new(f"Empty{i}", None))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location = (4.0 * (i + 1), 0.0, 0.0)
    for ob in shown:
        ob.data.materials.append(material)
    scene.camera.location = (4.0, 0.0, 10.0)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 12.0
    scene.render.resolution_x, scene.render.resolution_y = 12, 4  # a pixel a metre
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.filter_width = 1, False, 0.01
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(tmp_path / "random.exr")
    bpy.ops.render.render(write_still=True)
    source = oiio.ImageInput.open(scene.render.filepath)
    theirs = np.asarray(source.read_image(0, 0, 0, 1, oiio.FLOAT)).reshape(4, 12)[2, [2, 6, 10]]
    source.close()
    ours = [i.random for i in sorted(extract().instances, key=lambda i: i.matrix[0, 3])]
    np.testing.assert_allclose(ours, theirs, rtol=1e-6)  # single precision there


@pytest.mark.parametrize("name", ["blenderdiplom_glass", "clevr_objects"])
def test_shared_scenes_survive_saving(name, tmp_path):
    path = SHARED / f"{name}.blend"
    if not path.exists():
        pytest.skip(f"{path} is not part of a plain clone")
    bpy.ops.wm.open_mainfile(filepath=str(path))
    issues = IssueLog()
    data = extract(issues)
    assert data.instances and data.lights
    save_scene(data, tmp_path / "scene.npz")
    again = load_scene(tmp_path / "scene.npz")
    assert repr(again) == repr(data)
    for a, b in zip(data.meshes, again.meshes, strict=True):
        np.testing.assert_array_equal(a.positions, b.positions)
        np.testing.assert_array_equal(a.triangles, b.triangles)
