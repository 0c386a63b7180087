"""Where rays meet lamps whose nodes are evaluated: as the kernels sample them, and what Light Falloff gives there."""

import math

import numpy as np
import pytest

from ...scene.data import Camera, Graph, Node, Socket
from ..nodes import lit_points, make_lamp_nodes, on_lamp, surface_uv
from ..sample import sample_light
from .scenes import frame, lamp, table

KINDS = {
    "point": {"kind": "POINT"},
    "soft point": {"kind": "POINT", "radius": 0.3},
    "sphere": {"kind": "POINT", "radius": 0.3, "soft_falloff": False},
    "spot": {"kind": "SPOT", "radius": 0.2, "spot_size": 2.0, "spot_blend": 0.1},
    "area": {"kind": "AREA", "shape": "RECTANGLE", "size": (0.8, 0.5)},
    "disk": {"kind": "AREA", "shape": "DISK", "size": (0.8, 0.8), "spread": 2.0},
}


def falling(output):
    """A lamp's nodes: Light Falloff of strength 2."""
    falloff = Node("ShaderNodeLightFalloff", "Falloff", {}, {"Strength": Socket(2.0), "Smooth": Socket(0.5)},
                   {output: "VALUE"})  # fmt: skip
    inputs = {"Color": Socket([1.0, 0.5, 0.0, 1.0], kind="RGBA"), "Strength": Socket(None, 0, output)}
    shine = Node("ShaderNodeEmission", "Emission", {}, inputs, {"Emission": "SHADER"})
    return Graph([falloff, shine], Socket(None, 1, "Emission", "SHADER"))


@pytest.mark.parametrize("name", KINDS)
def test_places_are_those_that_are_sampled(name):
    light = lamp(**KINDS[name], matrix=frame((0.1, -0.2, 1.5)))
    lights, rng = table([light]), np.random.default_rng(3)
    found = 0
    for _ in range(60):
        p = tuple(rng.uniform(-0.6, 0.6, 3))
        wi, distance, le, _, _, _ = sample_light(lights, p, (0.0, 0.0, 1.0), *rng.random(3))
        if max(le) <= 0.0:
            continue
        found += 1
        place, normal, t = on_lamp(light, np.array([p]), np.array([wi]))
        assert t[0] == pytest.approx(distance, rel=1e-6)
        np.testing.assert_allclose(place[0], np.array(p) + distance * np.array(wi), atol=1e-6)
        assert np.linalg.norm(normal) == pytest.approx(1.0) and normal[0] @ wi < 1e-6
        local = (place - light.matrix[:3, 3]) @ light.matrix[:3, :3]
        u, v = surface_uv(light, local, normal, -np.array([wi]), np.eye(3))
        if light.kind == "AREA":
            assert 0.0 <= u[0] <= 1.0 and 0.0 <= v[0] <= 1.0
    assert found > 20


@pytest.mark.parametrize(("output", "power"), [("Quadratic", 0), ("Linear", 1), ("Constant", 2)])
def test_light_falloff(output, power):
    """strength d^k d^2 / (smooth + d^2), and the mean over what is lit taken out."""
    light = lamp(kind="POINT", matrix=frame((0.0, 0.0, 3.0)), graph=falling(output))
    nodes = make_lamp_nodes(light, [], Camera(), np.array([0.0, 0.0, 1.0]), (np.zeros(3), 1.0))
    d = np.array([0.5, 1.0, 2.5])
    p = np.array([[0.0, 0.0, 2.0 - x] for x in d])  # recentred
    found = nodes.arriving(p, np.tile([0.0, 0.0, 1.0], (3, 1))) * nodes.share
    expected = 2.0 * d**power * d**2 / (0.5 + d**2)
    np.testing.assert_allclose(found, expected[:, None] * [1.0, 0.5, 0.0], rtol=1e-5)
    assert 0.3 < nodes.share / (expected[2] * 0.57) < 1.2


@pytest.mark.parametrize("name", KINDS)
def test_points_that_tell_the_mean_are_lit(name):
    light = lamp(**KINDS[name], matrix=frame((0.1, -0.2, 1.5)))
    p, wi = lit_points(light, np.zeros(3), 1.0)
    lights = table([light])
    axis = -light.matrix[:3, 2]
    half = {"POINT": math.pi, "SPOT": 0.5 * light.spot_size, "AREA": 0.5 * light.spread}[light.kind]
    assert (-(wi @ axis) >= math.cos(half) - 1e-9).all()
    assert lights.n_near == 1 and np.isfinite(p).all()
