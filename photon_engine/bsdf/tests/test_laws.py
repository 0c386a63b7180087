"""Formulas against independent short forms: complex Fresnel, quadrature, geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ...sampling.warps import turn
from .. import fresnel, recipes, tables
from ..diffuse import bump_softening, oren_nayar
from ..frame import raised_normal
from ..make_tables import directional, grid, index_grid
from ..microfacet import ggx_d, ggx_lambda, sample_vndf

COSINES = [1.0, 0.9, 0.5, 0.2, 0.01]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
MU, DMU = 0.5 * (NODES + 1.0), 0.5 * WEIGHTS


def naive_fresnel(c, index):
    """Unpolarised reflectance for a complex index, from Snell's law with complex angles."""
    ct = np.sqrt(1.0 - (1.0 - c * c) / (index * index + 0j))
    r_s = (c - index * ct) / (c + index * ct)
    r_p = (index * c - ct) / (index * c + ct)
    return 0.5 * (abs(r_s) ** 2 + abs(r_p) ** 2)


@pytest.mark.parametrize("c", COSINES)
@pytest.mark.parametrize("eta", [1.5, 1.001, 2.4, 1 / 1.5, 0.9])
def test_dielectric(c, eta):
    f, cos_t = fresnel.fresnel_dielectric(c, eta)
    assert f == pytest.approx(naive_fresnel(c, eta), abs=1e-12)
    sin_t = math.sqrt(1.0 - c * c) / eta
    assert cos_t == pytest.approx(math.sqrt(max(1.0 - sin_t * sin_t, 0.0)), abs=1e-7)
    assert (f == 1.0) == (sin_t >= 1.0)


@pytest.mark.parametrize("c", COSINES)
@pytest.mark.parametrize("index", [0.18 + 3.42j, 1.37 + 1.77j, 1.5 + 0j, 2.0 + 0.3j])
def test_conductor(c, index):
    assert fresnel.fresnel_conductor(c, index.real, index.imag) == pytest.approx(naive_fresnel(c, index), abs=1e-12)


def test_f82():
    """F0 in front, Schlick's value times the tint at 82 degrees, the exact mean."""
    assert fresnel.fresnel_f82(1.0, 0.7, 0.3) == pytest.approx(0.7)
    schlick = 0.7 + 0.3 * (6.0 / 7.0) ** 5
    assert fresnel.fresnel_f82(1.0 / 7.0, 0.7, 0.3) == pytest.approx(0.3 * schlick)
    mean = sum(2.0 * m * d * fresnel.fresnel_f82(m, 0.7, 0.3) for m, d in zip(MU, DMU, strict=True))
    assert fresnel.average_f82(0.7, 0.3) == pytest.approx(mean, abs=1e-9)


@pytest.mark.parametrize("eta", [1.1, 1.5, 2.5, 1 / 1.5])
def test_dielectric_mean(eta):
    """The fit of the mean is good to 0.6% (it is Blender's: [Kulla and Conty 2017] quote that)."""
    mean = sum(2.0 * m * d * fresnel.fresnel_dielectric(m, eta)[0] for m, d in zip(MU, DMU, strict=True))
    assert fresnel.average_dielectric(eta) == pytest.approx(mean, abs=0.006)


@pytest.mark.parametrize("alpha", [0.01, 0.2, 0.7])
def test_ggx_projects_to_one(alpha):
    """Integral of D cos over facets is 1; the visible area from wo is n.wo: int G1 (wo.h)+ D = n.wo."""
    t = MU  # sin^2 = a^2 t / (1 - t + a^2 t) spreads the peak evenly
    sin2 = alpha**2 * t / (1.0 - t + alpha**2 * t)
    dsin2 = alpha**2 / (1.0 - t + alpha**2 * t) ** 2
    total = sum(math.pi * ggx_d(s, alpha**2) * d * w for s, d, w in zip(sin2, dsin2, DMU, strict=True))
    assert total == pytest.approx(1.0, abs=1e-9)
    wo, n_phi, area = (0.8, 0.0, 0.6), 256, 0.0
    for s, d, w in zip(sin2, dsin2, DMU, strict=True):
        phi = 2.0 * math.pi * (np.arange(n_phi) + 0.5) / n_phi
        lit = np.maximum(wo[0] * math.sqrt(s) * np.cos(phi) + wo[2] * math.sqrt(1.0 - s), 0.0).mean()
        area += math.pi * ggx_d(s, alpha**2) * lit / math.sqrt(1.0 - s) * d * w
    # the corner where facets turn their backs costs the quadrature 2e-3
    assert area / (1.0 + ggx_lambda(wo[2], alpha**2)) == pytest.approx(wo[2], rel=4e-3)


