"""What a plan leaves out adds nothing: every picture is the same to the bit with and without it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from ...film.passes import ALL_NAMES, LIGHT_NAMES
from ...issues import IssueLog
from ...photons.batch import Photons, empty_photons
from ...plan import LABELS, OFF, make_plan
from ...scene.reach import misses
from ...settings import Settings
from ...survey import survey
from ..cull import keep_those_that_meet
from ..renderer import Renderer
from .plan_scenes import LAMPS, MATERIALS, scene

FEW = {"caustic_photons": 400, "diffuse_photons": 400, "light_samples": 1, "threads": 1}
ASKED = tuple(sorted(name for name in ALL_NAMES if not name.startswith(("Noisy", "Denoising")) and name != "Combined"))


def render(data, outputs=ALL_NAMES, **values):
    """Pass 1 of a scene: its pictures, and the renderer's statistics."""
    renderer = Renderer(data, Settings(**{**FEW, **values}), IssueLog(), frozenset(outputs))
    try:
        renderer.prepare(lambda _text: None)
        return renderer.render_pass(1, lambda: False), renderer
    finally:
        renderer.close()


scenes = st.fixed_dictionaries(
    {
        "floor": st.sampled_from(list(MATERIALS)),
        "wall": st.sampled_from(list(MATERIALS)),
        "pane": st.sampled_from(list(MATERIALS)),
        "lamps": st.lists(st.sampled_from(list(LAMPS)), max_size=2, unique=True),
        "sky": st.sampled_from([0.0, 0.5]),
        "aperture": st.sampled_from([0.0, 0.1]),
        "ghost": st.booleans(),
        "spare": st.booleans(),
    }
)
choices = st.fixed_dictionaries(
    {
        "final_gather": st.sampled_from(["AUTO", "OFF", "GLOSSY", "ALL"]),
        "diffuse_bounces": st.sampled_from([0, 1, 64]),
        "max_bounces": st.sampled_from([1, 2, 64]),
    }
)


# these change random numbers; tests of their own say that they change nothing else
OTHER_NUMBERS = {"idle_lamps", "sun_rays"}


# in one of these each of the others runs, in another it is left out
RICH = (
    {"floor": "Matte", "wall": "Wax", "pane": "Ink", "lamps": ["Bulb"], "sky": 0.5, "aperture": 0.1, "ghost": True,
     "spare": True},
    {"final_gather": "ALL", "diffuse_bounces": 64, "max_bounces": 64, "eye_samples": 2}, {"Depth"}, True,
)  # fmt: skip
PLAIN = (
    {"floor": "Matte", "wall": "Polished", "pane": "Painted", "lamps": ["Point"], "sky": 0.0, "aperture": 0.0,
     "ghost": False, "spare": False},
    {"final_gather": "GLOSSY", "diffuse_bounces": 64, "max_bounces": 64}, {"Direct"}, False,
)  # fmt: skip


def test_the_plan_changes_no_bit():
    """And every decision is made both ways in some of these scenes."""
    decided = set()

    @given(scenes, choices, st.sets(st.sampled_from(ASKED), min_size=1, max_size=3), st.booleans())
    @example(*RICH)
    @example(*PLAIN)
    @settings(
        max_examples=40, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
    )
    def check(which, how, asked, maps):
        whole, _ = render(scene(**which), plan=False, **how)
        planned, renderer = render(scene(**which), **how)
        for name, picture in whole.items():
            np.testing.assert_array_equal(planned[name], picture, err_msg=f"{name}: {renderer.plan}")
        some, alone = render(scene(**which), {*asked, *(["Noise"] if maps else [])}, **how)
        for name in asked:
            np.testing.assert_array_equal(some[name], whole[name], err_msg=f"only {asked}, {name}: {alone.plan}")
        for made in (renderer.plan, alone.plan):
            decided.update((name, bool(getattr(made, name))) for name in LABELS)

    check()
    missing = {(name, runs) for name in LABELS if name not in OTHER_NUMBERS for runs in (True, False)} - decided
    assert missing == {("stray_photons", True), ("unworn", True)}  # only plan=off does these


def plan(data, outputs=frozenset(LIGHT_NAMES), **values):
    return make_plan(data, Settings(**values), outputs)


