"""Light that comes through a body: photons that walk and eye paths that walk find the same, whoever gathers it."""

import numpy as np
import pytest

from photon_engine.scene.data import Graph, Material, Node, Socket
from tests.brute import scenes as s
from tests.brute.harness import engine


def flesh(method, **values):
    """A Subsurface Scattering material of three radii."""
    inputs = {"Color": Socket([0.9, 0.8, 0.7, 1.0], kind="RGBA"), "Radius": Socket([1.0, 0.5, 0.3], kind="VECTOR")}
    inputs |= {name: Socket(value) for name, value in values.items()}
    node = Node("ShaderNodeSubsurfaceScattering", "Flesh", {"falloff": method}, inputs, {"BSSRDF": "SHADER"})
    return Material("Flesh", Graph([node], Socket(None, 0, "BSSRDF")))


def below_a_slab(material):
    """A floor under a slab that a sun shines on, seen from between the two: all its light has come through."""
    slab = (s.box((-1.5, -1.5, 0.5), (1.5, 1.5, 0.7)), material)
    floor = (s.quad((0, 0, 0), (1.2, 0, 0), (0, 1.2, 0)), s.diffuse(0.5))
    view = s.camera((0, 0, 0.4), (0, 0, 0), 0.8, kind="ORTHO")
    return s.build([slab, floor], [s.sun_lamp((0, 0, -1), 0.0, 3.0)], view, picture=s.frame(32))


@pytest.mark.parametrize(
    ("method", "values"),
    [("RANDOM_WALK", {"Scale": 0.2, "Roughness": 0.4}), ("RANDOM_WALK_SKIN", {"Scale": 1.5, "IOR": 1.4})],
)
def test_photons_and_final_gather_see_the_same_through_a_slab(method, values):
    """Photons leave the slab and fall on the floor; a final gather looks from the floor into the slab instead."""
    scene = below_a_slab(flesh(method, **values))
    budget = {"caustic_photons": 0, "light_samples": 1}
    ways = [
        engine(scene, 6, diffuse_photons=150_000, final_gather="OFF", **budget)[0],
        engine(scene, 16, diffuse_photons=20_000, final_gather="ALL", **budget)[0],
    ]
    sent, gathered = (way["Diffuse"].mean(axis=(1, 2)) for way in ways)
    error = np.sqrt(sum(x.var(axis=0, ddof=1) / len(x) for x in (sent, gathered)))
    sent, gathered = sent.mean(axis=0), gathered.mean(axis=0)
    assert (gathered > 0.02).all() and not any(way["Direct"].any() for way in ways)
    # three times as many passes are 0.998, 1.003, 1.007 and 0.978, 1.006, 1.011 of each other, noise 1.0% to 1.5%
    assert (error < 0.03 * gathered).all() and (abs(sent - gathered) < 4.0 * error).all(), sent / gathered


def test_threads_change_no_bit():
    scene = below_a_slab(flesh("RANDOM_WALK", Scale=0.2))
    one, two = (engine(scene, 1, diffuse_photons=5000, threads=threads)[0] for threads in (1, 2))
    for name, picture in one.items():
        np.testing.assert_array_equal(two[name], picture)
