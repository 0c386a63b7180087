"""Nodes that send rays: Ambient Occlusion and Bevel, through the whole engine against Cycles."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import SIZE, Patch, feed, new, ramp  # noqa: E402

BLOCK = 8


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """A floor with a turned block on it, and a ring beside it, all of one material."""
    patch = Patch(tmp_path_factory.mktemp("rays"))
    # one triangle: in the middle of a pixel on an edge between two, Cycles' rays hit the other one
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata([(-3.0, -2.0, 0.0), (5.0, -2.1, 0.0), (-0.3, 6.0, 0.0)], [], [(0, 1, 2)])
    floor.materials.append(patch.material)
    patch.scene.collection.objects.link(bpy.data.objects.new("Floor", floor))
    patch.object.hide_render = True
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(-0.3, 0.2, 0.2), rotation=(0.0, 0.0, 0.4))
    bpy.context.object.data.materials.append(patch.material)
    bpy.ops.mesh.primitive_torus_add(major_radius=0.25, minor_radius=0.12, location=(0.5, -0.4, 0.2))
    ring = bpy.context.object
    ring.data.materials.append(patch.material)
    for face in ring.data.polygons:
        face.use_smooth = True
    return patch


def blocks(picture):
    """Means over blocks of pixels."""
    n = SIZE // BLOCK
    return picture.reshape(n, BLOCK, n, BLOCK, 3).mean(axis=(1, 3))


def compare(patch, build, tolerance):
    """Assert that block means agree, and that the picture is not flat."""
    patch.wire(build)
    theirs, ours = blocks(patch.cycles()), blocks(patch.engine())
    assert np.ptp(theirs) > 0.03
    np.testing.assert_allclose(ours, theirs, atol=tolerance)


def occlusion(tree, output="AO", **settings):
    """An Ambient Occlusion node of many samples."""
    normal, distance = settings.pop("normal", None), settings.pop("distance", 0.6)
    node = new(tree, "ShaderNodeAmbientOcclusion", samples=128, **settings)
    feed(tree, node, Distance=distance, Color=(0.9, 0.5, 0.2, 1.0))
    if normal:
        tree.links.new(ramp(tree, (-0.3, -0.2, 1.0), (0.5, 0.3, 1.5)), node.inputs["Normal"])
    return node.outputs[output]


# noise of a block's mean: 0.5 / sqrt(128 * 64) = 0.006 at worst where pixels are half hidden; both are Sobol-like
@pytest.mark.parametrize("settings", [
    {}, {"inside": True}, {"only_local": True}, {"inside": True, "only_local": True}, {"normal": True},
    {"output": "Color"}, {"distance": 0.2}, {"distance": 0.0},
], ids=str)  # fmt: skip
def test_ambient_occlusion(patch, settings):
    compare(patch, lambda tree: occlusion(tree, **settings), 0.01)


@pytest.mark.parametrize("radius", [0.05, 0.3])
@pytest.mark.parametrize("linked", [False, True])
def test_bevel(patch, radius, linked):
    """Normals near the block's edges and on the ring; a pixel's noise is 0.14 at worst, a block's mean's 0.01.

    Means of 24 renders agree in each pixel within their noise (3.8 sigma at worst among 3072).
    """
    def build(tree):
        node = feed(tree, new(tree, "ShaderNodeBevel", samples=128), Radius=radius)
        if linked:
            tree.links.new(ramp(tree, (-0.3, -0.2, 1.0), (0.5, 0.3, 1.5)), node.inputs["Normal"])
        return node.outputs["Normal"]

    compare(patch, build, 0.03)


@pytest.mark.skipif(not hasattr(bpy.types, "ShaderNodeRaycast"), reason="Blender 5.1 has it first")
@pytest.mark.parametrize("output", ["Is Hit", "Self Hit", "Hit Distance", "Hit Position", "Hit Normal"])
@pytest.mark.parametrize("linked", [[], ["Direction"], ["Position", "Direction"]], ids=str)
@pytest.mark.parametrize("local", [False, True])
def test_raycast(patch, output, linked, local):
    """From the surface or from anywhere, near objects or the own one; outlines are edges."""
    def build(tree):
        node = feed(tree, new(tree, "ShaderNodeRaycast", only_local=local), Length=0.9)
        ways = {"Direction": ((-0.6, -0.5, 0.3), (0.4, 0.7, 0.8)), "Position": ((-0.9, -0.8, 0.9), (0.8, 0.9, 0.6))}
        for name in linked:
            tree.links.new(ramp(tree, *ways[name]), node.inputs[name])
        return node.outputs[output]

    patch.compare_engine(build, outliers=8, flat=None)


def test_it_depends_on_the_point_alone(patch):
    """The same picture twice."""
    patch.wire(lambda tree: occlusion(tree))
    np.testing.assert_array_equal(patch.engine(), patch.engine())
