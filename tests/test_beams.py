"""The beams that references of small lamps are made from: what a flat sheet of water does is known exactly."""

import math

import numpy as np
import pytest

from photon_engine.camera.filters import filter_table, sample_filter
from photon_engine.scene.data import SceneData
from tests.brute import scenes as s
from tests.brute.film import filter_offset, make_view
from tests.oracle import beams

ALBEDO, IOR, IRRADIANCE = 0.5, 1.333, 3.0
SLANT = math.radians(40.0)  # of the sun


def pool(angle: float) -> SceneData:
    """A wide floor under water and a slanting sun, seen from straight above through a narrow window."""
    floor, water = (s.quad((0, 0, z), (50, 0, 0), (0, 50, 0)) for z in (-0.5, 0.0))
    sun = s.sun_lamp((-math.sin(SLANT), 0.0, -math.cos(SLANT)), angle, IRRADIANCE)
    view = s.camera((0, 0, 3), (0, 0, 0), 0.05)
    return s.build([(floor, s.diffuse(ALBEDO)), (water, s.glass(IOR))], [sun], view, picture=s.frame(8))


def transmitted(c: float, eta: float) -> float:
    """1 - Fresnel's reflectance for unpolarised light at the cosine c."""
    t = math.sqrt(1.0 - (1.0 - c * c) / (eta * eta))
    s, p = (c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t)
    return 1.0 - 0.5 * (s * s + p * p)


@pytest.mark.parametrize("angle", [0.0, 0.00918])
def test_floor_seen_through_water(angle):
    """L = albedo / pi E cos T(40 degrees) T(0) / eta^2, and what the water throws back on the floor: a few percent.

    Of light from a Lambert surface water throws back the share r = 0.477 [Fresnel's R over all directions below]; the
    floor is as good as endless, so that all orders are a geometric series 1 / (1 - albedo r).
    """
    c = np.linspace(0.0, 1.0, 200_001)[1:]
    inside = np.array([1.0 - transmitted(x, 1.0 / IOR) if 1.0 - x * x < 1.0 / IOR**2 else 1.0 for x in c])
    thrown_back = float((2.0 * c * inside).mean())
    first = ALBEDO / math.pi * IRRADIANCE * math.cos(SLANT) * transmitted(math.cos(SLANT), IOR)
    expected = first * transmitted(1.0, IOR) / IOR**2 / (1.0 - ALBEDO * thrown_back)
    scene = pool(angle)
    compiled = beams.compile_scene(scene)
    pictures = [beams.render(scene, (150, 1), 60_000, 10.0, seed, compiled) for seed in range(1, 7)]
    means = np.array([picture.mean() for picture in pictures])
    error = means.std(ddof=1) / math.sqrt(len(means))
    assert error < 0.004 * expected
    assert abs(means.mean() - expected) < 0.01 * expected + 4.0 * error


def test_what_lamps_send_straight_is_not_in_the_map():
    """A floor without water: light comes by shadow rays alone, once."""
    scene = pool(0.0)
    scene.instances.pop()
    picture = beams.render(scene, (4, 1), 1000, 0.1)
    expected = ALBEDO / math.pi * IRRADIANCE * math.cos(SLANT)
    np.testing.assert_allclose(picture, expected, rtol=1e-6)


@pytest.mark.parametrize("name", ["BOX", "GAUSSIAN", "BLACKMAN_HARRIS"])
def test_filters_are_those_of_the_engine(name):
    """Half as wide, what a mirror ball shows of a small lamp was 35% too dark and in too few pixels."""
    width = 1.0 if name == "BOX" else 1.7  # Blender's boxes are a pixel wide
    picture = s.frame(4, filter=name, filter_width=width)
    view, table = make_view(s.build([], [], s.camera((0, 0, 1), (0, 0, 0)), picture=picture)), filter_table(name, width)
    u = np.linspace(0.01, 0.99, 99)
    theirs = [filter_offset(view, x) for x in u]
    np.testing.assert_allclose([sample_filter(table, x) for x in u], theirs, atol=2e-3)
