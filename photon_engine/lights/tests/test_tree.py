"""The light tree: probabilities, bounds, and that it finds what is near among many."""

import numpy as np
import pytest
from scipy import stats

from ...jit import kernel
from ...vec import load3, luminance
from ..descend import node_weight, tree_p, tree_pick
from ..sample import lamps_along_ray, sample_light
from ..select import selection_p
from ..table import MANY, Emitters
from ..tree import build_tree, join_cones, triangle_bounds
from .scenes import EMITTERS, WORLD, frame, lamp, table

RNG = np.random.default_rng(5)
POINTS = ((0.0, 0.0, 0.0), (4.0, -3.0, 1.0), (9.5, 9.0, -8.0))
UP = (0.0, 0.0, 1.0)


def triangles(n, rng, size=0.3):
    """n triangles in a box of 20 m with powers over three decades."""
    middle = rng.uniform(-10.0, 10.0, (n, 1, 3))
    return middle + size * rng.normal(size=(n, 3, 3)), 10.0 ** rng.uniform(-2.0, 1.0, n)


def mixed_lamps(n, rng):
    """n lamps of every near kind, turned anyhow."""
    out = []
    for i in range(n):
        where = frame(rng.uniform(-10.0, 10.0, 3), rng.uniform(-10.0, 10.0, 3), rng.uniform(0.5, 2.0, 3))
        strength = tuple(10.0 ** rng.uniform(-1.0, 2.0, 3))
        kinds = (
            ("POINT", {}), ("POINT", {"radius": 0.4}), ("SPOT", {"spot_size": 0.9, "spot_blend": 0.3, "radius": 0.1}),
            ("SPOT", {"spot_size": 0.5}), ("AREA", {"shape": "DISK"}), ("AREA", {"spread": 0.8}),
            ("AREA", {"spread": 0.0}), ("POINT", {"radius": 0.3, "soft_falloff": False}),
        )  # fmt: skip
        kind, options = kinds[i % len(kinds)]
        out.append(lamp(kind, where, strength=strength, **options))
    return out


@pytest.mark.parametrize("n", [1, 2, 3, 7, 64, 100])
def test_probabilities_are_the_frequencies(n):
    """Chi-square: tree_pick draws each emitter as tree_p says, and all together with probability 1."""
    corners, power = triangles(n, RNG)
    outward = RNG.choice([-1.0, 0.0, 1.0], n)
    tree = build_tree(triangle_bounds(corners, power, outward))
    assert sorted(tree.item[tree.item >= 0]) == list(range(n))
    for p in POINTS:
        q = np.array([tree_p(tree, i, p) for i in range(n)])
        assert q.sum() == pytest.approx(1.0, rel=1e-12)
        draws = 4000
        found = np.zeros(n)
        for u in (np.arange(draws) + RNG.uniform(size=draws)) / draws:
            i, probability, fresh = tree_pick(tree, p, u)
            found[i] += 1.0
            assert probability == pytest.approx(q[i], rel=1e-9) and 0.0 <= fresh < 1.0
        some = q * draws >= 5.0
        expected = np.append(q[some], q[~some].sum()) * draws
        observed = np.append(found[some], found[~some].sum())
        used = expected > 0.0
        assert observed[~used].sum() == 0.0
        # stratified numbers scatter less than chi-square allows: a wrong share still shows
        statistic = ((observed[used] - expected[used]) ** 2 / expected[used]).sum()
        assert stats.chi2.sf(statistic, max(used.sum() - 1, 1)) > 1e-4


def test_nodes_bound_their_emitters():
    """No emitter sends more to a point than any node above it says; so none is lost where a node says 0."""
    corners, power = triangles(40, RNG)
    tree = build_tree(triangle_bounds(corners, power, np.zeros(40)))
    for p in RNG.uniform(-12.0, 12.0, (200, 3)):
        for i, (triangle, strength) in enumerate(zip(corners, power, strict=True)):
            n = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
            for x in triangle:  # corners are the worst points
                r = x - p
                sent = strength * abs(r @ n) / (np.linalg.norm(n) * (r @ r) ** 1.5)
                k = tree.leaf[i]
                while k >= 0:
                    weight = node_weight(tree, k, tuple(p))
                    near = np.linalg.norm(p - tree.center[k]) < 3.0 * tree.radius[k]  # d^2 is taken to the middle
                    assert near or weight * (1.0 + 1.0) >= sent
                    assert weight > 0.0 or sent < 1e-12
                    k = (k - 1) // 2 if k > 0 else -1


def test_cones_hold_both():
    axes = RNG.normal(size=(2, 500, 3))
    axes /= np.linalg.norm(axes, axis=2, keepdims=True)
    spreads = RNG.uniform(0.0, 2.0, (2, 500))
    axis, spread = join_cones(axes[0], spreads[0], axes[1], spreads[1])
    for a, s in zip(axes, spreads, strict=True):
        apart = np.arccos(np.clip((axis * a).sum(1), -1.0, 1.0))
        assert np.all(np.minimum(apart + s, np.pi) <= spread + 1e-6)
    assert np.all(spread <= np.minimum(spreads.sum(0) + np.pi, np.pi) + 1e-9)
    same, still = join_cones(axes[0], np.zeros(500), axes[0], np.zeros(500))
    assert same == pytest.approx(axes[0]) and np.all(still < 1e-6)
    _, all_round = join_cones(axes[0], np.zeros(500), -axes[0], np.zeros(500))
    assert np.all(all_round >= np.pi / 2 - 1e-9)


