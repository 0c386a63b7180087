"""Random small scenes and settings: what must hold of all of them. The same examples each time."""

from __future__ import annotations

import copy

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from photon_engine.issues import IssueLog
from photon_engine.scene.data import Light
from photon_engine.settings import Settings
from photon_engine.transport.renderer import Renderer

from .brute import scenes as s
from .stability.lab import same_randoms, shoot
from .stability.transforms import moved, scaled

FIXED = settings(
    derandomize=True, database=None, deadline=None, max_examples=20, suppress_health_check=list(HealthCheck),
    phases=[Phase.explicit, Phase.generate],  # what fails is small enough; looking for smaller ones takes minutes
)  # fmt: skip
FEW = {"caustic_photons": 2000, "diffuse_photons": 2000}
unit = st.floats(0.0, 1.0)
place = st.tuples(*[st.floats(-0.6, 0.6)] * 3)


@st.composite
def materials(draw):
    """One of each kind; none gives back more than arrives."""
    color = draw(st.tuples(unit, unit, unit))
    kind = draw(st.sampled_from([
        "diffuse", "diffuse", "glass", "mirror", "rough", "clear", "mixed", "glow", "rough glass", "leaf", "principled",
    ]))  # fmt: skip
    if kind == "mixed":
        return s.mixed(s.diffuse(color), s.mirror(draw(unit)), draw(unit))
    if kind == "glow":
        return s.emitter(draw(st.floats(0.0, 5.0)), color)
    if kind == "rough":
        return s.material("BsdfAnisotropic", color, Roughness=draw(unit))
    if kind == "rough glass":
        return s.material("BsdfGlass", color, Roughness=draw(unit), IOR=draw(st.floats(1.0, 2.5)))
    if kind == "leaf":
        return s.material("BsdfTranslucent", color)
    if kind == "principled":
        names = ("Metallic", "Roughness", "Transmission Weight", "Coat Weight", "Sheen Weight", "Alpha")
        return principled(color, {name: draw(unit) for name in names})
    if kind == "glass":
        return s.glass(draw(st.floats(1.0, 2.5)), color)
    return {"diffuse": s.diffuse, "mirror": s.mirror, "clear": s.transparent}[kind](color)


def principled(color, values: dict[str, float]):
    """Blender's all-round surface, without emission."""
    inputs = {"Base Color": s.Socket([*color, 1.0], kind="RGBA"), **{k: s.Socket(v) for k, v in values.items()}}
    node = s.closure("BsdfPrincipled", inputs)
    return s.Material("Principled", s.Graph([node], s.Socket(node=0, output="BSDF", kind="SHADER")))


@st.composite
def shapes(draw):
    """A ball, a box or a tilted quad within [-1, 1]^3."""
    at, size = np.array(draw(place)), draw(st.floats(0.05, 0.35))
    kind = draw(st.sampled_from(["ball", "box", "quad"]))
    if kind == "ball":
        return s.sphere(at, size, 12, draw(st.booleans()))
    if kind == "box":
        return s.box(at - size, at + size)
    return s.quad(at, (size, 0, 0.5 * size), (0, size, 0.2 * size))


@st.composite
def lamps(draw):
    """A lamp of any kind in the upper half of the room."""
    x, y, _ = draw(place)
    kind = draw(st.sampled_from(["area", "point", "ball", "sun", "spot"]))
    power = draw(st.floats(0.5, 20.0))
    if kind == "sun":
        return s.sun_lamp((x, y, -1.0), draw(st.floats(0.0, 1.0)), 0.2 * power)
    if kind == "spot":
        matrix, strength = s.look_at((x, y, 0.9), (y, x, -1.0)), (power, power, 0.5 * power)
        size, blend = draw(st.floats(0.2, 3.0)), draw(unit)
        return Light("Spot", "SPOT", matrix, strength, radius=0.1, spot_size=size, spot_blend=blend)
    if kind == "area":
        return s.area_lamp((x, y, 0.9), (0, 0, 0), draw(st.floats(0.05, 0.5)), power)
    return s.point_lamp((x, y, 0.7), 0.2 if kind == "ball" else 0.0, power)


