"""Mesh extraction: fast paths against Blender's element-wise accessors, and everything a mesh may carry."""


import bpy
import numpy as np
import pytest

from photon_engine.blender import meshes
from photon_engine.blender.meshes import MeshNeeds, extract_mesh
from photon_engine.issues import IssueLog, Severity

NOTHING = MeshNeeds()
ACTIVE_UV = MeshNeeds(uvs=frozenset({""}))


@pytest.fixture(autouse=True)
def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def evaluated(ob):
    """The evaluated mesh of an object."""
    return ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def add(name, positions, faces):
    """An object with that mesh, in the scene."""
    me = bpy.data.meshes.new(name)
    me.from_pydata(positions, [], faces)
    ob = bpy.data.objects.new(name, me)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def monkey():
    """A mesh with triangles and quads, three UV layers, two slots, some faces smooth."""
    bpy.ops.mesh.primitive_monkey_add()
    ob = bpy.context.object
    me = ob.data
    rng = np.random.default_rng(1)
    for name in ("second", "third"):
        me.uv_layers.new(name=name).uv.foreach_set("vector", rng.random(len(me.loops) * 2, np.float32))
    me.uv_layers["second"].active_render = True
    me.polygons.foreach_set("material_index", rng.integers(0, 2, len(me.polygons)).astype(np.int32))
    me.polygons.foreach_set("use_smooth", rng.integers(0, 2, len(me.polygons)).astype(bool))
    for k in "AB":
        me.materials.append(bpy.data.materials.new(k))
    return ob


def naive(me):
    """Twin of extract_mesh, triangle by triangle, corner by corner."""
    corners = [(t, loop) for t in me.loop_triangles for loop in t.loops]
    shape = (len(me.loop_triangles), 3)
    positions = np.array([v.co for v in me.vertices], np.float32)
    normals = np.array([me.corner_normals[loop].vector for _, loop in corners], np.float32).reshape(*shape, 3)
    for i, t in enumerate(me.loop_triangles):
        if not me.polygons[t.polygon_index].use_smooth:
            a, b, c = (np.array(me.vertices[v].co, np.float64) for v in t.vertices)
            normals[i] = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    uvs = {
        layer.name: np.array([layer.uv[loop].vector for _, loop in corners], np.float32).reshape(*shape, 2)
        for layer in me.uv_layers
    }
    triangles = np.array([t.vertices for t in me.loop_triangles], np.int32)
    slots = np.array([me.polygons[t.polygon_index].material_index for t in me.loop_triangles], np.int32)
    return positions, triangles, normals, uvs, slots


def test_extraction_equals_its_naive_twin():
    me = evaluated(monkey())
    mesh = extract_mesh(me, "Suzanne", MeshNeeds(uvs=frozenset({"UVMap", "", "third"})), IssueLog())
    positions, triangles, normals, uvs, slots = naive(me)
    np.testing.assert_array_equal(mesh.positions, positions)
    np.testing.assert_array_equal(mesh.triangles, triangles)
    np.testing.assert_array_equal(mesh.material_index, slots)
    assert list(mesh.uvs) == ["UVMap", "second", "third"] and mesh.active_uv == "second"
    for name, uv in uvs.items():
        np.testing.assert_array_equal(mesh.uvs[name], uv)
    # Blender keeps some normals as 16-bit numbers; flat ones are computed in double here and there
    np.testing.assert_allclose(mesh.normals, normals, atol=2e-6)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=2), 1.0, atol=1e-4)


def test_the_look_at_memory_equals_the_slow_path():
    me = evaluated(monkey())
    np.testing.assert_array_equal(meshes.triangle_loops(me), meshes.triangle_loops_slow(me))


