"""The table of a world that varies, from its nodes."""

import math

import numpy as np

from ...issues import IssueLog
from ...scene.data import Graph, Image, Node, Socket, World
from ..sky import build_sky, mean_radiance, tabulate
from ..sky_sample import map_radiance


def world(node, output, kind="RGBA", strength=2.0):
    """A world of one node behind a Background."""
    inputs = {"Color": Socket(None, 0, output, "RGBA"), "Strength": Socket(strength)}
    background = Node("ShaderNodeBackground", "Background", {}, inputs, {"Background": "SHADER"})
    return World("Sky", Graph([node, background], Socket(None, 1, "Background", "SHADER")))


def coordinates():
    """Generated coordinates: the direction itself."""
    return Node("ShaderNodeTexCoord", "Coordinates", {}, {}, {"Generated": "VECTOR"})


def test_table_follows_the_nodes():
    """Radiance 2 max(d, 0): exact on lookup, and within a texel's width (0.35 degrees) in the table."""
    sky = build_sky(world(coordinates(), "Generated"), [], IssueLog())
    d = np.random.default_rng(1).normal(size=(500, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    expected = 2.0 * np.maximum(d, 0.0)
    np.testing.assert_allclose(sky.radiance_at(d), expected, atol=1e-6)
    table = np.array([map_radiance(sky.map, tuple(x)) for x in d])
    np.testing.assert_allclose(table, expected, atol=2.0 * math.radians(0.36))
    # the mean of max(z, 0) over the sphere is 1/4
    np.testing.assert_allclose(mean_radiance(sky.map), 0.5, rtol=1e-4)


def test_constant_world_needs_no_table():
    rgb = Node("ShaderNodeRGB", "RGB", {"value": [0.2, 0.3, 0.4, 1.0]}, {}, {"Color": "RGBA"})
    assert build_sky(world(rgb, "Color"), [], IssueLog()) is None
    assert build_sky(World(), [], IssueLog()) is None


class Spot:
    """A sky that is black but for a disk of radiance 1000 and half a degree across, as the sun."""

    def __init__(self, toward):
        self.toward = np.asarray(toward, float) / np.linalg.norm(toward)

    def radiance_at(self, d):
        sine = np.linalg.norm(np.cross(d, self.toward), axis=1)
        lit = (sine < math.sin(math.radians(0.25))) & (d @ self.toward > 0.0)
        return 1000.0 * np.repeat(lit[:, None], 3, axis=1)


def test_small_suns_keep_their_power():
    """The table holds a sun's irradiance within 2%, wherever its edge cuts the texels."""
    for toward in ((0.3, 0.5, 0.4), (-0.2, 0.1, 0.9), (0.7, -0.6, 0.03)):
        table = tabulate(Spot(toward), 512, 1024)
        angle = -np.diff(np.cos(np.arange(513) * math.pi / 512)) * 2.0 * math.pi / 1024
        power = (table[:, :, 0] * angle[:, None]).sum()
        exact = 1000.0 * 2.0 * math.pi * (1.0 - math.cos(math.radians(0.25)))
        assert abs(power / exact - 1.0) < 0.02


def test_image_worlds_are_as_wide_as_their_image():
    image = Image("Sky", np.ones((300, 600, 4), np.float32))
    texture = Node("ShaderNodeTexImage", "Texture", {"image": 0, "interpolation": "Linear", "extension": "REPEAT"},
                   {"Vector": Socket(None, kind="VECTOR")}, {"Color": "RGBA"})
    sky = build_sky(world(texture, "Color"), [image], IssueLog())
    assert sky.map.radiance.shape == (300, 600, 3)