@st.composite
def scenes(draw):
    """An open room with a few things in it, 8 x 8 pixels."""
    parts = s.room()
    parts += [(draw(shapes()), draw(materials())) for _ in range(draw(st.integers(0, 3)))]
    lights = [draw(lamps()) for _ in range(draw(st.integers(1, 2)))]
    world = draw(st.sampled_from([(0.0, 0.0, 0.0), (0.3, 0.4, 0.5)]))
    view = draw(st.sampled_from([
        s.camera((0, -4, 0), (0, 0, 0), 0.34),
        s.camera((0, -4, 0), (0, 0, 0), 0.34, aperture_radius=0.2, focus_distance=4.0, blades=5),
        s.camera((0, -4, 0), (0, 0, 0), 1.1, kind="ORTHO"),
    ]))  # fmt: skip
    scene = s.build(parts, lights, copy.deepcopy(view), world, s.frame(8, transparent=draw(st.booleans())))
    odd = scene.instances[-1]
    odd.holdout, odd.visible_shadow, odd.visible_camera = draw(st.sampled_from([
        (False, True, True), (False, True, True), (True, True, True), (False, False, True), (False, True, False),
    ]))  # fmt: skip
    return scene


options = st.fixed_dictionaries(
    {
        "final_gather": st.sampled_from(["OFF", "GLOSSY", "ALL"]),
        "max_bounces": st.integers(1, 64),
        "diffuse_bounces": st.integers(0, 8),
        "light_samples": st.integers(1, 8),
        "splits": st.integers(0, 4),
        "specular_threshold": st.floats(0.0, 0.5),
        "caustic_radius": st.floats(0.0, 20.0),
        "diffuse_radius": st.floats(0.05, 50.0),
        "alpha": st.floats(0.01, 1.0),
        "seed": st.integers(0, 2**31 - 1),
    }
)


@FIXED
@given(scenes(), options)
def test_pictures_are_finite_and_not_negative_and_photons_keep_their_energy(scene, chosen):
    """`shoot` looks at every pass. What lights emit is absorbed, escapes, or is dropped after the last bounce."""
    shoot(scene, 2, **FEW, **chosen)
    renderer = Renderer(scene, Settings(**FEW, threads=1, **chosen), IssueLog())
    try:
        renderer.prepare(lambda text: None)
        for i in range(4):
            renderer.render_pass(i, lambda: False)
    finally:
        renderer.close()
    for name, (emitted, *ends) in renderer.statistics["flux"].items():
        # roulette keeps energy in the mean only: 8000 photons, each worth up to a few times the mean
        assert (np.abs(sum(ends) - emitted) <= 0.1 * emitted.max() + 1e-6).all(), (name, emitted, ends)


@FIXED
@given(scenes(), st.sampled_from([2.0**-7, 0.37, 2.0**9]), st.tuples(*[st.floats(-1e4, 1e4)] * 3), options)
def test_scale_and_place_do_not_matter(scene, k, offset, chosen):
    chosen = FEW | chosen
    one = shoot(scene, 2, **chosen)
    found = same_randoms(one, shoot(moved(scaled(scene, k), offset), 2, **chosen), allowed=0.02)
    assert found.good or not one.mean().any(), found.figure


def alike(one, two) -> None:
    """Two renders with other random numbers of the same picture: each light pass's mean within its noise."""
    for name in one.passes:
        a, b = (shot.passes[name].mean(axis=(1, 2, 3)) for shot in (one, two))
        noise = np.hypot(a.std(ddof=1), b.std(ddof=1)) / np.sqrt(len(a))
        assert abs(a.mean() - b.mean()) <= 6.0 * noise + 0.02 * a.mean() + 1e-6, (name, a.mean(), b.mean(), noise)


@FIXED
@given(scenes(), st.randoms(use_true_random=False), options)
def test_the_order_of_objects_and_lamps_does_not_matter(scene, random, chosen):
    other = copy.deepcopy(scene)
    random.shuffle(other.instances)
    random.shuffle(other.lights)
    alike(shoot(scene, 8, **FEW, **chosen), shoot(other, 8, **FEW, **chosen))


@FIXED
@given(scenes(), st.tuples(*[st.floats(-3.0, 3.0)] * 3), options)
def test_a_turned_world_looks_the_same(scene, angles, chosen):
    """Everything turned about the origin, the camera too."""
    turn = np.eye(4)
    for axis, angle in enumerate(angles):
        i, j = [k for k in range(3) if k != axis]
        step = np.eye(4)
        step[i, i], step[i, j], step[j, i], step[j, j] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
        turn = step @ turn
    other = copy.deepcopy(scene)
    for item in (*other.instances, *other.lights, other.camera):
        item.matrix = turn @ item.matrix
    alike(shoot(scene, 8, **FEW, **chosen), shoot(other, 8, **FEW, **chosen))
