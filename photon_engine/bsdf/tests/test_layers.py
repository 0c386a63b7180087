"""Rows, recipes and layers: what the shader nodes ask for is what the kernels see."""

from __future__ import annotations

import math

import numpy as np
import pytest

from .. import layout, recipes
from ..batch import eval_batch, prepare_batch, sample_batch
from ..layout import CLASS_SHARP, pack
from .registry import TINT, direction, frames, rows_of, zeros


def mean_weight(lobes, mu, n=60_000, **options):
    """Directional albedo over all classes."""
    u = np.random.default_rng(1).random((n, 3))
    return sample_batch(rows_of(lobes), zeros(n), frames(n, direction(mu)), u, **options)[2].mean(axis=0)


def one_sample(lobes, wo, u=(0.5, 0.5, 0.5), **options):
    """(ok, wi, weight, pdf, eta) of a single sample."""
    out = sample_batch(rows_of(lobes), zeros(1), frames(1, wo), np.array([u]), **options)
    return tuple(a[0] for a in out)


@pytest.mark.parametrize(("mu", "eta"), [(0.6, 1.5), (-0.8, 1.5), (0.8, 0.75)])
def test_smooth_glass_bends_by_snell(mu, eta):
    """Refraction keeps n sin; eta is the index beyond over the index here, on either side."""
    wo = direction(mu)
    ok, wi, weight, pdf, crossed = one_sample(recipes.glass(1.0, 0.0, eta), wo, (0.9999, 0.5, 0.5))
    assert ok and wi[2] * wo[2] < 0.0 and pdf == 0.0
    assert crossed == pytest.approx(eta if mu > 0.0 else 1.0 / eta, rel=1e-6)
    np.testing.assert_allclose(wi[:2] * crossed, -wo[:2], atol=1e-12)
    np.testing.assert_allclose(weight, 1.0)


def test_total_internal_reflection():
    """Beyond the critical angle glass reflects everything; a refraction lobe has nothing to do."""
    wo = direction(-0.3)
    ok, wi, weight, _, eta = one_sample(recipes.glass(TINT, 0.0, 1.5), wo, (0.9999, 0.5, 0.5))
    assert ok and eta == 1.0
    np.testing.assert_allclose(wi, [-wo[0], -wo[1], wo[2]], atol=1e-12)
    np.testing.assert_allclose(weight, TINT, rtol=1e-6)
    assert not one_sample(recipes.refraction(TINT, 0.0, 1.5), wo)[0]


@pytest.mark.parametrize("recipe", [recipes.glossy, lambda c, r: recipes.glass(c, r, 1.5), recipes.principled])
def test_mirror_limit_is_continuous(recipe):
    """Roughness just above the delta limit gives the colour and the direction of just below."""
    make = recipe if recipe is not recipes.principled else (lambda c, r: recipes.principled(base_color=c, roughness=r))
    below, above = (mean_weight(make(TINT, r), 0.5) for r in (0.0099, 0.0101))
    np.testing.assert_allclose(below, above, rtol=0.01)  # noise 0.003
    wo = direction(0.5)
    rng = np.random.default_rng(3).random((2000, 3))
    args = (zeros(2000), frames(2000, wo), rng)
    a = sample_batch(rows_of(make(TINT, 0.0099)), *args, cls=CLASS_SHARP)
    b = sample_batch(rows_of(make(TINT, 0.0101)), *args, cls=CLASS_SHARP)
    same = a[0] & b[0] & (a[4] == b[4])
    assert same.mean() > 0.99
    # facets of alpha 1e-4 lean by a few 1e-4; 99 of 100 by less than 1e-3, reflection doubles it
    assert np.quantile(np.linalg.norm(a[1] - b[1], axis=1)[same], 0.95) < 2e-3


def test_threshold_decides_the_class():
    """Below the threshold a lobe is sharp; a mirror is sharp even with the threshold 0."""
    for rough, threshold, sharp in [(0.04, 0.05, True), (0.06, 0.05, False), (0.06, 0.1, True), (0.0, 0.0, True)]:
        p, _ = prepare_batch(
            rows_of(recipes.glossy(1.0, rough)), zeros(1), frames(1, direction(0.5)), threshold=threshold
        )
        assert (p[0, 1] > 0.0) == sharp and (p[0, 2] > 0.0) != sharp


def test_emission_is_under_the_coat():
    """A coat takes from the emission below what it reflects, and its tint colours it; both sides shine."""
    bare = recipes.principled(base_color=0.0, emission_color=TINT, emission_strength=3.0)
    coated = recipes.principled(
        base_color=0.0, emission_color=TINT, emission_strength=3.0, coat_weight=1.0, coat_tint=[1.0, 0.5, 1.0]
    )
    le, le_coat = (prepare_batch(rows_of(m), zeros(1), frames(1, direction(1.0)))[1][0] for m in (bare, coated))
    np.testing.assert_allclose(le, np.array(TINT) * 3.0, rtol=1e-6)
    # at normal incidence the coat of index 1.5 reflects 4%, and the tint is the one given
    np.testing.assert_allclose(le_coat, le * 0.96 * [1.0, 0.5, 1.0], rtol=2e-3)
    back = prepare_batch(rows_of(bare), zeros(1), frames(1, direction(-0.5)))[1][0]
    np.testing.assert_allclose(back, le)


