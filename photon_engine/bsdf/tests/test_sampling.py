"""Sampling of every material: its density, its weights, its energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from .. import recipes
from ..batch import eval_batch, prepare_batch, sample_batch
from ..layout import CLASS_ROUGH, CLASS_SHARP, pack
from .registry import ROUGH, SHARP, WHITE, direction, frames, rows_of, zeros

VIEWS = [0.95, 0.35, -0.7]
CASES = [(name, mu) for name in ROUGH for mu in VIEWS]
TILTED = np.array([0.15, 0.1, math.sqrt(1.0 - 0.0325)])  # a shading normal 10 degrees off the geometric one


def draw(lobes, mu, n, seed=1, **options):
    """Samples of one material seen from one direction."""
    u = np.random.default_rng(seed).random((n, 3))
    normal = options.pop("ns", (0.0, 0.0, 1.0))
    return sample_batch(rows_of(lobes), zeros(n), frames(n, direction(mu), normal), u, **options)


def density_on_grid(lobes, mu, n_z, n_phi, fine):
    """Integral of pdf_w over each cell of a grid of (z, phi), by fine x fine midpoints in a cell."""
    z = -1.0 + 2.0 * (np.arange(n_z * fine) + 0.5) / (n_z * fine)
    phi = 2.0 * math.pi * (np.arange(n_phi * fine) + 0.5) / (n_phi * fine)
    z, phi = (a.ravel() for a in np.meshgrid(z, phi, indexing="ij"))
    s = np.sqrt(1.0 - z * z)
    wi = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
    _, pdf = eval_batch(rows_of(lobes), zeros(len(z)), frames(len(z), direction(mu)), wi)
    cells = pdf.reshape(n_z, fine, n_phi, fine).sum(axis=(1, 3))
    return cells * 4.0 * math.pi / (n_z * n_phi * fine * fine)


@pytest.mark.parametrize(("name", "mu"), CASES)
def test_samples_follow_the_density(name, mu):
    """Chi-squared over cells of the sphere, 1% in all cases together (Sidak); the density integrates to at most 1."""
    lobes, n = ROUGH[name](), 50_000
    p = density_on_grid(lobes, mu, 16, 16, 48)
    if "bumped" in name:  # `sample` refuses directions into the surface, f does not know of it (as in Blender)
        p[slice(0, 8) if mu > 0.0 else slice(8, 16)] = 0.0
    # the midpoint rule is off by up to 4e-4 for the narrowest lobe (roughness 0.2), by 1.6e-3 at a toon's edge
    assert p.sum() < (1.002 if name == "toon" else 1.001)
    ok, wi, *_ = draw(lobes, mu, n, cls=CLASS_ROUGH)
    if not p.any():
        assert not ok.any()
        return
    phi = np.arctan2(wi[ok, 1], wi[ok, 0]) % (2.0 * math.pi)
    found, *_ = np.histogram2d(wi[ok, 2], phi, bins=(16, 16), range=((-1.0, 1.0), (0.0, 2.0 * math.pi)))
    expected = p.ravel() * n
    found = found.ravel()
    rare = expected < 8.0
    expected = np.append(expected[~rare], [expected[rare].sum(), max(n - expected.sum(), 0.0)])
    found = np.append(found[~rare], [found[rare].sum(), n - found.sum()])
    used = expected > 4.0
    assert found[~used].sum() < 30
    chi2 = ((found - expected)[used] ** 2 / expected[used]).sum()
    alpha = 1.0 - (1.0 - 0.01) ** (1.0 / len(CASES))
    assert stats.chi2.sf(chi2, used.sum() - 1) > alpha


@pytest.mark.parametrize(("name", "mu"), CASES)
def test_weight_is_f_cos_over_pdf(name, mu):
    """The weight over eta^2 (radiance) is f cos / pdf of `eval_rough`."""
    lobes, n = ROUGH[name](), 500
    ok, wi, weight, pdf, eta = draw(lobes, mu, n, cls=CLASS_ROUGH)
    f, pdf_eval = eval_batch(rows_of(lobes), zeros(n), frames(n, direction(mu)), wi)
    np.testing.assert_allclose(pdf[ok], pdf_eval[ok], rtol=1e-6)
    expected = f * np.abs(wi[:, 2:3]) * (eta**2 / np.maximum(pdf, 1e-300))[:, None]
    # f is divided by cos^2 at grazing, where rounding of h shows: 1e-6 of the value
    np.testing.assert_allclose(weight[ok], expected[ok], rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize(("name", "mu"), CASES)
@pytest.mark.parametrize("tilted", [False, True])
def test_photons_carry_the_adjoint(name, mu, tilted):
    """A photon's weight is f seen from where it goes, |ns.wo| |ng.wi| / |ng.wo| / pdf [Veach 1997, section 5.3]."""
    lobes, n = ROUGH[name](), 500
    ns = TILTED if tilted else np.array([0.0, 0.0, 1.0])
    wo = direction(mu)
    ok, wi, weight, pdf, _ = draw(lobes, mu, n, cls=CLASS_ROUGH, adjoint=1, ns=ns)
    ok &= (wi @ ns) * wi[:, 2] > 0.0  # seen from behind the shading normal, facets and eye paths show nothing
    rows = rows_of(lobes)
    f, _ = eval_batch(rows, zeros(n), (np.tile(ns, (n, 1)), np.tile([0.0, 0.0, 1.0], (n, 1)), wi), np.tile(wo, (n, 1)))
    expected = f * (abs(wo @ ns) * np.abs(wi[:, 2]) / abs(wo[2]) / np.maximum(pdf, 1e-300))[:, None]
    raised = np.zeros(n, bool)
    if tilted:  # the normal is raised for one of the two directions only: not reciprocal, as in Blender
        for w in (wi, np.tile(wo, (n, 1))):
            side = np.sign(w[:, 2:3])
            mirrored = 2.0 * np.sum(w * ns, axis=1, keepdims=True) * ns - w
            raised |= (mirrored * side)[:, 2] < np.minimum(0.9 * np.abs(w[:, 2]), 0.01)
    keep = ok & ~raised
    assert keep.any() or not ok.any()
    np.testing.assert_allclose(weight[keep], expected[keep], rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("degrees", [40.0, 75.0])
def test_bumped_mirrors_throw_what_is_seen_in_them(degrees):
    """Light off bumps of 35 degrees: photons carry away what eye paths of all directions find, and no photon blazes.

    Noise of the means: 0.6% for eye paths, 0.3% for photons (150 000 each). Photons with normals raised for where
    they come from, not for where they go, carried 18% too little at 75 degrees.
    """
    rng, n = np.random.default_rng(5), 150_000
    turn, t = 2.0 * math.pi * rng.random(n), math.radians(35.0)
    normal = np.stack([math.sin(t) * np.cos(turn), math.sin(t) * np.sin(turn), np.full(n, math.cos(t))], axis=1)
    lobes = recipes.glossy(1.0, 0.35, normal, distribution="GGX")
    rows, index, up = pack(lobes, n, len(lobes) + 1), np.arange(n), np.tile([0.0, 0.0, 1.0], (n, 1))
    light = np.tile(direction(math.cos(math.radians(degrees))), (n, 1))
    ok, _, weight, _, _ = sample_batch(rows, index, (up, up, light), rng.random((n, 3)), adjoint=1)
    z, phi = np.sqrt(rng.random(n)), 2.0 * math.pi * rng.random(n)
    s = np.sqrt(1.0 - z * z)
    seen, _ = eval_batch(rows, index, (up, up, np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)), light)
    assert weight[ok, 0].sum() / n == pytest.approx(math.pi * seen[:, 0].mean(), rel=0.025)
    assert weight[ok].max() < 60.0