@kernel
def estimates(lights, p, numbers, out):
    """Direct light at p, facing whatever it comes from: f = 1, no cosine -> out (n,)."""
    for i in range(numbers.shape[0]):
        _, _, le, pdf_w, _, _ = sample_light(lights, p, UP, numbers[i, 0], numbers[i, 1], numbers[i, 2])
        out[i] = luminance(le) / pdf_w


def test_many_lamps_together_bring_the_sum_of_each():
    """With a tree over 80 lamps, a mesh and the world: the mean is the sum over tables of one light."""
    lamps = mixed_lamps(80, np.random.default_rng(7))
    together = table(lamps, EMITTERS, WORLD)
    assert together.lamp_tree.item.size and together.n_near == 80
    p = (1.0, -2.0, 0.5)
    assert sum(selection_p(together, l, p) for l in range(len(together.kind))) == pytest.approx(1.0)
    numbers = np.random.default_rng(8).uniform(size=(200_000, 3))
    out = np.zeros(len(numbers))
    estimates(together, p, numbers, out)
    expected = 0.0
    for single in (*(table([item]) for item in lamps), table(emitters=EMITTERS), table(world=WORLD)):
        part = np.zeros(4000)
        estimates(single, p, numbers[:4000], part)
        expected += part.mean()
    noise = out.std() / np.sqrt(len(out))
    assert noise < 0.01 * expected
    # the lamps one by one are known to 0.3%
    assert out.mean() == pytest.approx(expected, abs=4.5 * noise + 0.01 * expected)


def test_one_near_lamp_among_a_thousand_is_found():
    """Noise of direct light beside one lamp of a thousand, most of what arrives: it is no needle in a haystack."""
    rng = np.random.default_rng(9)
    far = [lamp("POINT", frame((*(100.0 * rng.normal(size=2)), 30.0)), radius=0.1) for _ in range(999)]
    lights = table([*far, lamp("POINT", frame((0.0, 0.0, 1.0)), radius=0.1)])
    out = np.zeros(20_000)
    estimates(lights, (0.3, 0.0, 0.0), rng.uniform(size=(20_000, 3)), out)
    # measured 3.1; by power alone it would be 27 = 0.85 sqrt(1000)
    assert out.std() / out.mean() < 4.0
    assert selection_p(lights, 999, (0.3, 0.0, 0.0)) > 50.0 / 1000.0


@kernel
def met_by(lights, o, d, out):
    """Luminance of what rays from o along d (n, 3) meet -> out (n,)."""
    for i in range(d.shape[0]):
        p, w = load3(o, i), load3(d, i)
        out[i] = luminance(lamps_along_ray(lights, p, w, 30.0, p, 0.0, 0, 0))


def test_rays_meet_the_same_lamps_with_a_tree():
    lamps = mixed_lamps(3 * MANY, np.random.default_rng(3))
    rng = np.random.default_rng(4)
    o, d = rng.uniform(-10.0, 10.0, (3000, 3)), rng.normal(size=(3000, 3))
    aim = np.array([lamps[i % len(lamps)].matrix[:3, 3] for i in range(2000)])
    d[:2000] = aim + rng.normal(size=(2000, 3)) * 0.2 - o[:2000]
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    with_tree, alone = np.zeros(3000), np.zeros(3000)
    met_by(table(lamps), o, d, with_tree)
    for i in range(0, len(lamps), MANY):
        part = np.zeros(3000)
        met_by(table(lamps[i : i + MANY]), o, d, part)
        alone += part
    assert (alone > 0.0).sum() > 300
    assert with_tree == pytest.approx(alone, rel=1e-9, abs=1e-12)


def test_a_closed_surface_is_sampled_where_it_faces():
    """A ball of 1280 triangles seen from three radii: the third of it that can be seen gets most samples."""
    from scipy.spatial import ConvexHull

    k = np.arange(642) + 0.5
    z, turn = 1.0 - k / 321.0, np.pi * (1.0 + 5.0**0.5) * k
    points = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], 1)
    corners = points[ConvexHull(points).simplices]
    turned = (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * corners[:, 0]).sum(1) < 0.0
    corners[turned] = corners[turned][:, [0, 2, 1]]
    v0, v1, v2 = (corners[:, i].astype(np.float32) for i in range(3))
    n = len(corners)
    ids = np.arange(8, dtype=np.int32)[np.zeros(n, int)]
    emitters = Emitters(ids, v0, v1, v2, np.ones((n, 3), np.float32), None, np.ones(n, np.float32))
    lights = table(emitters=emitters)
    p = (0.0, 0.0, 3.0)
    seen = corners.mean(1)[:, 2] > 1.0 / 3.0
    q = np.array([tree_p(lights.tri_tree, i, p) for i in range(n)])
    assert q[seen].sum() > 0.55  # measured 0.61; by area it would be 0.33


def test_a_tree_of_a_hundred_thousand_is_built_at_once():
    """Depth 17, every emitter once; half a second on an idle core, against minutes one node at a time."""
    corners, power = triangles(100_000, RNG, 0.01)
    tree = build_tree(triangle_bounds(corners, power, np.zeros(len(power))))
    assert len(tree.item) == 2**18 - 1
    assert np.bincount(tree.item[tree.item >= 0], minlength=len(power)).max() == 1
    assert tree.power[0] == pytest.approx(power.sum())
