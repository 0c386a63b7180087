"""Random walks below surfaces: what goes in comes out, from both ends alike, whatever the batch."""

import numpy as np
import pytest

from ...bsdf.layout import SUBSURFACE
from ...geometry.intersect import Hits
from ...geometry.surface import surface_points
from ...issues import IssueLog
from ...photons.batch import empty_photons, head
from ...scene.data import Camera, Frame, Graph, Instance, Light, Material, Mesh, Node, SceneData, Socket
from ...settings import Settings
from ..deep_kernels import eyes_below
from ..eye_batch import empty_paths
from ..lamp_nodes import NO_GAIN
from ..matte_kernels import empty_lanes
from ..photon_kernels import ABSORBED, Leg, deep_lists
from ..render_scene import RenderScene
from ..subsurface import carry_below, walk
from ..walk_kernels import empty_walkers, guide_cos, guide_density, phase, phase_cos

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-0.25, 0.25)], np.float32)
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BOX = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))], np.int32)
COLOR, RADIUS = [0.8, 0.5, 0.3, 1.0], [1.0, 0.5, 0.25]


def flesh(kind="ShaderNodeSubsurfaceScattering", method="RANDOM_WALK", color=COLOR, scale=0.2, **values):
    """A material that scatters below its surface."""
    if kind == "ShaderNodeSubsurfaceScattering":
        inputs, output = {"Color": Socket(color, kind="RGBA"), "Scale": Socket(scale)}, "BSSRDF"
        inputs |= {"Radius": Socket(RADIUS, kind="VECTOR"), "Roughness": Socket(values.pop("Roughness", 1.0))}
        inputs |= {name: Socket(value) for name, value in values.items()}
    else:
        inputs, output = {"Base Color": Socket(color, kind="RGBA"), "Subsurface Scale": Socket(scale)}, "BSDF"
        inputs |= {"Subsurface Weight": Socket(1.0), "Subsurface Radius": Socket(RADIUS, kind="VECTOR")}
        inputs |= {name.replace("_", " "): Socket(value) for name, value in values.items()}
    props = {"falloff": method, "subsurface_method": method}
    return Material("Flesh", Graph([Node(kind, "F", props, inputs, {output: "SHADER"})], Socket(None, 0, output)))


def prepared(material, triangles=BOX):
    """A body, made ready."""
    mesh = Mesh("Body", CORNERS, triangles, None, None)
    place = np.eye(4)
    place[2, 3] = 3.0
    scene = SceneData(
        meshes=[mesh], instances=[Instance(0, np.eye(4), [0], "Body")], materials=[material],
        lights=[Light("Lamp", "POINT", place, (9.0, 9.0, 9.0))], camera=Camera(matrix=place),
        frame=Frame(4, 4, 0, 0, 4, 4),
    )  # fmt: skip
    return RenderScene(scene, Settings(), IssueLog(), lambda _text: None)


def light_from_everywhere(scene, n, seed=1):
    """n rays that fall on the body's surface evenly and by the cosine: hits, surfaces, directions, keys."""
    rng = np.random.default_rng(seed)
    geometry = scene.flat.geometry
    c = geometry.positions[geometry.triangles].astype(float)
    area = np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1)
    prim = rng.choice(len(area), n, p=area / area.sum()).astype(np.int32)
    a, b = rng.random((2, n))
    u, v = (1 - np.sqrt(a)).astype(np.float32), (np.sqrt(a) * b).astype(np.float32)
    p, ng, ns = (np.empty((n, 3), np.float32) for _ in range(3))
    surface_points(geometry, prim, u, v, p, ng, ns)
    wo = rng.normal(size=(n, 3))
    wo = ng + wo / np.linalg.norm(wo, axis=1, keepdims=True)  # cosine-distributed
    d = -(wo / np.linalg.norm(wo, axis=1, keepdims=True)).astype(np.float32)
    surfaces = scene.surfaces_at(Hits(prim, u, v, np.ones(n, np.float32)), d)
    return surfaces, d, rng.integers(0, 2**63, n, dtype=np.uint64)


def seen(scene, n):
    """(n, 3): what eye paths from everywhere see of a world of radiance 1, 0 for those that do not come out."""
    surfaces, d, keys = light_from_everywhere(scene, n)
    paths = empty_paths(n)
    paths.d[:], paths.beta[:], paths.key[:], paths.bare[:] = d, 1.0, keys, True
    paths.width[:], paths.spread[:] = 0.01, 0.0
    walkers, footprint = empty_walkers(n), np.empty(n, np.float32)
    walkers = head(walkers, eyes_below(scene.laws, scene.rules, surfaces, paths, 0, walkers, footprint))
    out, _ = walk(scene, walkers)
    light = np.zeros((n, 3))
    light[walkers.lane[out]] = walkers.beta[out]
    return light


