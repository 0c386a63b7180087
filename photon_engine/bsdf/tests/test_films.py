"""Thin films and thin walls against what must hold of them."""

from __future__ import annotations

import numpy as np
import pytest

from .. import recipes
from ..batch import sample_batch
from ..fresnel import fresnel_conductor, fresnel_dielectric
from ..layout import pack
from ..thinfilm import film_dielectric, film_metal
from .registry import frames, zeros

COSINES = (0.05, 0.4, 0.8, 1.0)
GOLD = [(0.183, 3.424), (0.421, 2.345), (1.373, 1.770)]
FAR = 9000.0  # [nm] beyond the coherence of all three curves: what remains of the waves there is 4e-3 at most


@pytest.mark.parametrize("c", COSINES)
@pytest.mark.parametrize("ior", [1.33, 1.8, 0.8])
def test_a_film_of_the_glass_itself_is_not_seen(c, ior):
    expected, cos_t = fresnel_dielectric(c, ior)
    found = film_dielectric(c, 400.0, ior, ior)
    np.testing.assert_allclose(found, [expected if cos_t > 0.0 else 1.0] * 3, atol=1e-12)


@pytest.mark.parametrize("c", COSINES)
def test_a_faint_film_is_none(c):
    expected, _ = fresnel_dielectric(c, 1.5)
    np.testing.assert_allclose(film_dielectric(c, 1e-4, 2.0, 1.5), [expected] * 3, atol=1e-6)
    for channel, (n, k) in enumerate(GOLD):
        found = film_metal(channel, c, (1e-4, 2.0), (n, k, -1.0))
        assert found == pytest.approx(fresnel_conductor(c, n, k), abs=0.02)  # three orders of the sum


@pytest.mark.parametrize("c", COSINES)
def test_a_thick_film_has_no_colour(c):
    """Light that went round the film no longer interferes: R12 + T12^2 R23 / (1 - R12 R23), mean of polarisations."""
    found = np.array(film_dielectric(c, FAR, 1.4, 1.7))
    assert np.ptp(found) < 5e-3
    assert abs(found.mean() - incoherent(c, 1.4, 1.7)) < 5e-3


def incoherent(c, film, eta):
    """Reflectance of two interfaces whose waves do not interfere."""
    inner = np.sqrt(1.0 - (1.0 - c * c) / film**2)
    cos_t = np.sqrt(1.0 - (1.0 - c * c) / eta**2)
    total = 0.0
    for swap in (False, True):
        a, b, d = ((c, film * inner, eta * cos_t) if not swap else (1.0 / c, film / inner, eta / cos_t))
        top, low = ((a - b) / (a + b)) ** 2, ((b - d) / (b + d)) ** 2
        total += 0.5 * (top + (1.0 - top) ** 2 * low / (1.0 - top * low))
    return total


@pytest.mark.parametrize("roughness", [0.0, 0.5])
@pytest.mark.parametrize("mu", [0.3, 0.9])
def test_a_clear_wall_loses_nothing(roughness, mu):
    """Without colour all light is reflected or passes; a smooth wall lets it pass straight, R = 2 r / (1 + r)."""
    lobes = recipes.principled(
        base_color=1.0, transmission_weight=1.0, roughness=roughness, ior=1.5, thin_wall=True
    )  # fmt: skip
    n, wo = 20_000, np.array([np.sqrt(1.0 - mu * mu), 0.0, mu])
    u = np.random.default_rng(3).random((n, 3))
    _, wi, weight, _, eta = sample_batch(pack(lobes, 1, len(lobes)), zeros(n), frames(n, wo), u)
    assert weight.mean() == pytest.approx(1.0, abs=0.01)  # energy is given back by tables of 32 x 32
    assert (eta == 1.0).all()
    r = fresnel_dielectric(mu, 1.5)[0]
    back = (weight[:, 0] * (wi[:, 2] > 0.0)).mean()
    assert back == pytest.approx(2.0 * r / (1.0 + r), abs=0.01)  # noise 0.003
    if roughness == 0.0:
        np.testing.assert_allclose(wi[wi[:, 2] < 0.0], np.broadcast_to(-wo, (int((wi[:, 2] < 0.0).sum()), 3)))


def test_a_bubble_reflects_though_it_bends_nothing():
    from ...shading.program import bends_nothing

    (bubble,) = recipes.glass(1.0, 0.0, 1.0, thin_film=recipes.film(400.0, 1.33))
    (air,) = recipes.glass(1.0, 0.0, 1.0)
    assert bends_nothing(air) and not bends_nothing(bubble)
