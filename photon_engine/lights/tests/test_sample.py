"""Light sampling and rays that meet lights: same irradiance, and the one that theory gives."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ...sampling.tests.chi2 import least, p_value
from ..sample import lamps_along_ray, sample_light, suns_along_ray
from .brute import (
    BOTH,
    LIGHTS_ONLY,
    RAYS_ONLY,
    assert_same,
    density_from_above,
    direction_pdf,
    emitter_ids,
    irradiance,
    mean_and_error,
    sampled_directions,
    uniform,
)
from .scenes import DELTAS, EMITTERS, LAMPS, RGB, SINGLE, WORLD, frame, lamp, table

N = 40_000
TRIS = emitter_ids(EMITTERS)
UP = (0.0, 0.0, 1.0)


def estimate(lights, p=(0.0, 0.0, 0.0), ns=UP, how=LIGHTS_ONLY, n=N, seed=11):
    out = np.empty((n, 3))
    irradiance(lights, TRIS, p, ns, uniform(n, 5, seed), how, out)
    assert np.all(np.isfinite(out))
    return mean_and_error(out)


def polygon(corners, radiance, p, ns):
    """Irradiance of a Lambertian polygon above the horizon: L/2 sum of edge angles along the normal [Lambert 1760]."""
    v = np.asarray(corners, float) - p
    v /= np.linalg.norm(v, axis=1)[:, None]
    total = 0.0
    for a, b in zip(v, np.roll(v, -1, 0), strict=True):
        edge = np.cross(a, b)
        total += math.acos(np.clip(a @ b, -1, 1)) * edge @ ns / np.linalg.norm(edge)
    return 0.5 * abs(total) * np.asarray(radiance)


S = np.array(RGB)


def cases():
    """name -> (lamp or table, p, ns, exact irradiance)."""
    above = frame((0.0, 0.0, 2.0))
    d2 = 1.0 + 4.0
    cosine = 2.0 / math.sqrt(d2)
    p = (1.0, 0.0, 0.0)
    half = 0.5
    x = (math.cos(math.atan(0.5)) - math.cos(half)) / ((1.0 - math.cos(half)) * 1.0)
    square = [(-0.5, -0.5, 2.0), (0.5, -0.5, 2.0), (0.5, 0.5, 2.0), (-0.5, 0.5, 2.0)]
    sphere_le = S / (4 * math.pi**2 * 0.25)
    return {
        "point": (lamp("POINT", above), p, UP, S / (4 * math.pi) * cosine / d2),
        "point not normalised": (lamp("POINT", above, normalize=False), p, UP, S / math.pi * cosine / d2),
        "sphere": (
            lamp("POINT", above, radius=0.5, soft_falloff=False),
            p,
            UP,
            sphere_le * math.pi * 0.25 / d2 * cosine,
        ),
        "inside a sphere": (lamp("POINT", above, radius=3.0, soft_falloff=False), p, UP, S / (4 * math.pi * 9.0)),
        "soft on axis": (lamp("POINT", above, radius=0.5), (0.0, 0.0, 0.0), UP, S / (4 * math.pi * (4.0 + 0.25))),
        "soft very near": (lamp("POINT", above, radius=0.5), (0.0, 0.0, 1.99), UP, S / (4 * math.pi * (1e-4 + 0.25))),
        "spot": (
            lamp("SPOT", above, spot_size=1.0, spot_blend=1.0),
            p,
            UP,
            S / (4 * math.pi) * cosine / d2 * x * x * (3 - 2 * x),
        ),
        "square": (lamp("AREA", above), p, UP, polygon(square, S / math.pi, p, UP)),
        "square nearly touched": (
            lamp("AREA", above),
            (0.3, 0.1, 1.999),
            UP,
            polygon(square, S / math.pi, (0.3, 0.1, 1.999), UP),
        ),
        "square not normalised": (lamp("AREA", above, normalize=False), p, UP, polygon(square, S / math.pi, p, UP)),
        "behind": (lamp("AREA", above), (0.0, 0.0, 3.0), (0.0, 0.0, -1.0), np.zeros(3)),
        "disk": (lamp("AREA", above, shape="DISK", size=(1.0, 5.0)), (0.0, 0.0, 0.0), UP, S / math.pi / (4.0 + 0.25)),
        "disk not normalised": (
            lamp("AREA", above, shape="DISK", normalize=False),
            (0.0, 0.0, 0.0),
            UP,
            S * 0.25 / (4.0 + 0.25),
        ),
        "beam": (lamp("AREA", above, size=(2.0, 2.0), spread=0.0), (0.9, 0.0, 0.0), UP, S / 4.0),
        "beside a beam": (lamp("AREA", above, size=(2.0, 2.0), spread=0.0), (1.1, 0.0, 0.0), UP, np.zeros(3)),
        "sun": (lamp("SUN", frame((0.0, 3.0, 4.0))), p, UP, S * 0.8),
        "sun disk": (lamp("SUN", frame((0.0, 3.0, 4.0)), angle=0.5), p, UP, S * 0.8),
        "sun not normalised": (
            lamp("SUN", frame((0.0, 3.0, 4.0)), angle=0.5, normalize=False),
            p,
            UP,
            S * 0.8 * math.pi * math.sin(0.25) ** 2,
        ),
        "world": (table(world=WORLD), p, UP, math.pi * np.array(WORLD.color)),
        "mesh": (
            table(emitters=EMITTERS),
            (0.0, 0.0, -1.0),
            UP,
            sum(
                polygon(
                    np.stack([EMITTERS.v0[m], EMITTERS.v1[m], EMITTERS.v2[m]]), EMITTERS.radiance[m], (0, 0, -1), UP
                )
                for m in range(2)
            ),
        ),
    }


CASES = cases()


@pytest.mark.parametrize("name", CASES)
def test_irradiance_is_the_analytic_one(name):
    light, p, ns, exact = CASES[name]
    lights = light if hasattr(light, "kind") and not isinstance(light.kind, str) else table([light])
    found = estimate(lights, p, ns)
    assert_same(found, (exact, 0.0), floor=1e-9 * np.max(exact))
    assert np.all(found[1] <= 0.01 * np.maximum(exact, 1e-12)), "too noisy to tell"  # 40 000 samples


@pytest.mark.parametrize("name", ["spread square", "spread ellipse", "wide spread"])
def test_spread_agrees_with_a_sum_over_the_lamp(name):
    """Midpoint rule over the lamp with the law of the soft box written out."""
    item, lights = LAMPS[name], SINGLE[name]()
    n = 1200
    a, b = np.meshgrid((np.arange(n) + 0.5) / n - 0.5, (np.arange(n) + 0.5) / n - 0.5)
    v = item.size[1] if item.shape == "ELLIPSE" else item.size[0]
    x = item.matrix[:3, 3] + a[..., None] * item.size[0] * item.matrix[:3, 0] + b[..., None] * v * item.matrix[:3, 1]
    inside = (a * a + b * b <= 0.25) if item.shape == "ELLIPSE" else np.ones_like(a, bool)
    area = item.size[0] * v * (math.pi / 4 if item.shape == "ELLIPSE" else 1.0)
    d2 = (x**2).sum(-1)
    cos_light = (x @ item.matrix[:3, 2]) / np.sqrt(d2)
    half = item.spread / 2
    gain = np.maximum(math.tan(half) - np.tan(np.arccos(np.clip(cos_light, 1e-9, 1))), 0) / (math.tan(half) - half)
    value = np.where(inside, gain * cos_light * x[..., 2] / d2**1.5, 0.0).mean() * item.size[0] * v
    assert_same(estimate(lights), (S / (math.pi * area) * value, 0.0), floor=2e-3 * value)  # rim of the ellipse: 1 / n


@pytest.mark.parametrize("name", [name for name in SINGLE if name not in DELTAS])
def test_light_sampling_rays_and_both_agree(name):
    lights = SINGLE[name]()
    ns = np.array((0.3, -0.2, 1.0))
    ns = tuple(ns / np.linalg.norm(ns))
    by_light, by_both = estimate(lights, ns=ns), estimate(lights, ns=ns, how=BOTH)
    assert np.all(by_light[0] > 0.0)
    # a small lamp is met by so few rays that their share, some 1e-4, may be missing altogether
    assert_same(by_light, by_both, floor=5e-4 * by_light[0].max())
    assert_same(by_light, estimate(lights, ns=ns, how=RAYS_ONLY, n=10 * N, seed=5), floor=1e-9)


def test_all_lights_together():
    """Selection at a point, one table of all lamps, meshes and world; some lamps below the horizon, some behind."""
    lamps = [item for name, item in LAMPS.items() if name not in DELTAS]
    lights = table(lamps, EMITTERS, WORLD)
    for p, ns in (((0.0, 0.0, 0.0), UP), ((0.5, -0.3, 1.9), (0.6, 0.0, -0.8)), ((-1.0, 2.0, 0.5), (0.0, -1.0, 0.0))):
        exact = sum(estimate(SINGLE[name](), p, ns)[0] for name in SINGLE if name not in DELTAS | {"sky"})
        assert_same(estimate(lights, p, ns), (exact, exact * 2e-3))  # each single lamp: 1e-3
        assert_same(estimate(lights, p, ns, BOTH), (exact, exact * 2e-3))
        assert_same(estimate(lights, p, ns, RAYS_ONLY, 5 * N), (exact, exact * 2e-3))


def test_many_lights_use_the_static_table():
    lamps = [lamp("POINT", frame((np.cos(a), np.sin(a), 1.5)), radius=0.1) for a in np.linspace(0, 6, 70)]
    lights = table(lamps, EMITTERS, WORLD)
    exact = sum(estimate(table([item]), n=2000)[0] for item in lamps)
    exact = exact + estimate(table(emitters=EMITTERS))[0] + math.pi * np.array(WORLD.color)
    for how in (LIGHTS_ONLY, BOTH):
        assert_same(estimate(lights, how=how), (exact, exact * 1e-3))


def test_light_sampling_of_a_tiny_lamp_far_away_keeps_its_digits():
    """A lamp of 1 mm at 100 m: the cone's 1 - cos is 5e-11."""
    for options in ({"radius": 1e-3}, {"radius": 1e-3, "soft_falloff": False}):
        found = estimate(table([lamp("POINT", frame((0.0, 0.0, 100.0)), **options)]), n=100)
        assert found[0] == pytest.approx(S / (4 * math.pi * 1e4), rel=1e-9)
    found = estimate(table([lamp("AREA", frame((0.0, 0.0, 100.0)), size=(1e-3, 1e-3))]), n=100)
    assert found[0] == pytest.approx(S / math.pi * 1e-4, rel=1e-6)