LEFT_OUT = [
    ("caustic_map", {"pane": "Matte"}, {}, "no specular surface"),
    ("caustic_map", {"pane": "Hidden"}, {}, "no specular surface"),
    ("caustic_map", {"floor": "Mirror", "wall": "Black"}, {}, "no rough surface"),
    ("caustic_map", {}, {"caustic_photons": 0}, "Caustic Photons is 0"),
    ("diffuse_map", {"floor": "Black", "wall": "Black"}, {}, "no rough surface"),
    ("diffuse_map", {}, {"diffuse_bounces": 0}, "Diffuse Bounces is 0"),
    ("diffuse_map", {}, {"max_bounces": 1, "final_gather": "OFF"}, "Bounces is 1"),
    ("diffuse_map", {"lamps": ["Dead"]}, {}, "nothing shines"),
    ("direct", {"lamps": []}, {}, "nothing shines"),
    ("idle_lamps", {}, {}, "there is none"),
    ("sun_rays", {"lamps": ["Sun"], "sky": 1.0}, {}, "whether Sun is seen, the others go to Sky"),
    ("stray_photons", {}, {}, "miss"),
    ("mirrors", {"pane": "Satin"}, {}, "no specular surface"),
    ("more_paths", {}, {"eye_samples": 1}, "Camera Paths is 1"),
    ("direct", {"floor": "Glass", "wall": "Mirror"}, {}, "no rough surface"),
    ("lobe_rays", {"lamps": ["Point", "Sun", "Beam"], "wall": "Satin"}, {}, "no ray can meet a light"),
    ("subsurface", {}, {}, "no material scatters below"),
    ("see_through", {}, {}, "every surface stops light"),
    ("gather_narrow", {"wall": "Satin"}, {}, "no narrow glossy surface"),
    ("gather_all", {}, {}, "Final Gather is Glossy"),
    ("emission", {"lamps": ["Point"]}, {}, "no visible source"),
    ("environment", {}, {}, "the world is black"),
    ("media", {}, {}, "no inside absorbs"),
    ("lens", {}, {}, "pinhole"),
    ("textures", {}, {}, "no material varies"),
    ("unworn", {"spare": True}, {}, "Spare"),
    ("guides", {}, {}, "nothing is denoised"),
    ("variance", {}, {}, "no map of the error"),
]
RUNS = [
    ("diffuse_map", {}, {"max_bounces": 1, "final_gather": "ALL"}, "between Matte"),
    ("caustic_map", {}, {}, "Glass may focus light on Matte"),
    ("more_paths", {}, {"eye_samples": 2}, "Camera Paths is 2"),
    ("diffuse_map", {}, {}, "between Matte"),
    ("direct", {"lamps": ["Point"]}, {}, "Point on Matte"),
    ("direct", {"lamps": [], "pane": "Glow"}, {}, "Glow on Matte"),
    ("lobe_rays", {"lamps": ["Point"], "wall": "Polished"}, {}, "gather diffuse light"),
    ("lobe_rays", {"lamps": ["Point", "Bulb"]}, {}, "may meet Bulb"),
    ("sun_rays", {"lamps": ["Soft Sun"], "sky": 1.0}, {}, "no narrow sun"),
    ("sun_rays", {"lamps": ["Sun", "Bulb"], "sky": 1.0}, {}, "nothing but the world"),
    ("sun_rays", {"lamps": ["Sun"], "sky": 1.0}, {"light_samples": 1}, "one shadow ray"),
    ("see_through", {"pane": "Half"}, {}, "light passes Half"),
    ("see_through", {"ghost": True}, {}, "light passes Pane"),
    ("caustic_points", {}, {}, "Caustic shows them"),
    ("mirrors", {}, {}, "Glass shows other things"),
    ("gather_narrow", {"wall": "Polished"}, {}, "Polished reflects too narrowly"),
    ("gather_all", {}, {"final_gather": "ALL"}, "Final Gather is All"),
    ("emission", {"lamps": [], "pane": "Glow"}, {}, "Glow can be seen"),
    ("environment", {"sky": 1.0}, {}, "Sky gives light"),
    ("lens", {"aperture": 0.1}, {}, "aperture of 100 mm"),
    ("textures", {"pane": "Painted"}, {}, "Painted reads uv"),
    ("guides", {}, {"denoise": "FINAL"}, "the picture is denoised"),
]


