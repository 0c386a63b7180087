"""Noise-like textures against Cycles: the same hash, the same lattice."""

from __future__ import annotations

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, TOLERANCE, Patch, channel, enum, feed, new, out, ramp  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


DIMENSIONS = enum("ShaderNodeTexNoise", "noise_dimensions")


def place(tree, node, low=(-0.5, -0.4, 0.1), high=(1.5, 1.2, 0.9)):
    """Link a varying vector, and its height as W, where the node has them."""
    vector = ramp(tree, low, high)
    sockets = {"Vector": vector, "W": channel(tree, vector, 2)}
    names = {socket.identifier for socket in node.inputs if not socket.is_unavailable}
    return feed(tree, node, **{name: value for name, value in sockets.items() if name in names})


def constants(tree, node, **values):
    """Constants for those inputs that the node has in this mode."""
    names = {socket.identifier for socket in node.inputs if not socket.is_unavailable}
    return feed(tree, node, **{k: v for k, v in values.items() if k in names or k.replace("_", " ") in names})


@pytest.mark.parametrize("dimensions", DIMENSIONS)
@pytest.mark.parametrize("kind", enum("ShaderNodeTexNoise", "noise_type"))
@pytest.mark.parametrize("variant", ["plain", "distorted"])
def test_noise(patch, kind, dimensions, variant):
    """All fractals in all dimensions; whole and broken detail, distortion, not normalized."""
    def build(tree):
        node = new(tree, "ShaderNodeTexNoise", noise_type=kind, noise_dimensions=dimensions)
        node.normalize = variant == "plain"
        values = {"Scale": 2.3, "Detail": 2.0, "Roughness": 0.6, "Lacunarity": 1.9, "Distortion": 0.0}
        if variant == "distorted":
            values.update(Detail=1.4, Distortion=0.7, Lacunarity=2.2)
        constants(tree, node, **values, Offset=0.3, Gain=1.7)
        return out(place(tree, node), "Color")

    # slopes of up to 10 over the patch
    patch.compare(build, 3.0 * TOLERANCE)


def test_noise_with_varying_parameters(patch):
    def build(tree):
        node = tree.nodes.new("ShaderNodeTexNoise")
        values = ramp(tree, (0.1, 0.3, 1.2), (3.7, 0.9, 2.4))
        feed(tree, node, Detail=channel(tree, values, 0), Roughness=channel(tree, values, 1))
        return out(place(tree, feed(tree, node, Lacunarity=channel(tree, values, 2), Scale=2.0)), "Fac")

    patch.compare(build, 3.0 * TOLERANCE)


def test_noise_of_generated_coordinates_and_far_away(patch):
    """Without a vector; and where the lattice repeats."""
    patch.compare(lambda tree: out(feed(tree, tree.nodes.new("ShaderNodeTexNoise"), Scale=1.5), "Color"),
                  3.0 * TOLERANCE)

    def build(tree):
        node = feed(tree, new(tree, "ShaderNodeTexNoise", noise_dimensions="2D"), Scale=1.0, Detail=0.0)
        return out(place(tree, node, (1e6 + 0.5, -3e6, 0.0), (1e6 + 0.5, -3e6, 4.0)), "Fac")

    patch.compare(build, flat=True)


@pytest.mark.parametrize("dimensions", DIMENSIONS)
def test_white_noise(patch, dimensions):
    """Of whole numbers: neighbouring floats have nothing to do with each other."""
    def build(tree):
        cells = new(tree, "ShaderNodeVectorMath", operation="FLOOR")
        feed(tree, cells, Vector=ramp(tree, (-3, -3, 0), (4, 5, 6)))
        node = new(tree, "ShaderNodeTexWhiteNoise", noise_dimensions=dimensions)
        names = {socket.identifier for socket in node.inputs if not socket.is_unavailable}
        if "Vector" in names:
            feed(tree, node, Vector=cells.outputs[0])
        if "W" in names:
            feed(tree, node, W=channel(tree, cells.outputs[0], 2))
        return out(node, "Color")

    patch.compare(build, outliers=EDGES)


def voronoi(tree, feature, dimensions, **settings):
    """A Voronoi texture of a varying vector."""
    node = new(tree, "ShaderNodeTexVoronoi", feature=feature, voronoi_dimensions=dimensions)
    for name in [name for name in settings if name[0].islower()]:
        setattr(node, name, settings.pop(name))
    constants(tree, node, **{"Scale": 2.7, "Randomness": 0.9, "Smoothness": 0.6, **settings})
    return place(tree, node)


@pytest.mark.parametrize("dimensions", DIMENSIONS)
@pytest.mark.parametrize("feature", enum("ShaderNodeTexVoronoi", "feature"))
@pytest.mark.parametrize("detail", [0.0, 1.4])
def test_voronoi(patch, feature, dimensions, detail):
    """Every feature in every dimension; one octave, and two and a half, normalized."""
    def build(tree):
        node = voronoi(tree, feature, dimensions, Detail=detail, normalize=detail > 0.0)
        outputs = [s for s in node.outputs if not s.is_unavailable]
        total = ramp(tree, (0.0, 0.0, 0.0), (0.01, 0.02, 0.0))
        for k, output in enumerate(outputs):  # all outputs in one picture, with weights of their own
            add = new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD")
            weights = (0.3 + 0.2 * k, 0.9 - 0.2 * k, 0.5)
            total = feed(tree, add, Vector=output, Vector_001=weights, Vector_002=total).outputs[0]
        return total

    # colours and places jump between cells: pixels on the walls
    patch.compare(build, 3.0 * TOLERANCE, outliers=EDGES)


@pytest.mark.parametrize("metric", enum("ShaderNodeTexVoronoi", "distance"))
@pytest.mark.parametrize("feature", ["F1", "F2", "SMOOTH_F1"])
def test_voronoi_metric(patch, feature, metric):
    def build(tree):
        node = voronoi(tree, feature, "3D", distance=metric, Exponent=0.8, normalize=True, Detail=1.0)
        return out(node, "Distance")

    patch.compare(build, 3.0 * TOLERANCE, outliers=4)