def test_alpha_mixes_with_transparent():
    """Alpha a: a share 1 - a goes straight on, in class null."""
    lobes = recipes.principled(base_color=0.5, alpha=0.25)
    ok, wi, weight, _, _ = one_sample(lobes, direction(0.4), cls=0)
    assert ok
    np.testing.assert_allclose(wi, -direction(0.4))
    np.testing.assert_allclose(weight, 0.75)
    opaque = mean_weight(recipes.principled(base_color=0.5), 0.4)
    np.testing.assert_allclose(mean_weight(lobes, 0.4), 0.75 + 0.25 * opaque, rtol=0.01)  # noise 0.003


def test_mixed_materials_keep_their_layers_apart():
    """Half of each of two coated materials is the mean of both, though both have layers."""
    a = recipes.principled(base_color=0.9, coat_weight=1.0)
    b = recipes.principled(base_color=0.2, specular_ior_level=1.0)
    both = recipes.scale_lobes(a, 0.5) + recipes.scale_lobes(b, 0.5)
    same = recipes.scale_lobes(a, 0.5) + recipes.scale_lobes(a, 0.5)
    mean = 0.5 * (mean_weight(a, 0.3) + mean_weight(b, 0.3))
    np.testing.assert_allclose(mean_weight(both, 0.3), mean, rtol=0.01)  # noise 0.003
    np.testing.assert_allclose(mean_weight(same, 0.3), mean_weight(a, 0.3), rtol=0.01)


def test_arrays_and_constants_pack_alike():
    """One row for each hit equals the hit's own constant material."""
    rng = np.random.default_rng(5)
    base, rough, metal = rng.random((4, 3)), rng.random(4) * 0.5 + 0.3, np.array([0.0, 1.0, 0.3, 0.0])
    coat = np.array([0.0, 0.5, 1.0, 0.0])
    lobes = recipes.principled(base_color=base, roughness=rough, metallic=metal, coat_weight=coat, coat_roughness=0.3)
    rows = pack(lobes, 4, len(lobes))
    wo, wi = direction(0.7), direction(0.5, 2.0)
    f, pdf = eval_batch(rows, np.arange(4), frames(4, wo), np.tile(wi, (4, 1)))
    for i in range(4):
        own = recipes.principled(
            base_color=base[i], roughness=rough[i], metallic=metal[i], coat_weight=coat[i], coat_roughness=0.3
        )
        f_own, pdf_own = eval_batch(rows_of(own), zeros(1), frames(1, wo), wi[None])
        np.testing.assert_allclose(f[i], f_own[0], rtol=1e-5)
        np.testing.assert_allclose(pdf[i], pdf_own[0], rtol=1e-5)


def test_what_weighs_nothing_is_left_out():
    """Black materials have no lobes; absent parts of Principled take no slot."""
    assert recipes.diffuse(0.0) == [] and recipes.glossy([0.0, 0.0, 0.0], 0.2) == []
    assert recipes.scale_lobes(recipes.diffuse(0.5), np.zeros(3)) == []
    kinds = [lobe.kind for lobe in recipes.principled(metallic=1.0)]
    assert kinds == [layout.REFLECT]
    assert [lobe.kind for lobe in recipes.principled()] == [layout.REFLECT, layout.DIFFUSE]


def test_wrong_side_fails():
    """A direction that leaves the shading hemisphere but enters the surface is refused, not returned."""
    ns = (math.sin(1.2), 0.0, math.cos(1.2))
    n = 2000
    u = np.random.default_rng(6).random((n, 3))
    ok, wi, weight, *_ = sample_batch(
        rows_of(recipes.diffuse(1.0)), zeros(n), frames(n, direction(0.5), ns), u
    )
    assert (wi[ok, 2] > 0.0).all() and not weight[~ok].any()
    assert 0.2 < ok.mean() < 0.9


def test_smooth_surfaces_reflect_at_grazing():
    """A shading normal that would mirror the ray into the surface is raised: the sample stays above."""
    ns = np.array([0.3, 0.0, math.sqrt(0.91)])
    wo = np.array([-0.995, 0.0, math.sqrt(1.0 - 0.995**2)])
    hit = frames(1, wo, ns * [-1.0, 1.0, 1.0])
    out = sample_batch(rows_of(recipes.glossy(1.0, 0.0)), zeros(1), hit, np.full((1, 3), 0.5))
    assert out[0][0] and out[1][0, 2] > 0.0


@pytest.mark.parametrize("adjoint", [0, 1])
@pytest.mark.parametrize("mu", [0.6, -0.6, -0.9])
@pytest.mark.parametrize(
    "make",
    [lambda w: recipes.diffuse(w), lambda w: recipes.glass(w, 0.0, 1.5), lambda w: recipes.glossy(w, 0.0)],
)
def test_short_cuts_change_nothing(make, mu, adjoint):
    """A lone Lambert, clear glass or mirror lobe takes another way through the code than two halves of it."""
    n = 500
    u = np.random.default_rng(8).random((n, 3))
    tint = np.array(TINT)
    halves = recipes.scale_lobes(make(tint), 0.5) * 2
    ns = np.array([0.2, -0.1, math.sqrt(0.95)])
    hits = frames(n, direction(mu), ns)
    alone = sample_batch(rows_of(make(tint)), zeros(n), hits, u, adjoint=adjoint)
    pair = sample_batch(rows_of(halves), zeros(n), hits, u * [0.5, 1.0, 1.0], adjoint=adjoint)
    assert alone[0].mean() > 0.5
    for a, b in zip(alone, pair, strict=True):
        np.testing.assert_allclose(a[alone[0]], b[alone[0]], rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(alone[0], pair[0])
    wi = np.tile(direction(0.5, 2.0), (n, 1))
    first, second = (eval_batch(rows_of(lobes), zeros(n), hits, wi) for lobes in (make(tint), halves))
    for a, b in zip(first, second, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-6, atol=1e-12)