@pytest.mark.parametrize(("name", "which", "how", "reason"), LEFT_OUT)
def test_left_out_with_a_reason(name, which, how, reason):
    decision = getattr(plan(scene(**which), **how), name)
    assert not decision and reason in decision.reason


@pytest.mark.parametrize(("name", "which", "how", "reason"), RUNS)
def test_runs_with_a_reason(name, which, how, reason):
    decision = getattr(plan(scene(**which), **how), name)
    assert decision and reason in decision.reason


def test_only_what_is_asked_for_is_done():
    one = plan(scene(wall="Polished", sky=1.0), {"Caustic", "Depth"})
    assert one.caustic_map and not (one.direct or one.lobe_rays or one.diffuse_map or one.emission or one.environment)
    assert one.direct.reason == "Direct is not asked for"
    left = [line.name for line in plan(scene(sky=1.0), {"Depth"}).lines() if line.runs]
    assert left == [LABELS["sun_rays"]]  # says nothing of whether there is direct light
    every = plan(scene(), {"Combined"})
    assert every.outputs == {"Combined"} and every.caustic_map and every.diffuse_map and every.direct


def test_pictures_that_are_asked_for_by_name_are_made():
    assert plan(scene(), {"Denoising Normal"}).guides and plan(scene(), {"Noise"}).variance


def turned(light, matrix, z=2.0):
    """A lamp with this rotation, somewhere above the floor."""
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = matrix, (0.1, 0.0, z)
    return replace(light, matrix=place)


def test_a_lamp_out_of_reach_is_as_if_it_were_not_there():
    up = np.diag([1.0, -1.0, -1.0])
    here, there = LAMPS["Area"], [turned(LAMPS[name], up, 4.5) for name in ("Spot", "Area", "Beam")]
    data = scene()
    data.lights = [there[0], here, *there[1:]]
    picture, renderer = render(data)
    assert renderer.plan.idle_lamps.reason == "Spot, Area and 1 more reach nothing that scatters light"
    assert len(renderer.scene.lights.kind) == 1
    for name, expected in render(scene(), plan=False)[0].items():
        np.testing.assert_array_equal(picture[name], expected)
    data.lights = there
    assert render(data)[1].plan.direct.reason == "nothing shines"
    assert render(data, plan=False)[1].plan.idle_lamps.reason == OFF
    data.lights = [turned(light, np.eye(3)) for light in there]  # down
    assert not survey(data, 0.05).idle


@given(st.sampled_from(["Spot", "Area", "Beam"]), st.integers(0, 2**31), st.floats(0.1, 3.0))
@settings(max_examples=60, deadline=None, derandomize=True, database=None)
def test_what_counts_as_out_of_reach_lights_nothing(kind, seed, opening):
    """And what lights a surface near the middle of its cone is never out of reach."""
    rng = np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.diag(rng.uniform(0.5, 2.0, 3))
    lamp = turned(LAMPS[kind], rotation, rng.uniform(0.5, 6.0))
    lamp = replace(lamp, spot_size=opening, spread=0.0 if kind == "Beam" else opening, radius=rng.choice([0.0, 0.3]))
    lamp.matrix[:2, 3] = rng.uniform(-4.0, 4.0, 2)
    data = scene()
    data.lights = [lamp]
    boxes = np.array([[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]])
    axis = -lamp.matrix[:3, 2] / np.linalg.norm(lamp.matrix[:3, 2])
    if axis[2] < 0.0:
        hit = lamp.matrix[:2, 3] - axis[:2] / axis[2] * lamp.matrix[2, 3]
        assert not (np.abs(hit) < 1.0).all() or not misses(lamp, boxes)
    if survey(data, 0.05).idle:
        whole, _ = render(data, plan=False)
        assert not any(whole[name].any() for name in LIGHT_NAMES)


