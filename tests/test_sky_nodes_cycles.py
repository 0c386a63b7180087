"""The Sky Texture against Cycles: every model."""

from __future__ import annotations

import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import Patch, enum, feed, new, ramp, unit  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


CASES = [{"elevation": 0.2, "rotation": 2.0, "altitude": 3000.0}, {"elevation": -0.03, "rotation": -1.0}]


def sky(tree, kind, case, **settings):
    """A Sky Texture with a low or a setting sun; what the scattering models compute is the same for all tests."""
    node = new(tree, "ShaderNodeTexSky", sky_type=kind, turbidity=3.3, ground_albedo=0.4)
    node.sun_direction = [(-0.6, 0.4, 0.2), (0.7, 0.7, 0.02)][case]
    node.sun_elevation = CASES[case]["elevation"]
    node.sun_rotation = CASES[case]["rotation"]
    node.altitude = CASES[case].get("altitude", 100.0)
    node.air_density, node.ozone_density = 1.3, 0.8
    setattr(node, "aerosol_density" if hasattr(node, "aerosol_density") else "dust_density", 1.7)
    for name, value in settings.items():
        setattr(node, name, value)
    return node


@pytest.mark.parametrize("case", range(len(CASES)))
@pytest.mark.parametrize("kind", enum("ShaderNodeTexSky", "sky_type"))
def test_sky(patch, kind, case):
    """The whole dome, and below the horizon."""
    def build(tree):
        node = sky(tree, kind, case, sun_disc=False)
        direction = unit(tree, ramp(tree, (-1.3, -1.1, -0.2), (1.2, 1.4, 1.0)))
        dim = new(tree, "ShaderNodeVectorMath", operation="SCALE")
        feed(tree, dim, Vector=feed(tree, node, Vector=direction).outputs[0], Scale=0.1)
        return dim.outputs[0]

    patch.compare(build, 1e-3)  # 0.1 of the radiance: at the horizon and near the sun it is steep


@pytest.mark.parametrize("case", range(len(CASES)))
@pytest.mark.parametrize("kind", [k for k in enum("ShaderNodeTexSky", "sky_type") if "_SCATT" in k or k == "NISHITA"])
def test_sun_disc(patch, kind, case):
    """A large sun, limb darkening and all, also cut by the horizon: 270 and 130 of 1024 pixels."""
    def build(tree):
        node = sky(tree, kind, case, sun_size=0.6, sun_intensity=0.5, sun_rotation=0.8)
        dim = new(tree, "ShaderNodeVectorMath", operation="SCALE")
        feed(tree, dim, Vector=node.outputs[0], Scale=0.01)  # the disc hides the input: Generated is the direction
        return dim.outputs[0]

    patch.compare(build, 1e-3)
