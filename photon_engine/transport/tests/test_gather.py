"""The density estimate against sums over all photons, and on a plane of known irradiance."""

import numpy as np
import pytest

from ...bsdf import recipes
from ...bsdf.layout import pack
from ...jit import kernel
from ...photons.batch import Deposits
from ...photons.map import build_map
from ...photons.packing import body, pack_direction, pack_facet
from ..clipping import no_clearings
from ..gather_kernels import estimate, flux_on_plane
from ..near_kernels import empty_near

ALBEDO = (0.7, 0.5, 0.2)
UP = (0.0, 0.0, 1.0)
OBJECT = 5
WHOLE = no_clearings().work  # no line cuts the disc
NEAR = empty_near()


@kernel
def radiance(rows, p, n, wo, scratch, photons, r, out):
    """estimate() at a Lambert point; scratch as prepare() leaves it."""
    value, smear = estimate(rows, 0, (p, n, n, wo), OBJECT, scratch, photons, r, (WHOLE, 0, 1.0, 1.0))
    for c in range(3):
        out[c], out[3 + c] = value[c], smear[c]


@kernel
def irradiance(p, n, photons, r, near, out):
    """flux_on_plane(), of a mesh whose front looks up."""
    value, smear = flux_on_plane(p, n, body(n[2] > 0.0, OBJECT), photons, r, (WHOLE, 0, 1.0, 1.0), near)
    for c in range(3):
        out[c], out[3 + c] = value[c], smear[c]


def photons_on_plane(n, seed=1, tilt=None):
    """n photons on [-1, 1]^2 at z = 0, every fifth from below and on a facet that looks down."""
    rng = np.random.default_rng(seed)
    position = np.concatenate([rng.uniform(-1, 1, (n, 2)), np.zeros((n, 1))], axis=1).astype(np.float32)
    below = np.arange(n) % 5 == 0
    wi = rng.normal(size=(n, 3))
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    wi[:, 2] = np.where(below, -1, 1) * np.abs(wi[:, 2])
    packed = np.array([pack_direction(tuple(w)) for w in wi], np.uint32)
    down, up = pack_facet((0.0, 0.0, -1.0), False, OBJECT), pack_facet(UP, True, OBJECT)
    normal = np.where(below, down, up).astype(np.uint32)
    flux = rng.random((n, 3)).astype(np.float32)
    return Deposits(position, flux, packed, normal, np.zeros(n, np.uint8)), below


def naive_irradiance(deposits, use, p, r):
    """sum of K(d / r) phi / (pi r^2) over the photons in use, and of K - K_4: six values."""
    x2 = ((deposits.position.astype(float) - p) ** 2).sum(axis=1) / r**2
    weight = np.where(use & (x2 < 1.0), 2.0 * (1.0 - x2), 0.0)
    both = np.stack([weight, weight * (6.0 * x2 - 2.0)])
    return (both @ deposits.flux / (np.pi * r * r)).ravel()


@pytest.mark.parametrize("n", [1, 3, 40, 5000])
@pytest.mark.parametrize("cells", [0.4, 1.0, 7.0, 60.0])
def test_both_estimates_equal_the_sum_over_all_photons(n, cells):
    """For tables so small that rows share buckets and radii of many cells: every photon counts once."""
    deposits, below = photons_on_plane(n)
    cell = 0.05
    photons = build_map(deposits, cell)
    rows = pack(recipes.diffuse(np.array([ALBEDO], np.float32), np.zeros(1, np.float32), None), 1, 1)
    scratch = np.zeros((1, 8))
    scratch[0, :3], scratch[0, 3], scratch[0, 4] = ALBEDO, 0.5, 2.0
    out = np.zeros(6)
    for p in ((0.0, 0.0, 0.0), (0.313, -0.77, 0.0), (-0.95, 0.95, 0.0)):
        for sign in (1.0, -1.0):
            expected = naive_irradiance(deposits, ~below if sign > 0 else below, p, cells * cell)
            irradiance(p, (0.0, 0.0, sign), photons, cells * cell, NEAR, out)
            assert np.allclose(out, expected, rtol=1e-6, atol=1e-12)
            radiance(rows, p, (0.0, 0.0, 1.0), (0.0, 0.6, 0.8 * sign), scratch, photons, cells * cell, out)
            assert np.allclose(out, expected * np.tile(ALBEDO, 2) / np.pi, rtol=1e-5, atol=1e-12)