def test_a_wrong_memory_layout_falls_back(monkeypatch):
    """When addresses do not step by one triangle, or hold something else, the slow path is taken."""
    me = evaluated(monkey())
    expected = meshes.triangle_loops_slow(me)
    calls = []
    monkeypatch.setattr(meshes, "triangle_loops_slow", lambda mesh: calls.append(1) or expected)

    class Triangle:
        def __init__(self, address, loops):
            self.address, self.loops = address, loops

        def as_pointer(self):
            return self.address

    class Fake:
        def __init__(self, stride, loops):
            block = np.zeros((len(expected), 3), np.int32)
            self.keep = block
            self.loop_triangles = [Triangle(block.ctypes.data + stride * i, loops) for i in range(len(expected))]

    for fake in (Fake(16, (0, 0, 0)), Fake(12, (7, 8, 9))):
        np.testing.assert_array_equal(meshes.triangle_loops(fake), expected)
    assert len(calls) == 2


def test_flat_meshes_have_no_normals_and_one_slot_no_indices():
    bpy.ops.mesh.primitive_cube_add()
    mesh = extract_mesh(evaluated(bpy.context.object), "Cube", NOTHING, IssueLog())
    assert mesh.normals is None and mesh.material_index is None and mesh.generated is None
    assert mesh.triangles.shape == (12, 3)


def test_custom_normals_are_kept():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3)
    me = bpy.context.object.data
    bpy.ops.object.shade_smooth()
    tilted = np.array((0.6, 0.0, 0.8))
    me.normals_split_custom_set([tilted] * len(me.loops))
    mesh = extract_mesh(evaluated(bpy.context.object), "Grid", NOTHING, IssueLog())
    # custom normals are stored as two 16-bit angles
    np.testing.assert_allclose(mesh.normals, np.broadcast_to(tilted, mesh.normals.shape), atol=1e-3)


def test_smooth_by_angle_splits_at_sharp_edges():
    bpy.ops.mesh.primitive_cylinder_add(vertices=64)
    ob = bpy.context.object
    bpy.ops.object.shade_smooth_by_angle(angle=0.5)
    mesh = extract_mesh(evaluated(ob), "Cylinder", NOTHING, IssueLog())
    geometric = meshes.triangle_normals(mesh.positions, mesh.triangles)
    caps = np.abs(geometric[:, 2]) > 0.9
    np.testing.assert_allclose(mesh.normals[caps], geometric[caps][:, None].repeat(3, 1), atol=1e-3)
    p = mesh.positions[mesh.triangles[~caps]]
    radial = p * (1.0, 1.0, 0.0)
    np.testing.assert_allclose(mesh.normals[~caps], radial / np.linalg.norm(radial, axis=2, keepdims=True), atol=2e-3)


def test_generated_coordinates_are_those_before_deformation():
    bpy.ops.mesh.primitive_cube_add(size=2.0)
    ob = bpy.context.object
    ob.modifiers.new("Displace", "DISPLACE").strength = 0.5
    rest = np.array([v.co for v in ob.data.vertices])
    # Blender keeps the coordinates from before deformation in final renders only
    found = []

    class Reader(bpy.types.RenderEngine):
        bl_idname, bl_label = "TEST_GENERATED", "Test"

        def render(self, depsgraph):
            me = depsgraph.scene_eval.objects["Cube"].evaluated_get(depsgraph).data
            found.append(extract_mesh(me, "Cube", MeshNeeds(generated=True), IssueLog()))

    bpy.utils.register_class(Reader)
    try:
        scene = bpy.context.scene
        scene.render.engine = "TEST_GENERATED"
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        bpy.ops.render.render()
    finally:
        bpy.utils.unregister_class(Reader)
    assert np.abs(found[0].positions - rest).max() > 0.1
    np.testing.assert_allclose(found[0].generated, (rest + 1.0) / 2.0, atol=1e-6)


def test_texture_space_can_be_set_by_hand():
    bpy.ops.mesh.primitive_plane_add(size=2.0)
    me = bpy.context.object.data
    me.use_auto_texspace = False
    me.texspace_location, me.texspace_size = (1.0, 0.0, 0.0), (2.0, 1.0, 4.0)
    mesh = extract_mesh(evaluated(bpy.context.object), "Plane", MeshNeeds(generated=True), IssueLog())
    expected = (mesh.positions - (1.0, 0.0, 0.0)) / (4.0, 2.0, 8.0) + 0.5
    np.testing.assert_allclose(mesh.generated, expected, atol=1e-6)


