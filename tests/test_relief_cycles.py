"""Bump, Displacement shown as bump, and Tangent against Cycles, through the whole engine: normals that shine."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from photon_engine.blender.extract import extract_scene  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402
from photon_engine.transport.emission import emission_of  # noqa: E402
from photon_engine.transport.render_scene import RenderScene  # noqa: E402
from tests.node_patch import LIFT, SIZE, Patch, channel, feed, new, out  # noqa: E402

# slopes are differences over 0.6 mm in single precision; Cycles' image lookups add its half-float textures
TOLERANCE = 6e-3


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests, its floor bent so that shading and geometric normals differ."""
    return Patch(tmp_path_factory.mktemp("relief"))


def shown_normals(patch: Patch) -> np.ndarray:
    """What shines at the pixels' centres, (SIZE * SIZE, 3), from a scene extracted and shaded by the engine."""
    issues = IssueLog()
    data = extract_scene(bpy.context.evaluated_depsgraph_get(), issues)
    scene = RenderScene(data, Settings(), issues, lambda text: None)
    at = ((np.arange(SIZE) + 0.5) / SIZE * 2.0 - 1.0).astype(np.float32)
    x, y = (grid.ravel() for grid in np.meshgrid(at, at))
    eye = np.array(patch.camera.location, np.float32)
    d = np.stack([x, y, np.zeros_like(x)], axis=1) - eye
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    o = np.broadcast_to(eye - scene.flat.origin, d.shape).astype(np.float32).copy()
    surfaces = scene.surfaces(o, d)
    assert not list(issues)
    radiance = emission_of(surfaces.rows.kind, surfaces.rows.params)[surfaces.row]
    return 4.0 * (radiance - LIFT)


def waves(tree, source: str):
    """A smooth height of a few centimetres over coordinates of the patch."""
    if source == "UV":
        vector = out(tree.nodes.new("ShaderNodeUVMap"), "UV")
    else:
        vector = out(tree.nodes.new("ShaderNodeTexCoord"), source)
    parts = []
    for k, frequency in ((0, 5.0), (1, 7.0)):
        times = feed(tree, new(tree, "ShaderNodeMath", operation="MULTIPLY"), Value=channel(tree, vector, k),
                     Value_001=frequency)
        parts.append(feed(tree, new(tree, "ShaderNodeMath", operation="SINE"), Value=times.outputs[0]).outputs[0])
    node = feed(tree, new(tree, "ShaderNodeMath", operation="MULTIPLY"), Value=parts[0], Value_001=parts[1])
    return node.outputs[0]


def picture(tree):
    """A smooth picture of random texels as a height."""
    image = bpy.data.images.new("Height", 16, 16, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"  # a change of it would make the texels anew
    texels = np.ones((256, 4), np.float32)
    texels[:, :3] = np.random.default_rng(2).random((256, 1)) * 0.2
    image.pixels.foreach_set(texels.ravel())
    image.update()
    return new(tree, "ShaderNodeTexImage", image=image).outputs["Color"]


BUMPS = {
    "uv": ("UV", {"Strength": 1.0, "Distance": 0.2}, False),
    "generated": ("Generated", {"Strength": 0.6, "Distance": 0.3}, False),
    "object_inverted": ("Object", {"Strength": 1.0, "Distance": 0.15}, True),
    "extrapolated": ("UV", {"Strength": 2.0, "Distance": 0.05}, False),
}


def assert_same(patch: Patch, build, outliers: int = 0) -> None:
    """The picture of build(tree)'s output, in Cycles and in ours."""
    patch.wire(build)
    theirs, ours = patch.cycles(), shown_normals(patch)
    assert np.ptp(theirs, axis=0).max() > 0.1
    error = np.abs(ours - theirs).max(axis=1)
    assert (error > TOLERANCE).sum() <= outliers, f"worst {error.max():.4f}, {(error > TOLERANCE).sum()} pixels"


@pytest.mark.parametrize("name", BUMPS)
def test_bump(patch, name):
    source, constants, invert = BUMPS[name]

    def build(tree):
        node = feed(tree, new(tree, "ShaderNodeBump", invert=invert), Height=waves(tree, source))
        for key, value in constants.items():
            node.inputs[key].default_value = value
        return node.outputs[0]

    assert_same(patch, build)


def test_bump_of_an_image(patch):
    """The slope of bilinear texels jumps where they meet: up to two pixels in each of 16 rows and columns."""
    def build(tree):
        return feed(tree, new(tree, "ShaderNodeBump"), Height=picture(tree), Distance=0.2).outputs[0]

    assert_same(patch, build, outliers=40)


def test_bump_on_bump(patch):
    def build(tree):
        first = feed(tree, new(tree, "ShaderNodeBump"), Height=waves(tree, "UV"), Distance=0.2)
        return feed(tree, new(tree, "ShaderNodeBump"), Height=waves(tree, "Object"), Distance=0.1,
                    Normal=first.outputs[0]).outputs[0]

    assert_same(patch, build)


@pytest.mark.parametrize("space", ["OBJECT", "WORLD"])
def test_displacement_as_bump(patch, space):
    """The Geometry node shows the normal that displacement has bent."""
    def build(tree):
        node = new(tree, "ShaderNodeDisplacement", space=space)
        feed(tree, node, Height=waves(tree, "UV"), Scale=0.2, Midlevel=0.3)
        output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        tree.links.new(node.outputs[0], output.inputs["Displacement"])
        return tree.nodes.new("ShaderNodeNewGeometry").outputs["Normal"]

    assert_same(patch, build)


TANGENTS = [{"direction_type": "RADIAL", "axis": "Z"}, {"direction_type": "RADIAL", "axis": "X"},
            {"direction_type": "UV_MAP", "uv_map": "Other"}]  # fmt: skip


@pytest.mark.parametrize("settings", TANGENTS)
def test_tangent(patch, settings):
    """Along a UV layer it is the same everywhere on a flat patch, so a bump is added to see something vary."""
    def build(tree):
        bump = feed(tree, new(tree, "ShaderNodeBump"), Height=waves(tree, "UV"), Distance=0.2)
        node = new(tree, "ShaderNodeTangent", **settings)
        add = feed(tree, new(tree, "ShaderNodeVectorMath", operation="ADD"), Vector=bump.outputs[0],
                   Vector_001=node.outputs[0])
        return add.outputs[0]

    assert_same(patch, build)
