"""Radial Tiling against Cycles: whole and broken numbers of sides, sharp to round (Blender 5)."""

from __future__ import annotations

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, Patch, feed, new, out, ramp  # noqa: E402

pytestmark = pytest.mark.skipif(not hasattr(bpy.types, "ShaderNodeRadialTiling"), reason="Blender 5 has it first")
OUTPUTS = ["Segment Coordinates", "Segment ID", "Segment Width", "Segment Rotation"]


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("tiling"))


# two sides that are rounded run to infinity, where Cycles' floats turn round
@pytest.mark.parametrize(("sides", "roundness"), [
    (sides, roundness) for sides in (5.0, 2.0, 3.4, 6.7, 2.3) for roundness in (0.0, 0.4, 1.0)
    if (sides, roundness) != (2.0, 0.4)
])  # fmt: skip
@pytest.mark.parametrize("normalize", [False, True])
def test_tiling(patch, sides, roundness, normalize):
    for output in OUTPUTS:
        def build(tree, output=output):
            node = new(tree, "ShaderNodeRadialTiling", normalize=normalize)
            place = ramp(tree, (-1.1, -0.9, 0.0), (1.0, 1.2, 0.0))
            return out(feed(tree, node, Sides=sides, Roundness=roundness, Vector=place), output)

        assert not len(patch.compare(build, outliers=4, flat=None))  # segments end within a few pixels


def test_everything_linked(patch):
    """The numbers of sides and the roundness differ from pixel to pixel."""
    def build(tree):
        numbers = ramp(tree, (3.0, 0.0, 0.0), (7.0, 1.0, 1.0))
        values = feed(tree, tree.nodes.new("ShaderNodeSeparateXYZ"), Vector=numbers)
        node = feed(tree, tree.nodes.new("ShaderNodeRadialTiling"), Sides=values.outputs[0],
                    Roundness=values.outputs[1], Vector=ramp(tree, (-1.1, -0.9, 0.0), (1.0, 1.2, 0.0)))  # fmt: skip
        return out(node, "Segment Coordinates")

    patch.compare(build, outliers=EDGES)
