"""Nodes that read data of meshes, objects, particles and view layers: the whole engine against Cycles."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, Patch, feed, new, out, ramp  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests, with attributes of every domain and type, and two parts."""
    patch = Patch(tmp_path_factory.mktemp("nodes"))
    mesh = patch.object.data
    rng = np.random.default_rng(5)
    for domain in ("POINT", "EDGE", "FACE", "CORNER"):
        for kind in ("FLOAT", "INT", "BOOLEAN", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR", "BYTE_COLOR", "INT8"):
            layer = mesh.attributes.new(f"{domain} {kind}", kind, domain)
            key = {"FLOAT2": "vector", "FLOAT_VECTOR": "vector"}.get(kind, "color" if "COLOR" in kind else "value")
            width = {"FLOAT2": 2, "FLOAT_VECTOR": 3}.get(kind, 4 if "COLOR" in kind else 1)
            values = rng.random((len(layer.data), width)) * (5.0 if kind.startswith("INT") else 1.0)
            kinds = {"BOOLEAN": values > 0.5, "INT": values.astype(np.int32), "INT8": values.astype(np.int32)}
            layer.data.foreach_set(key, kinds.get(kind, values).ravel())
    patch.object["number"], patch.object["color"] = 0.7, [0.2, 0.5, 0.9]
    patch.object["four"], patch.object["whole"] = [0.2, 0.5, 0.9, 0.4], 3
    mesh["of data"] = 0.3
    patch.scene["of scene"], patch.scene.view_layers[0]["of layer"] = 0.6, [0.1, 0.8]
    return patch


def attribute(tree, name: str, kind: str = "GEOMETRY"):
    """All outputs of an Attribute node in one colour."""
    node = new(tree, "ShaderNodeAttribute", attribute_name=name, attribute_type=kind)
    join = feed(tree, tree.nodes.new("ShaderNodeCombineXYZ"), X=out(node, "Fac"), Y=out(node, "Alpha"))
    add = new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD")
    feed(tree, add, Vector=out(node, "Color"), Vector_001=(0.3, 0.5, 0.7), Vector_002=join.outputs[0])
    return add.outputs[0]


@pytest.mark.parametrize("domain", ["POINT", "EDGE", "FACE", "CORNER"])
@pytest.mark.parametrize("kind", ["FLOAT", "INT", "BOOLEAN", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR", "BYTE_COLOR",
                                  "INT8"])
def test_mesh_attribute(patch, domain, kind):
    patch.compare_engine(lambda tree: attribute(tree, f"{domain} {kind}"), flat=None)


@pytest.mark.parametrize("name", ["UVMap", "Paint", "nothing of this name", ""])
def test_named_layer(patch, name):
    patch.compare_engine(lambda tree: attribute(tree, name), flat=name not in ("UVMap", "Paint"))


@pytest.mark.parametrize("name", ["number", "color", "four", "whole", "of data", "location", "pass_index", "nothing"])
@pytest.mark.parametrize("kind", ["OBJECT", "INSTANCER"])
def test_object_property(patch, kind, name):
    patch.compare_engine(lambda tree: attribute(tree, name, kind), flat=True)


@pytest.mark.parametrize("name", ["of scene", "of layer", "frame_current", "nothing"])
def test_view_layer_property(patch, name):
    patch.compare_engine(lambda tree: attribute(tree, name, "VIEW_LAYER"), flat=True)


@pytest.mark.parametrize("output", ["Location", "Color", "Alpha", "Object Index", "Material Index", "Random"])
def test_object_info(patch, output):
    patch.material.pass_index = 5
    patch.compare_engine(lambda tree: out(tree.nodes.new("ShaderNodeObjectInfo"), output), flat=True)


SPACES = ["WORLD", "OBJECT", "CAMERA"]


@pytest.mark.parametrize("kind", ["POINT", "VECTOR", "NORMAL"])
@pytest.mark.parametrize("spaces", [(a, b) for a in SPACES for b in SPACES], ids="-".join)
def test_vector_transform(patch, kind, spaces):
    def build(tree):
        node = new(tree, "ShaderNodeVectorTransform", vector_type=kind, convert_from=spaces[0], convert_to=spaces[1])
        return feed(tree, node, Vector=ramp(tree)).outputs[0]

    patch.compare_engine(build)


def test_window(patch):
    patch.compare_engine(lambda tree: out(tree.nodes.new("ShaderNodeTexCoord"), "Window"))


@pytest.mark.parametrize("kind", ["ShaderNodePointInfo", "ShaderNodeHairInfo", "ShaderNodeParticleInfo"])
def test_absent_things(patch, kind):
    """Points, strands and particles: zeros (hashes of zeros) where there are none."""
    def build(tree):
        node, total = tree.nodes.new(kind), (0.0, 0.0, 0.0)
        for output in node.outputs:
            add = new(tree, "ShaderNodeVectorMath", operation="ADD")
            feed(tree, add, Vector=output, Vector_001=total)
            total = add.outputs[0]
        return total

    patch.compare_engine(build, flat=True)


def test_parts_and_particles(tmp_path):
    """Random Per Island over a grid of separate faces; particles that show an object."""
    patch = Patch(tmp_path)
    mesh = bpy.data.meshes.new("Islands")
    corners, faces = [], []
    for i in range(5):
        for j in range(5):
            x, y = -0.95 + 0.4 * i, -0.95 + 0.4 * j
            start = len(corners)
            corners += [(x, y, 0.0), (x + 0.3, y, 0.0), (x + 0.3, y + 0.3, 0.0), (x, y + 0.3, 0.0)]
            faces.append(tuple(range(start, start + 4)))
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(patch.material)
    patch.object.data = mesh
    patch.object.matrix_world.identity()
    # edges of faces: a filter of 0.01 px puts some pixels on either side
    patch.compare_engine(lambda tree: out(tree.nodes.new("ShaderNodeNewGeometry"), "Random Per Island"), outliers=EDGES)
    _particles(patch, mesh)
    for output in ("Index", "Random", "Age", "Lifetime", "Size", "Location", "Velocity"):
        scale = 0.02 if output in ("Age", "Lifetime", "Index") else 1.0

        def build(tree, output=output, scale=scale):
            node = new(tree, "ShaderNodeVectorMath", operation="SCALE")
            source = tree.nodes.new("ShaderNodeParticleInfo")
            return feed(tree, node, Vector=out(source, output), Scale=scale).outputs[0]

        patch.compare_engine(build, outliers=EDGES)


def test_pointiness_and_wireframe(tmp_path):
    """Of a bumpy grid, some of whose vertices are there twice; wires in metres, in pixels and through a bump."""
    patch = Patch(tmp_path)
    rng = np.random.default_rng(8)
    at = np.linspace(-1.0, 1.0, 6)
    corners = [(x, y, 0.2 * rng.random()) for y in at for x in at]
    faces = [(6 * j + i, 6 * j + i + 1, 6 * j + i + 7, 6 * j + i + 6) for j in range(5) for i in range(5)]
    # the last row of faces has vertices of its own at the places of others
    start = len(corners)
    corners += corners[24:36]
    faces[20:] = [tuple(start + k - 24 for k in face) for face in faces[20:]]
    mesh = bpy.data.meshes.new("Bumpy")
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(patch.material)
    patch.object.data = mesh
    patch.object.matrix_world.identity()
    # edges of the triangles: a filter of 0.01 px puts some pixels on either side
    patch.compare_engine(lambda tree: out(tree.nodes.new("ShaderNodeNewGeometry"), "Pointiness"), outliers=EDGES)
    for size, pixels in ((0.05, False), (1.7, True)):

        def build(tree, size=size, pixels=pixels):
            node = new(tree, "ShaderNodeWireframe", use_pixel_size=pixels)
            return out(feed(tree, node, Size=size), "Fac")

        patch.compare_engine(build, outliers=EDGES)


def _particles(patch, mesh) -> None:
    """Let the object emit ten particles that show a plate with the material."""
    plate = bpy.data.meshes.new("Plate")
    plate.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    plate.materials.append(patch.material)
    shown = bpy.data.objects.new("Plate", plate)
    shown.location = (9.0, 0.0, 0.0)
    patch.scene.collection.objects.link(shown)
    patch.object.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = patch.object.particle_systems[0].settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 10, 1, 3, 40
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", shown, 0.15
    settings.effector_weights.gravity, settings.normal_factor = 0.0, 0.3
    for frame in range(1, 6):
        patch.scene.frame_set(frame)