@pytest.mark.parametrize("domain", ["POINT", "EDGE", "FACE", "CORNER"])
@pytest.mark.parametrize("kind", ["FLOAT", "FLOAT_VECTOR", "FLOAT_COLOR", "INT", "BOOLEAN", "FLOAT2"])
def test_attributes_of_each_domain_and_type(domain, kind):
    ob = add("Two", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)])
    key, width = meshes.COMPONENTS[kind]
    attribute = ob.data.attributes.new("x", kind, domain)
    values = np.random.default_rng(2).integers(0, 2, (len(attribute.data), width))
    attribute.data.foreach_set(key, values.ravel().astype(meshes.READ_TYPES.get(kind, np.float32)))
    me = evaluated(ob)
    mesh = extract_mesh(me, "Two", MeshNeeds(attributes=frozenset({"x", "absent"})), IssueLog())
    assert list(mesh.attributes) == ["x"]
    edges = [tuple(e.vertices) for e in me.edges]
    for i, t in enumerate(me.loop_triangles):
        for c in range(3):
            at = {"POINT": t.vertices[c], "FACE": t.polygon_index, "CORNER": t.loops[c]}
            if domain == "EDGE":
                around = [values[e] for e, ends in enumerate(edges) if t.vertices[c] in ends]
                expected = np.mean(around, axis=0)
                if kind == "BOOLEAN":
                    expected = np.max(around, axis=0)
                elif kind == "INT":
                    expected = np.floor(expected + 0.5)
            else:
                expected = values[at[domain]]
            np.testing.assert_allclose(mesh.attributes["x"][i, c], expected, atol=1e-6)


def test_byte_colours_are_linear_and_the_active_one_has_no_name():
    ob = add("Tri", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    layer = ob.data.color_attributes.new("Col", "BYTE_COLOR", "CORNER")
    for item in layer.data:
        item.color_srgb = (0.5, 1.0, 0.0, 1.0)
    mesh = extract_mesh(evaluated(ob), "Tri", MeshNeeds(attributes=frozenset({""})), IssueLog())
    # sRGB 0.5 (128 of 255) is 0.2159 linear
    np.testing.assert_allclose(mesh.attributes[""][0, 0], (0.2159, 1.0, 0.0, 1.0), atol=2e-4)


def test_undefined_vertices_lose_their_faces_and_are_reported():
    ob = add("Broken", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (np.nan, 1, 0)], [(0, 1, 2), (1, 3, 2)])
    ob.data.materials.append(bpy.data.materials.new("A"))
    ob.data.polygons[1].material_index = 1
    issues = IssueLog()
    mesh = extract_mesh(evaluated(ob), "Broken", NOTHING, issues)
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    assert np.isfinite(mesh.positions).all()
    assert [(i.object, i.severity) for i in issues] == [("Broken", Severity.WARNING)]