def test_uniform_plane_has_its_irradiance():
    """Mean over 400 points of E = flux / area; noise of 20000 photons within r = 0.2: 1.5%, of the mean less."""
    deposits, below = photons_on_plane(20_000, seed=3)
    photons = build_map(deposits, 0.2)
    rng = np.random.default_rng(4)
    out, total = np.zeros(6), np.zeros(6)
    for x, y in rng.uniform(-0.8, 0.8, (400, 2)):
        irradiance((x, y, 0.0), UP, photons, 0.2, NEAR, out)
        total += out / 400
    assert np.allclose(total[:3], deposits.flux[~below].sum(axis=0) / 4.0, rtol=0.02)


def lattice(value, spacing=0.005):
    """One photon in the middle of each square of a lattice on [-1, 1]^2, its flux value(x, y) times the square."""
    axis = np.arange(-1 + spacing / 2, 1, spacing)
    x, y = (a.ravel() for a in np.meshgrid(axis, axis))
    position = np.stack([x, y, 0 * x], axis=1).astype(np.float32)
    flux = np.repeat((value(x, y) * spacing**2)[:, None], 3, axis=1).astype(np.float32)
    wi = np.full(len(x), pack_direction(UP), np.uint32)
    facet = np.full(len(x), pack_facet(UP, True, OBJECT), np.uint32)
    return Deposits(position, flux, wi, facet, np.zeros(len(x), np.uint8))


@pytest.mark.parametrize("front", [True, False])
@pytest.mark.parametrize("other", [OBJECT, OBJECT + 1])
def test_light_inside_a_ball_does_not_shine_on_the_floor_it_stands_on(front, other):
    """Photons that leave the ball through its foot arrive at its back, from above, where the floor's arrive too.

    Facets of one object count whatever their winding, those of another one only when both meshes look the same way.
    """
    deposits, below = photons_on_plane(400)
    facet = np.full(400, pack_facet(UP, front, other), np.uint32)
    photons = build_map(deposits._replace(normal=facet), 0.5)
    rows = pack(recipes.diffuse(np.array([ALBEDO], np.float32), np.zeros(1, np.float32), None), 1, 1)
    scratch = np.zeros((1, 8))
    scratch[0, :3], scratch[0, 3], scratch[0, 4] = ALBEDO, 0.5, 2.0
    counts = front or other == OBJECT
    out = np.zeros(6)
    irradiance((0.0, 0.0, 0.0), UP, photons, 0.5, NEAR, out)
    assert np.allclose(out, naive_irradiance(deposits, np.full(400, counts), (0.0, 0.0, 0.0), 0.5), rtol=1e-6)
    radiance(rows, (0.0, 0.0, 0.0), UP, UP, scratch, photons, 0.5, out)
    above = naive_irradiance(deposits, counts & ~below, (0.0, 0.0, 0.0), 0.5)
    assert np.allclose(out, above * np.tile(ALBEDO, 2) / np.pi, rtol=1e-5)


def test_bias_is_r2_laplace_over_12_on_a_smooth_field():
    """E = 1 + x^2 + 2 y^2: bias r^2 6 / 12, exponent 2; the lattice adds about (spacing / r)^2."""
    photons = build_map(lattice(lambda x, y: 1 + x * x + 2 * y * y), 0.1)
    radii = np.array([0.1, 0.2, 0.4])
    out, found = np.zeros(6), []
    for r in radii:
        irradiance((0.1, 0.2, 0.0), UP, photons, r, NEAR, out)
        found.append((out[0] - 1.09, out[3]))
    true, claimed = np.array(found).T
    assert np.allclose(true, radii**2 / 2, rtol=0.02, atol=2e-4) and np.allclose(claimed, true, rtol=0.02, atol=2e-4)
    assert abs(np.polyfit(np.log(radii), np.log(true), 1)[0] - 2.0) < 0.05


def test_bias_at_a_step_is_half_seen():
    """Across the edge of a shadow the rms of the estimate is 0.50 of the true bias's, so that it is worth a factor."""
    photons = build_map(lattice(lambda x, y: (x > 0).astype(float)), 0.1)
    out, found = np.zeros(6), []
    for x in np.arange(-0.1975, 0.2, 0.005):  # between the lattice's columns
        irradiance((x, 0.0, 0.0), UP, photons, 0.2, NEAR, out)
        found.append((out[0] - (x > 0), out[3]))
    true, claimed = np.sqrt((np.array(found) ** 2).mean(axis=0))
    assert abs(claimed / true - 0.50) < 0.02
