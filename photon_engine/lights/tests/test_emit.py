"""Photons of a whole light: their flux on a surface is the irradiance there times its area."""

import math

import numpy as np
import pytest

from ..emit import dark_distance, emit_photon, smoothstep_inverse
from .brute import assert_same, flux_on_disk, irradiance_on_disk, mean_and_error, uniform
from .scenes import EMITTERS, LAMPS, RGB, SINGLE, frame, lamp, table

N = 100_000
# a disk under the lamps, and one beside them that sees them at an angle and from closer
DISKS = {
    "below": ((0.1, 0.1, 0.0), (0.0, 0.0, 1.0), 0.5),
    "beside": ((0.9, 0.3, 1.0), (-0.5, -0.1, 0.8), 0.3),
}


def disk(name):
    center, normal, radius = DISKS[name]
    normal = np.array(normal) / np.linalg.norm(normal)
    return center, tuple(normal), radius


def arriving(lights, where, l=0, n=N):
    out = np.empty((n, 3))
    flux_on_disk(lights, l, *where, uniform(n, 4, 3), out)
    assert np.all(np.isfinite(out))
    return mean_and_error(out)


@pytest.mark.parametrize("place", DISKS)
@pytest.mark.parametrize("name", SINGLE)
def test_flux_on_a_disk_is_its_irradiance(name, place):
    lights, where = SINGLE[name](), disk(place)
    out = np.empty((N // 3, 3))
    irradiance_on_disk(lights, *where, uniform(N // 3, 5), out)
    mean, error = mean_and_error(out * (math.pi * where[2] ** 2))
    assert_same(arriving(lights, where), (mean, error))
    assert place == "beside" or np.all(mean > 0.0)


def test_soft_lamp_keeps_its_law_up_close():
    """At one radius from a soft lamp of 0.5 m the irradiance is half of the inverse square law's."""
    lights = table([lamp("POINT", frame((0.0, 0.0, 1.0)), radius=0.5)])
    where = ((0.0, 0.0, 0.5), (0.0, 0.0, 1.0), 0.02)
    expected = np.array(RGB) / (4 * math.pi * 0.5) * math.pi * 0.02**2
    mean, error = arriving(lights, where, n=2_000_000)
    # the irradiance falls by 0.1% toward the disk's rim
    assert_same((mean, error), (expected, 0.0), floor=1e-3 * expected.max())
    assert error[0] < 0.09 * mean[0]


def test_dark_distance_ends_where_the_facing_disk_begins():
    lights = SINGLE["soft point"]()
    c, radius = LAMPS["soft point"].matrix[:3, 3], LAMPS["soft point"].radius
    for b in (0.0, 0.1, 0.3, 0.45):
        o = (c[0] + b, c[1], c[2])
        s = dark_distance(lights, 0, o, (0.0, 0.0, -1.0))
        assert s * radius == pytest.approx(b * math.hypot(b, s)), "the rim of the disk that faces this point"
    assert dark_distance(SINGLE["sphere"](), 0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) == 0.0


# what a map of directions leaves of a lamp's flux is only estimated, to share out photons among lamps
@pytest.mark.parametrize("name", [name for name in SINGLE if not name.startswith("mapped")])
def test_mean_flux_is_the_lights_flux(name):
    lights = SINGLE[name]()
    phi = np.array([emit_photon(lights, 0, *u)[2] for u in uniform(20_000, 4, 9)])
    mean, error = mean_and_error(phi)
    flux = lights.flux[0]
    if name.startswith("sun "):
        # photons fill the disk across each direction, the table takes the irradiance across the axis
        h = lights.size[0, 0]
        flux = flux / (1.0 - 0.5 * h)
    assert_same((mean, error), (flux, flux * 1e-3))  # the table's sum over a scaled spot's cone


@pytest.mark.parametrize("name", SINGLE)
def test_photons_are_unit_finite_and_start_on_the_light(name):
    lights = SINGLE[name]()
    for u in [*uniform(500, 4, 2), np.zeros(4), np.full(4, 1 - 2.0**-53)]:
        o, d, phi, _ = emit_photon(lights, 0, *u)
        assert np.linalg.norm(d) == pytest.approx(1.0, abs=1e-12)
        assert np.all(np.isfinite(o)) and np.all(np.isfinite(phi)) and min(phi) >= 0.0
        if name in LAMPS and LAMPS[name].kind != "SUN":
            assert np.linalg.norm(np.subtract(o, LAMPS[name].matrix[:3, 3])) <= 1.3
        elif name != "mesh":
            assert np.linalg.norm(o) > 5.0, "photons from infinity start outside the scene"


def test_photons_of_unblended_spots_carry_equal_flux():
    """A round spot's directions follow its falloff, so that no photon is worth more than another."""
    for name in ("spot", "spot sphere", "sharp spot", "soft spot"):
        lights = SINGLE[name]()
        phi = np.array([emit_photon(lights, 0, *u)[2][0] for u in uniform(300, 4, 4)])
        assert np.ptp(phi) <= 1e-9 * phi[0]


def test_smoothstep_inverse():
    for u in np.concatenate([np.linspace(0.0, 1.0, 1001), [1e-12, 1.0 - 1e-12]]):
        x = smoothstep_inverse(u)
        assert 0.0 <= x <= 1.0
        assert 2 * x - 2 * x**3 + x**4 == pytest.approx(u, abs=1e-12)


def test_triangles_emit_on_both_sides_by_their_flux():
    lights = table(emitters=EMITTERS)
    photons = [emit_photon(lights, 0, *u) for u in uniform(20_000, 4, 6)]
    d = np.array([p[1] for p in photons])
    o = np.array([p[0] for p in photons])
    first = o[:, 0] > 0.0  # the triangles lie on either side of x = 0
    weight = lights.tri_area * (lights.tri_radiance @ [0.2126, 0.7152, 0.0722])
    share = weight[0] / weight.sum()
    assert first.mean() == pytest.approx(share, abs=4.5 * math.sqrt(share * (1 - share) / len(o)))
    normal = np.cross(lights.tri_e1[0], lights.tri_e2[0])
    front = (d[first] @ normal > 0.0).mean()
    assert front == pytest.approx(0.5, abs=4.5 * 0.5 / math.sqrt(first.sum()))