def test_a_narrow_sun_gets_one_ray_and_the_sky_the_others():
    """The same mean, and less noise under the sky, which had 1 of 4 rays and has 3; edges of the pane remain."""
    data = scene(pane="Matte", wall="Satin", lamps=["Sun"], sky=0.2)
    passes = {}
    for plan in (True, False):
        renderer = Renderer(data, Settings(**{**FEW, "light_samples": 4, "plan": plan, "seed": plan}), IssueLog())
        renderer.prepare(lambda _text: None)
        passes[plan] = np.stack([renderer.render_pass(i, lambda: False)["Direct"] for i in range(256)])
        renderer.close()
    one, off = passes[True], passes[False]
    error = np.sqrt((one.var(axis=0) + off.var(axis=0)) / 256)
    difference = (one.mean(axis=0) - off.mean(axis=0))[error > 0.0] / error[error > 0.0]
    assert np.sqrt((difference**2).mean()) == pytest.approx(1.0, abs=0.2)  # 75 pixels that see light
    assert abs(one.mean() / off.mean() - 1.0) < 0.01
    assert one.var(axis=0).mean() < 0.97 * off.var(axis=0).mean()  # measured 0.92


def test_photons_that_pass_all_boxes_are_not_carried():
    boxes = np.array([[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]], [[3.0, 3.0, 3.0], [4.0, 4.0, 4.0]]])
    rng = np.random.default_rng(0)
    n = 4000
    photons = empty_photons(n)
    photons.o[:] = rng.uniform(-3.0, 5.0, (n, 3))
    photons.d[:] = rng.normal(size=(n, 3))
    photons.d[np.arange(200), rng.integers(0, 3, 200)] = 0.0
    photons.d[:] /= np.linalg.norm(photons.d, axis=1, keepdims=True)
    photons.phi[:], photons.key[:], photons.dark[:] = rng.random((n, 3)), np.arange(n), rng.random(n)
    lines = photons.o[:, None] + photons.d[:, None] * np.linspace(0.0, 20.0, 1500, dtype=np.float32)[:, None]
    thick = boxes + np.array([[-0.02], [0.02]])  # points along a ray are nearer than this to its crossing of the square
    inside = [((lines >= low) & (lines <= high)).all(axis=2).any(axis=1) for low, high in thick]
    grazing = [((lines >= low - 0.1) & (lines <= high + 0.1)).all(axis=2).any(axis=1) for low, high in thick]
    before, lost = Photons(*(field.copy() for field in photons)), np.zeros(3)
    kept = keep_those_that_meet(boxes, 1.0, photons, lost)
    assert set(np.flatnonzero(np.any(grazing, axis=0))) >= set(kept.key.astype(int))
    missed = set(np.flatnonzero(np.any(inside, axis=0))) - set(kept.key.astype(int))
    assert 100 < len(kept.key) and len(missed) < 0.15 * len(kept.key)  # those that touch only what is thickened
    index = kept.key.astype(int)
    assert (np.diff(index) > 0).all()
    for name in ("o", "d", "phi", "dark"):
        np.testing.assert_array_equal(getattr(kept, name), getattr(before, name)[index])
    np.testing.assert_allclose(lost, before.phi.sum(axis=0) - before.phi[index].sum(axis=0), rtol=1e-4)


def test_all_photons_are_carried_where_few_pass_the_boxes():
    """One in ten: the test would cost more than their rays."""
    boxes = np.array([[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]])
    n = 3000
    photons, lost = empty_photons(n), np.zeros(3)
    photons.o[:], photons.d[:], photons.phi[:] = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0
    photons.d[::10] = [0.0, 0.0, 1.0]
    photons.key[:] = np.arange(n)
    assert len(keep_those_that_meet(boxes, 1.0, photons, lost).key) == n and not lost.any()
    photons.d[::2] = [0.0, 0.0, 1.0]
    assert keep_those_that_meet(boxes, 1.0, photons, lost).key.tolist() == list(range(1, n, 2))
    np.testing.assert_array_equal(lost, n / 2)


def test_narrow_surfaces_seen_by_a_final_gather_need_all_light():
    """What they reflect is in Diffuse, whatever else is asked for: caustics and shadows through glass too."""
    which = {"floor": "Polished", "wall": "Polished", "pane": "Glass", "ghost": True}
    only = plan(scene(**which), {"Diffuse"})
    assert only.caustic_map and not only.caustic_points and not only.direct and only.see_through
    whole, _ = render(scene(**which), caustic_photons=4000)
    alone, _ = render(scene(**which), {"Diffuse"}, caustic_photons=4000)
    np.testing.assert_array_equal(alone["Diffuse"], whole["Diffuse"])
    assert alone["Diffuse"].any() and not alone["Caustic"].any() and not alone["Direct"].any()


