"""Where diffuse light is gathered when that is left to the engine."""

import numpy as np
import pytest

from ...issues import IssueLog
from ...settings import Settings
from ..pilot import LANDING_NEIGHBOURS, PILOT_PHOTONS, Pilot, Reach, _reach, gather_mode
from ..renderer import Renderer
from .plan_scenes import scene

FINAL = Settings(denoise="FINAL").resolved()


def pilot(one: float, footprint: float = 1.0) -> Pilot:
    """A pilot that found one photon within so many metres."""
    return Pilot(footprint, Reach(), Reach(0.0, 100.0, 1.0, one))


def test_a_denoised_picture_gathers_where_photons_are_sparser_than_pixels():
    apart = 1.0 / LANDING_NEIGHBOURS**0.5
    assert gather_mode(FINAL, pilot(1.1 * apart))[0] == "ALL"
    assert gather_mode(FINAL, pilot(0.9 * apart))[0] == "GLOSSY"
    assert gather_mode(FINAL, pilot(1.1 * apart, footprint=2.0))[0] == "GLOSSY"
    assert "8 diffuse photons lie within 1.1 half pixels" in gather_mode(FINAL, pilot(1.1 * apart))[1]


def test_what_is_not_known_or_was_chosen_stays():
    for unknown in (pilot(0.0), pilot(1.0, footprint=0.0)):
        assert gather_mode(FINAL, unknown)[0] == "GLOSSY"
    for chosen in ("OFF", "GLOSSY", "ALL"):
        for denoise in ("OFF", "FINAL"):
            settings = Settings(denoise=denoise, final_gather=chosen).resolved()
            assert gather_mode(settings, pilot(9.0))[0] == settings.final_gather == chosen
    assert Settings().resolved().final_gather == "GLOSSY"


def test_a_landing_holds_the_photons_that_it_promises():
    rng = np.random.default_rng(3)
    photons = np.zeros((20_000, 3))
    photons[:, :2] = rng.random((20_000, 2))
    reach = _reach(photons, (8.0, 60.0), 8 * PILOT_PHOTONS, 1.0)
    # within 10%: see test_radius_bounds
    assert np.pi * reach.landing**2 * 8 * 20_000 == pytest.approx(LANDING_NEIGHBOURS, rel=0.1)


@pytest.mark.parametrize(("photons", "plan"), [(2_000, True), (2_000, False), (20_000_000, True)])
def test_the_plan_follows_the_pilot(photons, plan):
    settings = Settings(denoise="FINAL", diffuse_photons=photons, caustic_photons=1000, plan=plan)
    renderer = Renderer(scene(), settings, IssueLog())
    try:
        assert renderer.settings.final_gather == "AUTO"
        renderer.prepare(lambda text: None)
        gathers, few = renderer.plan.gather_all, photons < 1e6
        assert gathers.runs == few and "half pixels" in gathers.reason
        assert renderer.plan.gather_narrow.runs <= (not few)
        if few:
            renderer.render_pass(0, lambda: False)
            _, _, bound, least = renderer.statistics["radii"]["diffuse"][0]
            assert bound == least == pytest.approx(renderer.pilot.diffuse.landing)
    finally:
        renderer.close()
