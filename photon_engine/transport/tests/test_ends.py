"""Photons for caustics end at any rough surface: what it looks like there is not evaluated."""

import numpy as np
import pytest

from ...issues import IssueLog
from ...settings import Settings
from ..photon_pass import run_for, trace_photons
from ..photon_rules import CAUSTIC
from ..renderer import Renderer
from .plan_scenes import scene


def deposits(data, everywhere: bool):
    """Caustic photons of a pass, by position, and how many times materials were evaluated at hits.

    everywhere : materials are evaluated wherever photons hit
    """
    renderer = Renderer(data, Settings(caustic_photons=4000, threads=1), IssueLog(), frozenset({"Caustic"}))
    try:
        renderer.prepare(lambda _text: None)
        table, calls = renderer.scene.materials, []
        rows_at = table.rows_at
        table.rows_at = lambda m, *args, **more: (calls.append(m), rows_at(m, *args, **more))[1]
        if everywhere:
            table.for_ends = np.arange(len(table.for_ends), dtype=np.int32)
        run = run_for(renderer.settings, 0, CAUSTIC)
        found, tally, _ = trace_photons(renderer.scene, renderer._pool, run, lambda: False)
    finally:
        renderer.close()
    order = np.lexsort(found.position.T)
    return type(found)(*(field[order] for field in found)), tally, len(calls)


@pytest.mark.parametrize("floor", ["Painted", "Satin", "Plastic"])
def test_rough_surfaces_keep_the_same_photons_unseen(floor):
    """Positions to rounding: those of Lambert hits are computed in vector instructions."""
    data = scene(floor=floor)
    lean, lean_tally, few = deposits(data, False)
    whole, whole_tally, many = deposits(data, True)
    assert few == 0 and (many > 0) == (floor == "Painted")
    assert len(lean.wi) == len(whole.wi) > 100
    np.testing.assert_allclose(lean.position, whole.position, atol=1e-6)
    np.testing.assert_array_equal(lean.flux, whole.flux)
    np.testing.assert_array_equal(lean.normal, whole.normal)
    np.testing.assert_allclose(lean_tally, whole_tally, rtol=1e-9)


@pytest.mark.parametrize("floor", ["Half", "Plastic", "Mirror", "Frosted"])
def test_what_light_goes_on_from_is_evaluated(floor):
    """Materials that may let a photon on keep their own rows; Frosted, which bends it widely, is rough."""
    renderer = Renderer(scene(floor=floor), Settings(threads=1), IssueLog(), frozenset({"Caustic"}))
    try:
        renderer.prepare(lambda _text: None)
        own = renderer.scene.materials.for_ends[0] == 0
    finally:
        renderer.close()
    assert own == (floor in ("Half", "Mirror"))