def test_nothing_is_left_of_a_mesh_without_faces():
    issues = IssueLog()
    assert extract_mesh(evaluated(add("Wire", [(0, 0, 0), (1, 0, 0)], [])), "Wire", NOTHING, issues) is None
    assert next(iter(issues)).object == "Wire"
    issues = IssueLog()
    bad = add("Bad", [(np.inf, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    assert extract_mesh(evaluated(bad), "Bad", NOTHING, issues) is None
    assert next(iter(issues)).object == "Bad"


def test_uvs_that_nothing_reads_are_not_allocated():
    me = evaluated(monkey())
    assert extract_mesh(me, "Suzanne", NOTHING, IssueLog()).uvs == {}
    mesh = extract_mesh(me, "Suzanne", MeshNeeds(uvs=frozenset({"third"})), IssueLog())
    assert list(mesh.uvs) == ["third"] and mesh.active_uv == "second"
    assert list(extract_mesh(me, "Suzanne", ACTIVE_UV, IssueLog()).uvs) == ["second"]


def test_undefined_uvs_are_reported():
    ob = add("Tri", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    layer = ob.data.uv_layers.new(name="UVMap")
    layer.uv[1].vector = (np.nan, 2.0)
    issues = IssueLog()
    mesh = extract_mesh(evaluated(ob), "Tri", ACTIVE_UV, issues)
    assert mesh.uvs["UVMap"][0, 1].tolist() == [0.0, 2.0]
    assert "UVMap" in next(iter(issues)).message


def test_degenerate_faces_get_some_unit_normal():
    ob = add("Sliver", [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
    ob.data.shade_smooth()
    mesh = extract_mesh(evaluated(ob), "Sliver", NOTHING, IssueLog())
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=2), 1.0, atol=1e-5)


def triangulated(ob):
    """The mesh in triangles, for Blender's own tangents."""
    import bmesh  # exists only after bpy

    bm = bmesh.new()
    bm.from_mesh(ob.data)
    bmesh.ops.triangulate(bm, faces=bm.faces)
    bm.to_mesh(ob.data)
    bm.free()


@pytest.mark.parametrize("smooth", [True, False])
def test_tangents_are_blenders(smooth):
    bpy.ops.mesh.primitive_monkey_add()
    ob = bpy.context.object
    triangulated(ob)
    (ob.data.shade_smooth if smooth else ob.data.shade_flat)()
    me = evaluated(ob)
    mesh = extract_mesh(me, "Suzanne", MeshNeeds(tangents=frozenset({""})), IssueLog())
    ours = mesh.tangents["UVMap"]
    copy = me.copy()
    copy.calc_tangents(uvmap="UVMap")
    theirs = np.array([(*copy.loops[i].tangent, copy.loops[i].bitangent_sign) for t in copy.loop_triangles
                       for i in t.loops]).reshape(-1, 3, 4)  # fmt: skip
    d1, d2 = (mesh.uvs["UVMap"][:, i] - mesh.uvs["UVMap"][:, 0] for i in (1, 2))
    charted = d1[:, 0] * d2[:, 1] != d1[:, 1] * d2[:, 0]  # without area, a face has no handedness of its own
    assert charted.mean() > 0.99
    np.testing.assert_array_equal(ours[charted, :, 3], theirs[charted, :, 3])
    ours, theirs = ours[charted], theirs[charted]
    cos = np.einsum("tcx,tcx->tc", ours[..., :3], theirs[..., :3])
    # MikkTSpace groups by shared edges, we by equal corners: they part where two charts of one handedness meet with
    # equal UVs at single corners
    assert (cos > 0.9999).mean() > 0.995
    assert (cos > 0.9).all()


def test_tangents_of_faces_with_many_corners():
    bpy.ops.mesh.primitive_circle_add(vertices=7, fill_type="NGON")
    ob = bpy.context.object
    ob.data.uv_layers.new(name="UVMap")
    for loop, uv in zip(ob.data.loops, ob.data.uv_layers["UVMap"].uv, strict=True):
        x, y, _ = ob.data.vertices[loop.vertex_index].co
        uv.vector = (-y, x)  # turned by 90 degrees: u grows along -y
    mesh = extract_mesh(evaluated(ob), "Circle", MeshNeeds(tangents=frozenset({"UVMap"})), IssueLog())
    np.testing.assert_allclose(mesh.tangents["UVMap"], np.broadcast_to((0, -1, 0, 1), (5, 3, 4)), atol=1e-6)


def test_a_million_triangles():
    """Extracted whole, slots, UVs and normals; `make bench` times it."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708)
    ob = bpy.context.object
    bpy.ops.object.shade_smooth()
    me = ob.data
    me.materials.append(None)
    me.materials.append(None)
    me.polygons.foreach_set("material_index", (np.arange(len(me.polygons)) % 2).astype(np.int32))
    me = evaluated(ob)
    mesh = extract_mesh(me, "Grid", ACTIVE_UV, IssueLog())
    assert len(mesh.triangles) == 1_002_528 and mesh.normals is not None and len(mesh.uvs) == 1
