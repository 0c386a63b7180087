"""More rays from narrow lobes: the same mean with far less noise, and no more rays from others."""

import numpy as np
import pytest

from ...bsdf.layout import CLASS_ROUGH, N_FIELDS, NONE, REFLECT, LobeRows
from ...issues import IssueLog
from ...settings import Settings
from ...shading.trail import CAMERA, DIFFUSE
from .. import renderer as module
from ..direct_kernels import empty_second_paths, sample_lobes
from ..eye_batch import empty_points
from ..lobes import ALL, NARROW, WIDE, keep_lobes, most_lobe_rays
from ..render_scene import RenderScene
from .plan_scenes import scene

PASSES = 96
FEW = {"caustic_photons": 64, "diffuse_photons": 2000, "threads": 1, "seed": 3}


def passes(most, monkeypatch, **surfaces):
    """Direct + Diffuse (passes, pixels, 3) of a scene, and how many rays the eye passes took."""
    monkeypatch.setattr(module, "MOST_LOBE_RAYS", most)
    renderer = module.Renderer(scene(**surfaces), Settings(**FEW), IssueLog())
    renderer.prepare(lambda _text: None)
    found = [renderer.render_pass(i, lambda: False) for i in range(PASSES)]
    rays = renderer.statistics["rays"]["eye"]
    renderer.close()
    return np.array([(p["Direct"] + p["Diffuse"]).reshape(-1, 3) for p in found], float), rays


@pytest.mark.parametrize(
    ("surfaces", "least"),
    [
        # half of a rough mirror's light is found by the four shadow rays as before
        ({"floor": "Polished", "wall": "Black", "lamps": (), "sky": 1.0}, 0.75),
        ({"floor": "Frosted", "wall": "Glow", "lamps": ()}, 0.45),
    ],
)
def test_mean_is_the_same_and_noise_far_less(surfaces, least, monkeypatch):
    (four, _), (one, _) = (passes(most, monkeypatch, pane="Clear", **surfaces) for most in (4, 1))
    assert four.var(axis=0, ddof=1).sum() < least * one.var(axis=0, ddof=1).sum()  # found: 0.58 and 0.28
    gap = (four - one).sum(axis=(1, 2))
    error = gap.std(ddof=1) / PASSES**0.5
    assert abs(gap.mean()) < 3.5 * error and error < 0.08 * one.sum(axis=(1, 2)).mean()


def test_wide_lobes_send_one(monkeypatch):
    surfaces = {"floor": "Satin", "pane": "Clear", "lamps": ("Area",), "sky": 0.3}
    assert passes(4, monkeypatch, **surfaces)[1] == passes(1, monkeypatch, **surfaces)[1]


def test_a_ray_is_of_what_weighs_more_whichever_lobes_gather():
    """Seen from straight above, plastic is far more diffuse than glossy: so are its rays to the Light Path node."""
    ready = RenderScene(scene(*("Plastic",) * 3), Settings(), IssueLog(), lambda _text: None)
    n, rng = 64, np.random.default_rng(5)
    o = np.column_stack([rng.uniform(-0.9, 0.9, (n, 2)), np.full(n, 0.5)]).astype(np.float32)
    d = np.tile(np.float32([0.0, 0.0, -1.0]), (n, 1))
    points = empty_points(n, trails=True)
    points.hit[:], points.wo[:], points.beta[:], points.key[:] = np.arange(n), -d, 1.0, np.arange(n)
    points.u[:], points.trail[:] = rng.random((n, 6)), CAMERA
    found = []
    for gathers in (0, 1, 2):
        paths = empty_second_paths(n * most_lobe_rays(4), trails=True)
        count = sample_lobes(ready.laws, ready.surfaces(o, d), points, gathers, ALL, 4, paths)
        found.append(paths.trail[:count])
        assert count > n and (found[-1] & DIFFUSE).all()
    np.testing.assert_array_equal(found[1], found[0])
    np.testing.assert_array_equal(found[2], found[0])


def test_lobes_of_the_hit_before_do_not_remain():
    """A narrow mirror alone; behind it scratch holds a rough lobe of another hit."""
    rows = LobeRows(np.array([[REFLECT, NONE]], np.int32), np.zeros((1, 2, N_FIELDS), np.float32))
    for lobes, remains in ((ALL, True), (NARROW, True), (WIDE, False)):
        scratch = np.ones((2, 8))
        scratch[:, 4] = CLASS_ROUGH
        assert keep_lobes(rows, 0, scratch, lobes) == remains
