"""Absorbing insides: transmittances known in closed form, for eye paths, photons and shadow rays."""

import numpy as np
import pytest

from photon_engine.geometry.flatten import flatten
from photon_engine.geometry.intersect import Intersector
from photon_engine.issues import IssueLog
from photon_engine.scene.data import Graph, Node, Socket
from photon_engine.transport.media import find_media, inside_at
from tests.brute import scenes as s
from tests.brute.harness import engine

SIGMA = np.array([0.2, 1.0, 3.0])
DENSITY = 4.0
DOWN = {"passes": 4, "caustic_photons": 100_000, "diffuse_photons": 0, "light_samples": 4}


def filled(material, sigma=SIGMA):
    """The material (None: no surface) with an absorbing inside."""
    graph = Graph([], None) if material is None else material.graph
    color = [*(1.0 - np.asarray(sigma) / DENSITY), 1.0]
    inputs = {"Color": Socket(color, kind="RGBA"), "Density": Socket(DENSITY)}
    node = Node("ShaderNodeVolumeAbsorption", "Absorption", {}, inputs, {"Volume": "SHADER"})
    volume = Socket(node=len(graph.nodes), output="Volume", kind="SHADER")
    stuff = s.glass() if material is None else material
    stuff.graph = Graph([*graph.nodes, node], graph.surface, volume)
    return stuff


def slab_transmittance(thickness, sigma=SIGMA, n=1.5):
    """A slab's, at normal incidence, all echoes: (1 - R)^2 a / (1 - R^2 a^2), a = exp(-sigma thickness)."""
    r, a = ((n - 1) / (n + 1)) ** 2, np.exp(-np.asarray(sigma) * thickness)
    return (1 - r) ** 2 * a / (1 - r * r * a * a)


def above(half_width=0.05, height=2.0):
    """A parallel camera that looks straight down at the origin."""
    return s.camera((0, 0, height), (0, 0, 0), half_width, kind="ORTHO")


def means(picture, name):
    """Mean colour of a pass."""
    return picture[name].mean(axis=(0, 1, 2))


def test_seen_through_a_slab():
    slab = (s.box((-5, -5, 0.2), (5, 5, 0.9)), filled(s.glass()))
    glow = (s.quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), s.emitter(2.0))
    picture, _ = engine(s.build([slab, glow], (), above(), picture=s.frame(64)), 16, caustic_photons=0)
    # 65 000 paths choose to reflect or go through by Fresnel's law: noise 0.1%, more where echoes count
    np.testing.assert_allclose(means(picture, "Emission"), 2.0 * slab_transmittance(0.7), rtol=0.006)


def test_photons_through_a_slab():
    """A sun straight above a slab above a floor: irradiance E T; every photon leaves energy or is counted as lost."""
    slab = (s.box((-2, -2, 0.2), (2, 2, 0.9)), filled(s.glass()))
    floor = (s.quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), s.diffuse(0.5))
    # the camera looks from below the slab
    view = s.camera((0, 0, 0.15), (0, 0, 0), 0.5, kind="ORTHO")
    scene = s.build([slab, floor], [s.sun_lamp((0, 0, -1), 0.0, 3.0)], view, picture=s.frame(16))
    picture, statistics = engine(scene, 8, caustic_photons=200_000, diffuse_photons=0)
    expected = 0.5 / np.pi * 3.0 * slab_transmittance(0.7)
    np.testing.assert_allclose(means(picture, "Caustic"), expected, rtol=0.02)  # measured noise 0.5%
    emitted, absorbed, escaped, dropped = statistics["flux"]["caustic"]
    np.testing.assert_allclose(absorbed + escaped + dropped, emitted, rtol=1e-5)


@pytest.mark.parametrize("boxes", [1, 2])
def test_shadow_rays_through_clear_media(boxes):
    """Boxes with an inside and no surface: what lies behind is darker by exp(-sigma d); overlaps count twice."""
    floor = (s.quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), s.diffuse(0.5))
    parts = [floor, (s.box((-2, -2, 0.2), (2, 2, 0.9)), filled(None))]
    if boxes == 2:
        parts.append((s.box((-2, -2, 0.5), (2, 2, 1.1)), filled(None)))
    view = s.camera((0, 0, 0.15), (0, 0, 0), 0.05, kind="ORTHO")
    scene = s.build(parts, [s.sun_lamp((0, 0, -1), 0.0, 3.0)], view, picture=s.frame(16))
    picture, _ = engine(scene, 2, caustic_photons=0, diffuse_photons=0)
    depth = 0.7 if boxes == 1 else 1.3
    np.testing.assert_allclose(means(picture, "Direct"), 0.5 / np.pi * 3.0 * np.exp(-SIGMA * depth), rtol=1e-4)


def test_camera_and_lamp_inside():
    """A lamp at height 1 over the floor of an absorbing room, seen from within it."""
    room = (s.box((-1, -1, -0.5), (1, 1, 1.5)), filled(None))
    floor = (s.quad((0, 0, 0), (0.9, 0, 0), (0, 0.9, 0)), s.diffuse(0.5))
    scene = s.build([room, floor], [s.point_lamp((0, 0, 1.0), 0.0, 10.0)], above(0.01, 0.5), picture=s.frame(16))
    picture, _ = engine(scene, 2, caustic_photons=0, diffuse_photons=100_000)
    # the camera's rays start at its near clipping, 1 mm on
    expected = 0.5 / np.pi * 10.0 / (4 * np.pi) * np.exp(-SIGMA * 1.499)
    np.testing.assert_allclose(means(picture, "Direct"), expected, rtol=5e-4)  # the camera's window is 0.01 wide


def test_inside_at():
    """Nested and overlapping boxes, and a point outside all."""
    parts = [(s.box((-1, -1, -1), (1, 1, 1)), filled(None)), (s.box((-0.5, -0.5, -0.5), (2, 2, 2)), filled(None)),
             (s.box((3, 3, 3), (4, 4, 4)), s.diffuse())]
    scene = s.build(parts)
    flat = flatten(scene, IssueLog())
    media = find_media(scene, flat, [SIGMA, SIGMA, None], IssueLog())
    tree = Intersector(flat.geometry)
    at = {(0.0, 0.0, 0.0): 3, (-0.8, 0.0, 0.0): 1, (1.5, 1.5, 1.5): 2, (-3.0, 0.0, 0.0): 0, (3.5, 3.5, 3.5): 0}
    for p, bits in at.items():
        assert inside_at(media, flat, tree, np.array(p) - flat.origin) == bits, p
