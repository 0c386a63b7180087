"""Nodes that read the surface, and procedural textures, against Cycles."""

from __future__ import annotations

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, Patch, channel, enum, feed, new, out, ramp, unit  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


@pytest.mark.parametrize("output", ["Generated", "Normal", "UV", "Object", "Camera", "Reflection"])
def test_texture_coordinate(patch, output):
    def build(tree):
        return out(tree.nodes.new("ShaderNodeTexCoord"), output)

    patch.compare(build, flat=output == "Normal")


def test_texture_coordinate_of_another_object(patch):
    other = bpy.data.objects.new("Other", None)
    other.location, other.scale, other.rotation_euler = (0.2, -0.3, 0.4), (2.0, 0.5, 1.0), (0.2, 0.5, 0.1)
    patch.scene.collection.objects.link(other)
    bpy.context.view_layer.update()

    def build(tree):
        return out(new(tree, "ShaderNodeTexCoord", object=other), "Object")

    patch.compare(build)


@pytest.mark.parametrize("layer", ["", "UVMap", "Other"])
def test_uv_map(patch, layer):
    patch.compare(lambda tree: new(tree, "ShaderNodeUVMap", uv_map=layer).outputs[0])


@pytest.mark.parametrize("output", ["Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing"])
def test_geometry(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeNewGeometry"), output),
                  flat=output in ("Normal", "True Normal", "Backfacing"))


@pytest.mark.parametrize("output", ["View Vector", "View Z Depth", "View Distance"])
def test_camera_data(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeCameraData"), output), flat="Z" in output)


@pytest.mark.parametrize("output", ["Location", "Color", "Alpha", "Object Index"])
def test_object_info(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeObjectInfo"), output), flat=True)


@pytest.mark.parametrize("name", ["Paint", ""])
@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_vertex_color(patch, output, name):
    patch.compare(lambda tree: out(new(tree, "ShaderNodeVertexColor", layer_name=name), output))


def test_light_path(patch):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeLightPath"), "Is Camera Ray"), flat=True)


@pytest.mark.parametrize("linked", [False, True])
@pytest.mark.parametrize("case", [("ShaderNodeFresnel", "Fac", "IOR"), ("ShaderNodeLayerWeight", "Fresnel", "Blend"),
                                  ("ShaderNodeLayerWeight", "Facing", "Blend")])
def test_fresnel(patch, case, linked):
    kind, output, name = case

    def build(tree):
        node = tree.nodes.new(kind)
        # an index near 1 is left out: total reflection begins there with an infinite slope
        values = ramp(tree, (0.1, 1.1, 0.1), (0.9, 1.9, 0.8))
        feed(tree, node, **{name: channel(tree, values, 0 if name == "Blend" else 1)})
        if linked:
            feed(tree, node, Normal=unit(tree, (0.3, -0.2, 0.9)))
        return out(node, output)

    patch.compare(build)


@pytest.mark.parametrize("space", enum("ShaderNodeNormalMap", "space"))
@pytest.mark.parametrize("strength", [1.0, 0.4])
def test_normal_map(patch, space, strength):
    def build(tree):
        node = new(tree, "ShaderNodeNormalMap", space=space)
        return feed(tree, node, Color=ramp(tree, (0.2, 0.3, 0.7), (0.8, 0.9, 1.0)), Strength=strength).outputs[0]

    patch.compare(build)


@pytest.mark.parametrize("output", ["Color", "Fac"])
def test_checker(patch, output):
    def build(tree):
        node = tree.nodes.new("ShaderNodeTexChecker")
        feed(tree, node, Vector=ramp(tree, (-0.51, -0.43, 0.1), (0.49, 0.62, 0.12)), Scale=3.7)
        return out(feed(tree, node, Color1=(0.9, 0.1, 0.2, 1.0)), output)

    patch.compare(build, outliers=2)


@pytest.mark.parametrize("kind", enum("ShaderNodeTexGradient", "gradient_type"))
def test_gradient(patch, kind):
    def build(tree):
        return out(feed(tree, new(tree, "ShaderNodeTexGradient", gradient_type=kind), Vector=ramp(tree)), "Color")

    patch.compare(build, outliers=EDGES if kind == "RADIAL" else 0)


def test_checker_on_generated(patch):
    def build(tree):
        return feed(tree, tree.nodes.new("ShaderNodeTexChecker"), Scale=3.3).outputs[0]

    patch.compare(build, outliers=EDGES)
