"""Regular textures, Gabor noise and spectra against Cycles."""

from __future__ import annotations

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, TOLERANCE, Patch, channel, enum, feed, new, out, ramp, unit  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


WAVES = [("BANDS", "bands_direction", d) for d in enum("ShaderNodeTexWave", "bands_direction")]
WAVES += [("RINGS", "rings_direction", d) for d in enum("ShaderNodeTexWave", "rings_direction")]


@pytest.mark.parametrize("profile", enum("ShaderNodeTexWave", "wave_profile"))
@pytest.mark.parametrize("case", WAVES, ids=lambda case: f"{case[0]}-{case[2]}")
def test_wave(patch, case, profile):
    def build(tree):
        node = new(tree, "ShaderNodeTexWave", wave_type=case[0], wave_profile=profile, **{case[1]: case[2]})
        feed(tree, node, Vector=ramp(tree), Scale=0.3, Distortion=1.5, Detail=1.5, Detail_Scale=0.8, Phase_Offset=0.4)
        return out(feed(tree, node, Detail_Roughness=0.6), "Color")

    # slopes of up to 20 over the patch; saws jump
    patch.compare(build, 3.0 * TOLERANCE, outliers=EDGES if profile == "SAW" else 0)


@pytest.mark.parametrize("depth", range(11))
def test_magic(patch, depth):
    def build(tree):
        node = new(tree, "ShaderNodeTexMagic", turbulence_depth=depth)
        vector = ramp(tree, (-0.2, 0.1, 0.3), (0.4, 0.6, 0.5))
        return out(feed(tree, node, Vector=vector, Scale=1.7, Distortion=1.2), "Color")

    patch.compare(build, 3.0 * TOLERANCE)  # slopes of up to 10


@pytest.mark.parametrize("smooth", [0.0, 0.5])
@pytest.mark.parametrize("frequency", [(2, 2), (3, 1), (1, 3)])
@pytest.mark.parametrize("output", ["Color", "Fac"])
def test_brick(patch, frequency, smooth, output):
    def build(tree):
        node = new(tree, "ShaderNodeTexBrick", offset=0.3, squash=1.6)
        node.offset_frequency, node.squash_frequency = frequency
        feed(tree, node, Vector=ramp(tree, (-1.07, -0.83, 0.0), (1.11, 0.94, 0.0)), Scale=2.1, Bias=-0.1)
        feed(tree, node, Color1=(0.9, 0.1, 0.2, 1.0), Color2=(0.2, 0.8, 0.3, 1.0), Mortar=(0.1, 0.2, 0.9, 1.0))
        feed(tree, node, Mortar_Size=0.04, Mortar_Smooth=smooth, Brick_Width=0.6, Row_Height=0.31)
        return out(node, output)

    # edges between bricks and mortar: steep or jumping
    patch.compare(build, 5.0 * TOLERANCE, outliers=EDGES)


@pytest.mark.parametrize("kind", ["2D", "3D"])
@pytest.mark.parametrize("anisotropy", [1.0, 0.3])
@pytest.mark.parametrize("output", ["Value", "Phase", "Intensity"])
def test_gabor(patch, kind, anisotropy, output):
    def build(tree):
        node = new(tree, "ShaderNodeTexGabor", gabor_type=kind)
        feed(tree, node, Vector=ramp(tree, (-0.5, -0.4, 0.1), (0.7, 0.9, 0.6)), Scale=1.8, Frequency=1.3)
        feed(tree, node, Anisotropy=anisotropy)
        if kind == "2D":
            feed(tree, node, Orientation_2D=0.6)
        else:
            feed(tree, node, Orientation_3D=unit(tree, (0.4, -0.7, 0.5)))
        return out(node, output)

    # slopes of up to 10; the phase jumps where it passes a turn
    patch.compare(build, 3.0 * TOLERANCE, outliers=EDGES if output == "Phase" else 0)


@pytest.mark.parametrize(("kind", "low", "high"), [("Blackbody", 500.0, 13000.0), ("Blackbody", 900.0, 2500.0),
                                                   ("Wavelength", 370.0, 800.0)])
def test_spectra(patch, kind, low, high):
    def build(tree):
        place = ramp(tree, (low, 0.0, 0.0), (high, 0.0, 0.0))
        name = "Temperature" if kind == "Blackbody" else "Wavelength"
        return feed(tree, tree.nodes.new(f"ShaderNode{kind}"), **{name: channel(tree, place, 0)}).outputs[0]

    # the filter moves the place by up to 1.6e-4 of the range; Blackbody jumps at 800 K
    patch.compare(build, 3.0 * TOLERANCE, outliers=EDGES)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
def test_own_mapping(patch, kind):
    """The hidden mapping of texture nodes, which old files use."""
    def build(tree):
        node = new(tree, "ShaderNodeTexGradient", gradient_type="DIAGONAL")
        mapping = node.texture_mapping
        mapping.vector_type, mapping.mapping_x, mapping.mapping_y = kind, "Y", "Z"
        mapping.translation, mapping.rotation, mapping.scale = (0.1, 0.2, -0.1), (0.3, 0.2, -0.5), (0.8, 1.2, 0.7)
        return out(feed(tree, node, Vector=ramp(tree)), "Fac")

    patch.compare(build)