@pytest.mark.parametrize("name", [name for name in SINGLE if name not in DELTAS])
def test_directions_follow_the_density(name):
    """Counts of sampled directions that carry light against the density that rays are weighted with."""
    lights, p, n, bins, fine = SINGLE[name](), (0.2, 0.1, 0.1), 60_000, 10, 64
    d, drawn = np.empty((n, 3)), np.empty(n)
    sampled_directions(lights, p, UP, uniform(n, 3, 8), d, drawn)
    # an ellipse's rectangle and a spread's corners hold no light; a sky that varies is sampled below the horizon too
    lit = (drawn > 0.0) & (d[:, 2] > 0.0)
    d, drawn = d[lit], drawn[lit]
    met = np.array([direction_pdf(lights, TRIS, p, UP, tuple(x)) for x in d[:1000]])
    if name == "mesh":  # whose triangles may lie one behind the other
        assert np.all(met > 0.0)
    else:
        assert met == pytest.approx(drawn[:1000], rel=1e-6)
    # bins in (x, y), the hemisphere seen from above: solid angle = area / z
    edges = [np.linspace(d[:, k].min() - 1e-9, d[:, k].max() + 1e-9, bins + 1) for k in range(2)]
    x, y = ((np.arange(bins * fine) + 0.5) / (bins * fine) * (e[-1] - e[0]) + e[0] for e in edges)
    density = np.zeros((bins * fine, bins * fine))
    density_from_above(lights, TRIS, p, UP, x, y, density)
    cell = (edges[0][1] - edges[0][0]) * (edges[1][1] - edges[1][0]) / fine**2
    expected = n * cell * density.reshape(bins, fine, bins, fine).sum((1, 3))
    found, _, _ = np.histogram2d(d[:, 0], d[:, 1], bins=edges)
    # all of the density is there, but for what the midpoint rule loses at borders
    assert found.sum() == pytest.approx(expected.sum(), rel=0.01)
    expected = np.where((expected == 0.0) & (found > 0), found, expected) * found.sum() / expected.sum()
    assert p_value(found, expected) > least(len(SINGLE))