@pytest.mark.parametrize("name", [n for n in ROUGH if n in ("lambert", "oren_nayar", "glossy", "glass", "refraction")])
def test_reciprocity(name):
    """F(wo, wi) n_wo^-2 = f(wi, wo) n_wi^-2 for single scattering."""
    rng = np.random.default_rng(3)
    wo, wi = rng.normal(size=(2, 400, 3))
    wo, wi = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wo, wi))
    index = {"glass": 1.5, "refraction": float(np.float32(1.33))}.get(name, 1.0)
    rows, up = rows_of(ROUGH[name]()), np.tile([0.0, 0.0, 1.0], (400, 1))
    there, _ = eval_batch(rows, zeros(400), (up, up, wo), wi)
    back, _ = eval_batch(rows, zeros(400), (up, up, wi), wo)
    n_o = np.where(wo[:, 2] > 0.0, 1.0, index)[:, None]
    n_i = np.where(wi[:, 2] > 0.0, 1.0, index)[:, None]
    assert np.count_nonzero(there) > 50
    np.testing.assert_allclose(there / n_o**2, back / n_i**2, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("mu", [0.9, 0.5, 0.25])
@pytest.mark.parametrize("name", WHITE)
def test_white_furnace(name, mu):
    """What absorbs nothing sends back all: within noise (0.3%) and the tables' linear steps (0.7%)."""
    *_, weight, _, _ = draw(WHITE[name](), mu, 40_000)
    assert weight.mean() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("name", [*ROUGH, *SHARP])
@pytest.mark.parametrize("mu", [0.9, 0.3])
def test_no_energy_is_made(name, mu):
    """No material of the registry gives back more than it gets."""
    lobes = {**ROUGH, **SHARP}[name]()
    *_, weight, _, _ = draw(lobes, mu, 20_000)
    assert np.isfinite(weight).all()
    assert weight.mean(axis=0).max() < 1.01


@pytest.mark.parametrize("name", SHARP)
def test_sharp_lobes_have_no_f(name):
    """Sharp lobes are sampled, never evaluated; a delta's density is 0."""
    lobes = [lobe for lobe in SHARP[name]() if lobe.kind not in (1, 2)]
    rows = rows_of(lobes)
    p, _ = prepare_batch(rows, zeros(1), frames(1, direction(0.6)))
    assert p[0, 2] == 0.0 and p[0, 1] > 0.0
    ok, wi, weight, pdf, _ = draw(lobes, 0.6, 200, cls=CLASS_SHARP)
    assert ok.all() and (weight > 0.0).any() and ("near" in name) == bool(pdf.all())
    f, density = eval_batch(rows, zeros(200), frames(200, direction(0.6)), wi)
    assert not f.any() and not density.any()


@pytest.mark.parametrize("adjoint", [0, 1])
def test_classes_are_apart(adjoint):
    """Means of the classes' weights, times their share, add up to the mean over all."""
    lobes = recipes.principled(base_color=0.7, coat_weight=0.6, alpha=0.7, roughness=0.6, coat_roughness=0.0)
    n = 100_000
    total = draw(lobes, 0.5, n, adjoint=adjoint)[2].mean()
    parts = sum(draw(lobes, 0.5, n, seed=5, cls=c, adjoint=adjoint)[2].mean() for c in (0, 1, 2))
    assert parts == pytest.approx(total, rel=0.01)  # measured noise 0.003