def test_a_lamp_that_lights_only_what_scatters_nothing_is_out_of_reach():
    """A glowing sheet behind the lamps, as of a backdrop, is no receiver; a black one neither."""
    data = scene(wall="Black", pane="Glow", lamps=["Spot", "Area"])
    away = turned(LAMPS["Spot"], np.diag([1.0, -1.0, -1.0]), 4.5)
    data.instances[2].matrix[2, 3] = 6.0
    data.lights.append(away)
    assert survey(data, 0.05).idle == (2,)
    data.materials[2] = replace(data.materials[2], graph=MATERIALS["Clear"])
    assert survey(data, 0.05).idle == (2,)
    data.materials[2] = replace(data.materials[2], graph=MATERIALS["Half"])
    assert survey(data, 0.05).idle == ()


# only this picture asked for: which photons are traced, and whether eye rays are those of the pixels alone
ALONE = [
    ("Direct", set(), False), ("Caustic", {"caustic"}, False), ("Diffuse", {"diffuse"}, False),
    ("Emission", set(), True), ("Environment", set(), True),
    ("Depth", set(), True), ("Normal", set(), True), ("Albedo", set(), True),
]  # fmt: skip


@pytest.mark.parametrize(("name", "photons", "bare"), ALONE)
def test_a_picture_alone_costs_its_own_work_only(name, photons, bare):
    whole, off = render(scene(lamps=["Point"], sky=0.5), plan=False, splits=0)
    alone, renderer = render(scene(lamps=["Point"], sky=0.5), {name}, splits=0)
    np.testing.assert_array_equal(alone[name], whole[name])
    assert alone[name].any() or name == "Emission"  # of a point nothing is seen
    counts = renderer.statistics
    assert set(counts["photons"]) == photons and set(counts["rays"]) == {"eye", *photons}
    pixels, seen = 12 * 12, counts["rays"]["eye"]
    if name in ("Depth", "Normal", "Albedo"):
        assert seen == pixels and (renderer.pilot.footprint, renderer.plan.mirrors.runs) == (0.0, False)
    elif bare:
        assert pixels < seen < 2 * pixels  # through the pane
    assert seen < off.statistics["rays"]["eye"]


def test_off_runs_everything_that_can_run():
    whole = plan(scene(floor="Black", wall="Black", pane="Black", lamps=["Sun"]), {"Depth"}, plan=False)
    # what the scene is, and settings
    unneeded = {"lens", "media", "subsurface", "textures", "gather_all", "more_paths"}
    assert all(getattr(whole, name) for name in LABELS if name not in unneeded)
    assert whole.direct.reason == OFF
    dark = plan(scene(lamps=[]), plan=False)
    assert not (dark.direct or dark.caustic_map or dark.diffuse_map)  # no photon can leave nothing


def test_every_decision_is_told():
    lines = plan(scene(pane="Matte")).lines()
    assert [line.name for line in lines] == list(LABELS.values()) and all(line.reason for line in lines)
    assert "Caustic map: left out, no specular surface" in map(str, lines)


def test_what_is_left_out_costs_nothing():
    _, lean = render(scene(pane="Matte", wall="Satin"))
    _, whole = render(scene(pane="Matte", wall="Satin"), plan=False)
    assert "caustic" not in lean.statistics["rays"] and whole.statistics["rays"]["caustic"] > 0
    assert lean.statistics["photons"]["diffuse"] < 0.7 * whole.statistics["photons"]["diffuse"]  # no first hits
    _, only = render(scene(), {"Caustic"})
    assert "diffuse" not in only.statistics["rays"]
    # no shadow rays; eye paths, of which a split makes several, and looks around remain, many on so small a picture
    assert only.statistics["rays"]["eye"] < 0.9 * render(scene())[1].statistics["rays"]["eye"]


def test_a_light_picture_is_black_when_only_others_are_asked_for():
    picture, _ = render(scene(), {"Caustic"})
    assert picture["Caustic"].any() and not any(picture[name].any() for name in LIGHT_NAMES if name != "Caustic")