def test_a_lamp_without_shadows_is_left_to_light_sampling():
    lights = table([lamp("AREA", size=(1.0, 1.0), cast_shadow=False)])
    _, distance, le, _, is_delta, _ = sample_light(lights, (0.0, 0.0, 0.0), UP, 0.5, 0.5, 0.5)
    assert distance == 0.0 and is_delta and le[0] > 0.0
    toward = tuple(lights.position[0] / np.linalg.norm(lights.position[0]))
    origin = (0.0, 0.0, 0.0)
    assert lamps_along_ray(lights, origin, toward, math.inf, origin, 1.0, 1, 0)[0] == 0.0
    assert lamps_along_ray(lights, origin, toward, math.inf, origin, 1.0, 0, 0)[0] > 0.0


def test_the_camera_sees_only_visible_lamps():
    for name in ("sphere", "soft point", "square", "sun disk"):
        for visible in (True, False):
            item = replace(LAMPS[name], visible_camera=visible, matrix=frame((0.0, 0.0, 2.0)))
            lights, o = table([item]), (0.0, 0.0, 0.0)
            for camera in (0, 1):
                seen = lamps_along_ray(lights, o, UP, math.inf, o, 0.0, 0, camera)[0]
                seen += suns_along_ray(lights, UP, o, 0.0, 0, camera)[0]
                assert (seen > 0.0) == (visible or not camera)


def test_lamps_are_met_only_on_the_segment():
    """A ray cut in two by a transparent surface meets a lamp once, and soft lamps face the ray's first point."""
    for name in ("sphere", "soft point", "square"):
        lights, o = table([replace(LAMPS[name], matrix=frame((0.0, 0.0, 2.0)))]), (0.0, 0.0, 0.0)
        whole = lamps_along_ray(lights, o, UP, math.inf, o, 0.0, 0, 0)[0]
        assert whole > 0.0
        assert lamps_along_ray(lights, o, UP, 1.0, o, 0.0, 0, 0)[0] == 0.0
        assert lamps_along_ray(lights, (0.0, 0.0, 1.0), UP, math.inf, o, 0.0, 0, 0)[0] == whole
        assert lamps_along_ray(lights, (0.0, 0.0, 2.5), UP, math.inf, o, 0.0, 0, 0)[0] == 0.0
