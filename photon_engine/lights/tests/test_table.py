"""What of a scene's lights gets into the table."""

import math

import numpy as np
import pytest

from ...issues import IssueLog, RenderError
from ...scene.data import SceneData, World
from .. import table as laws
from ..select import pick, search, select_light, selection_p
from .scenes import EMITTERS, LAMPS, NO_EMITTERS, RGB, TILTED, WORLD, frame, lamp, table


def test_order_is_lamps_mesh_world():
    lights = table([LAMPS["sun"], LAMPS["point"]], EMITTERS, WORLD)
    assert list(lights.kind) == [laws.POINT, laws.SUN, laws.MESH, laws.WORLD]


def test_dark_lights_are_left_out():
    dark = lamp("POINT", strength=(0.0, 0.0, 0.0))
    flat = lamp("AREA", frame(scale=(1.0, 0.0, 1.0)))
    closed = lamp("SPOT", spot_size=0.0)
    black = EMITTERS._replace(radiance=np.zeros((2, 3), np.float32))
    assert len(table([dark, flat, closed], black).kind) == 0
    assert list(table([dark, LAMPS["point"]]).kind) == [laws.POINT]


def test_origin_is_subtracted():
    far = frame((1e6 + 0.25, 2e6, 3e6))
    lights = table([lamp("POINT", far)], origin=np.array([1e6, 2e6, 3e6]))
    assert lights.position[0] == pytest.approx([0.25, 0.0, 0.0], abs=1e-9)


def test_triangles_keep_their_ids():
    lights = table(emitters=EMITTERS)
    assert list(lights.emitter_of_tri) == [-1, -1, 1, -1, -1, 0, -1, -1]
    assert lights.tri_cdf[-1] == 1.0


def test_every_light_gets_photons():
    """PHOTON_FLOOR of them, evenly, and by area among triangles."""
    bright = lamp("POINT", strength=(1e9, 1e9, 1e9))
    shares = np.diff(table([lamp("POINT"), bright]).photon_cdf, prepend=0.0)
    assert sorted(shares) == pytest.approx([0.025, 0.975], abs=1e-6)
    dim = EMITTERS._replace(radiance=np.float32([[1e-9] * 3, [1.0] * 3]))
    lights = table(emitters=dim)
    share = 0.05 * lights.tri_area[0] / lights.tri_area.sum()
    assert lights.tri_cdf[0] == pytest.approx(share, rel=1e-3)


def test_flux_by_kind():
    s = np.array(RGB)
    assert table([lamp("POINT", radius=0.3)]).flux[0] == pytest.approx(s)
    assert table([lamp("AREA", size=(0.3, 1.0), spread=1.0)]).flux[0] == pytest.approx(s)
    assert table([lamp("SUN", angle=0.2)]).flux[0] == pytest.approx(s * math.pi * 25.0)
    assert table(world=World(color=(1.0, 1.0, 1.0))).flux[0] == pytest.approx(4 * math.pi**2 * 25.0)
    spot = table([lamp("SPOT", spot_size=1.0, spot_blend=0.4)]).flux[0]
    assert spot == pytest.approx(s / (4 * math.pi) * 2 * math.pi * (1 - math.cos(0.5)) * 0.8, rel=1e-4)  # midpoint rule


def test_flux_of_a_lamp_outside_counts_what_enters():
    """A point 50 m from a scene of 5 m: the share of the sphere's directions, (1 - sqrt(1 - 1/100)) / 2."""
    lights = table([lamp("POINT", frame((0.0, 0.0, 50.0)))])
    assert lights.flux[0] == pytest.approx(np.array(RGB) * (1.0 - math.sqrt(0.99)) / 2.0)


@pytest.mark.parametrize(
    "change",
    [{"matrix": np.full((4, 4), np.nan)}, {"strength": (math.inf, 0.0, 0.0)}, {"radius": math.nan}, {"kind": "HEMI"}],
)
def test_impossible_lamps_stop_the_render_by_name(change):
    item = lamp("POINT")
    for name, value in change.items():
        setattr(item, name, value)
    item.name = "Key light"
    with pytest.raises(RenderError, match="Key light"):
        table([item])


@pytest.mark.parametrize(
    ("item", "kept"),
    [
        (lamp("POINT", strength=(-1.0, 2.0, 0.0)), True),
        (lamp("POINT", strength=(-1.0, 0.0, 0.0)), False),
        (lamp("SUN", TILTED @ np.diag([0.0, 0.0, 0.0, 1.0])), False),
        (lamp("SPOT", frame(scale=(1.0, 0.0, 1.0)), spot_size=1.0), False),
        (lamp("AREA", frame() @ np.array([[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])), True),
    ],
)
def test_odd_lamps_are_told(item, kept):
    issues = IssueLog()
    lights = table([item], issues=issues)
    assert len(lights.kind) == int(kept)
    assert np.all(lights.radiance >= 0.0)
    assert [issue.object for issue in issues] == [item.name]


def test_a_world_that_is_not_finite_stops_the_render():
    with pytest.raises(RenderError, match="Sky"):
        table(world=World("Sky", color=(math.nan, 0.0, 0.0)))


def test_empty_scene_without_extent():
    lights = laws.build_lights(SceneData(world=WORLD), NO_EMITTERS, 0, np.zeros(3), 0.0, np.zeros(3))
    assert lights.radius > 0.0 and np.all(np.isfinite(lights.flux))


def test_frequencies_of_selection_are_its_probabilities():
    lights = table(list(LAMPS.values()), EMITTERS, WORLD)
    n = len(lights.kind)
    for p in ((0.0, 0.0, 0.0), (0.5, -0.5, 1.9), (3.0, -2.0, 4.0)):
        q = np.array([selection_p(lights, l, p) for l in range(n)])
        assert q.sum() == pytest.approx(1.0)
        found = np.zeros(n)
        for u in (np.arange(1000) + 0.5) / 1000:
            l, probability, fresh = select_light(lights, p, u)
            assert probability == pytest.approx(q[l], rel=1e-12) and 0.0 <= fresh < 1.0
            found[l] += 1.0
        assert found / 1000 == pytest.approx(q, abs=1.0001 / 1000)


def test_nothing_selects_nothing():
    assert select_light(table(), (0.0, 0.0, 0.0), 0.5)[0] == -1
    behind = [lamp("AREA", frame((0.0, 0.0, z), (0.0, 0.0, 0.0))) for z in (1.0, 2.0)]
    assert select_light(table(behind), (0.0, 0.0, 3.0), 0.5)[0] == -1


def test_pick_uses_every_entry_by_its_share():
    cdf = np.array([0.0, 0.25, 0.25, 1.0])
    assert [search(cdf, u) for u in (0.0, 0.2499, 0.25, 0.999)] == [1, 1, 3, 3]
    i, p, fresh = pick(cdf, 0.4)
    assert (i, p) == (3, 0.75) and fresh == pytest.approx(0.2)


def test_brighter_and_nearer_lamps_are_chosen_more_often():
    near, far = lamp("POINT", frame((0.0, 0.0, 1.0))), lamp("POINT", frame((0.0, 0.0, 10.0)))
    lights = table([near, far])
    assert selection_p(lights, 0, (0.0, 0.0, 0.0)) == pytest.approx(0.8 * 100 / 101 + 0.1)