def sent(scene, n):
    """(n, 3): the flux of photons of 1 W after their walks."""
    surfaces, d, keys = light_from_everywhere(scene, n, seed=2)
    photons = head(empty_photons(n), n)
    photons.d[:], photons.phi[:], photons.key[:] = d, 1.0, keys
    deep = deep_lists(n, True)
    deep[0][0], deep[0][1:] = n, np.arange(n)
    deep[1][:], deep[2][:] = np.argmax(surfaces.rows.kind[0] == SUBSURFACE), 1.0
    leg = Leg(0, 0, empty_lanes(), *(np.empty(1, np.int32) for _ in range(4)), NO_GAIN, *deep)
    out, tally = empty_photons(n), np.zeros((4, 3))
    alive, _ = carry_below(scene, leg, surfaces, photons, out, 0, tally)
    np.testing.assert_allclose(-tally[ABSORBED], out.phi[:alive].sum(axis=0, dtype=float), rtol=1e-5)
    assert (out.d[:alive] * out.d[:alive]).sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    light = np.zeros((n, 3))
    light[:alive] = out.phi[:alive]
    return light


CASES = {
    "rough": flesh(),
    "smooth": flesh(Roughness=0.0, IOR=1.6),
    "ahead": flesh(Anisotropy=0.7, Roughness=0.3),
    "back": flesh(Anisotropy=-0.6),
    "skin": flesh(method="RANDOM_WALK_SKIN"),
    "layered": flesh("ShaderNodeBsdfPrincipled", "RANDOM_WALK_LEGACY", scale=1.0, Roughness=0.4, Coat_Weight=0.5),
}


@pytest.mark.parametrize("name", CASES)
def test_photons_and_eye_paths_see_the_same(name):
    """In an even light both measure the mean of the same function of both ends. 100 000 each; noise 0.7%."""
    scene = prepared(CASES[name])
    ways = [light(scene, 100_000) for light in (seen, sent)]
    eye, photon = (way.mean(axis=0) for way in ways)
    error = np.sqrt(sum(way.var(axis=0) / len(way) for way in ways))
    assert (error < 0.009 * eye).all()
    assert (abs(photon - eye) < 4.0 * error).all(), photon / eye


STEPS = (np.arange(4000) + 0.5) / 4000


def assert_sampled(cosines, density, error):
    """As many of the cosines that evenly spread numbers give lie below a value as the density [1/sr] says."""
    for x in (-0.5, 0.6, 1.0):
        below = 2.0 * np.pi * np.mean([density(c) for c in -1.0 + STEPS * (x + 1.0)]) * (x + 1.0)
        assert (cosines <= x).mean() == pytest.approx(below, abs=error)


@pytest.mark.parametrize("g", [-0.8, 0.0, 0.5, 0.9])
def test_phase_function_is_sampled_as_it_is(g):
    cosines = np.array([phase_cos(g, u) for u in STEPS])
    assert cosines.mean() == pytest.approx(g, abs=1e-3)
    assert_sampled(cosines, lambda c: phase(g, c), 1e-3)


@pytest.mark.parametrize("length", [1.02, 1.5, 30.0])
def test_guide_is_sampled_as_it_is(length):
    cosines = np.array([guide_cos(length, u) for u in STEPS])
    assert_sampled(cosines, lambda c: guide_density(length, c), 1e-3)


def test_a_white_body_loses_nothing():
    """Albedo 1, free paths of the body's size: all light that goes in comes out. Noise 0.1%."""
    light = seen(prepared(flesh(color=[1.0, 1.0, 1.0, 1.0])), 40_000).mean(axis=0)
    np.testing.assert_allclose(light, 1.0, atol=0.01)


def test_a_walk_does_not_depend_on_its_batch():
    scene = prepared(flesh())
    whole = seen(scene, 512)
    surfaces, d, keys = light_from_everywhere(scene, 512)
    for part in (slice(0, 100), slice(100, 512)):
        some = surfaces._replace(**{name: getattr(surfaces, name)[part] for name in ("row", "prim", "u", "v", "t")})
        n = len(some.prim)
        paths = empty_paths(n)
        paths.d[:], paths.beta[:], paths.key[:], paths.bare[:] = d[part], 1.0, keys[part], True
        paths.width[:], paths.spread[:] = 0.01, 0.0
        walkers = empty_walkers(n)
        count = eyes_below(scene.laws, scene.rules, some, paths, 0, walkers, np.empty(n, np.float32))
        walkers = head(walkers, count)
        out, _ = walk(scene, walkers)
        light = np.zeros((n, 3))
        light[walkers.lane[out]] = walkers.beta[out]
        np.testing.assert_array_equal(light, whole[part])


@pytest.mark.parametrize("scale", [1e-9, 1e-6, 1.0, 1e9])
def test_open_bodies_and_any_radius_end(scale):
    """A box without its top: walks escape through the hole or end; nothing is without bound."""
    light = seen(prepared(flesh(scale=scale, Anisotropy=0.99), BOX[:-2]), 4000)
    assert np.isfinite(light).all() and light.mean() <= 1.0