def test_visible_normals_are_visible():
    """Facets sampled from wo face it, are unit, and come out as n for a mirror."""
    rng = np.random.default_rng(2)
    n, wo = (0.0, 0.6, 0.8), (0.0, -0.7, math.sqrt(0.51) + 0.0)
    wo = tuple(np.array(wo) / np.linalg.norm(wo))
    for u1, u2 in rng.random((200, 2)):
        h = np.array(sample_vndf(wo, n, 0.9, u1, u2))
        assert np.linalg.norm(h) == pytest.approx(1.0, abs=1e-9)
        assert h @ wo > 0.0 and h @ n > 0.0
        assert np.allclose(sample_vndf(wo, n, 1e-7, u1, u2), n, atol=1e-5)


def test_turn():
    u = np.linspace(0.0, 1.0, 1001)[:-1]
    ours = np.array([turn(x) for x in u])
    np.testing.assert_allclose(ours[:, 0], np.cos(2 * math.pi * u), atol=1e-11)
    np.testing.assert_allclose(ours[:, 1], np.sin(2 * math.pi * u), atol=1e-11)


@pytest.mark.parametrize("sigma", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("c", [1.0, 0.5, 0.1])
def test_white_oren_nayar_keeps_energy(sigma, c):
    """White albedo is 1 by integration over the hemisphere."""
    total, n_phi = 0.0, 64
    for m, d in zip(MU, DMU, strict=True):
        for i in range(n_phi):
            phi = 2.0 * math.pi * (i + 0.5) / n_phi
            pair = m * c + math.sqrt((1 - m * m) * (1 - c * c)) * math.cos(phi)
            total += oren_nayar(m, c, pair, sigma, (1.0, 1.0, 1.0))[0] * m * d * 2.0 * math.pi / n_phi
    assert total == pytest.approx(1.0, abs=2e-3)  # the kink at t = 0 and the fit of the mean


def test_raised_normal_lifts_the_mirror_image():
    """The image of wo in the raised normal is just above the surface; a good normal is left alone."""
    rng = np.random.default_rng(4)
    ng = (0.0, 0.0, 1.0)
    raised = 0
    for wo, n in rng.normal(size=(500, 2, 3)):
        wo[2], n[2] = abs(wo[2]), abs(n[2])
        wo, n = wo / np.linalg.norm(wo), n / np.linalg.norm(n)
        m = np.array(raised_normal(tuple(n), ng, tuple(wo)))
        least = min(0.9 * wo[2], 0.01)
        height = (2.0 * (m @ wo) * m - wo)[2]
        assert np.linalg.norm(m) == pytest.approx(1.0) and height >= least - 1e-9
        if (2.0 * (n @ wo) * n - wo)[2] >= least:
            assert np.array_equal(m, n)
        else:
            raised += 1
            assert height == pytest.approx(least, abs=1e-9)
    assert raised > 50


def test_bump_softening_limits():
    """1 for an unbumped normal, 0 for light behind the smooth surface, between otherwise."""
    up = (0.0, 0.0, 1.0)
    tilted = (0.6, 0.0, 0.8)
    assert bump_softening(up, up, (0.1, 0.0, 0.99)) == 1.0
    assert bump_softening(up, tilted, (0.995, 0.0, -0.0999)) == 0.0
    assert 0.0 < bump_softening(up, tilted, (0.96, 0.0, 0.28)) < 1.0


def test_tables_hold_what_the_script_computes():
    """Spot checks of each table against its integral with another number of points."""
    rough, mu, eta = grid(16), grid(16), index_grid(16)
    for z, y, x in [(5, 8, 8), (3, 3, 12), (10, 15, 4)]:
        inside = (tables.INVERSE, 1, 1.0 / eta[z])
        for table, mode, index in ((tables.GLASS, 1, eta[z]), inside, (tables.SHARE, 2, eta[z])):
            # half the points change the tables by up to 2.2e-4: three times that
            assert table[z, y, x] == pytest.approx(directional(rough[x], mu[y], index, mode, 9000), abs=6e-4)
    fine = grid(32)
    assert tables.WHITE[0, 20, 9] == pytest.approx(directional(fine[9], fine[20], 1.0, 0, 9000), abs=6e-4)
    assert tables.white_albedo(fine[9], fine[20])[0] == pytest.approx(tables.WHITE[0, 20, 9], abs=1e-6)


@pytest.mark.parametrize("value", [np.ones((1, 3)), np.ones((5, 4)), [[0.5]]])
def test_a_colour_is_no_number(value):
    """As a damaged file may say: refused by name, where the node is known."""
    with pytest.raises(ValueError, match="a number needs the shape"):
        recipes.column(value)
