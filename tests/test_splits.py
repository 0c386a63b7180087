"""Eye paths that go every way at their first forks: the same light, less noise, sharper guides."""

import numpy as np
import pytest

from tests.brute import scenes as s
from tests.brute.harness import engine

LIGHT = ("Direct", "Caustic", "Diffuse", "Emission", "Environment")
FEW = {"caustic_photons": 20_000, "diffuse_photons": 20_000}


@pytest.mark.parametrize("variant", ["lamp", "world", "panel"])
def test_splits_keep_the_light_and_lower_its_noise(variant):
    """Every pass has the same mean in every block, and what is seen through glass has less variance."""
    scene = s.cornell(variant, 32)
    pick, _ = engine(scene, 16, splits=0, **FEW)
    split, _ = engine(scene, 16, splits=3, **FEW)
    for name in LIGHT:
        (a, se_a), (b, se_b) = pick.blocks(name, 16), split.blocks(name, 16)
        # 12 values, three of them of one colour: 5 sigma; photons are the same in both
        assert np.all(np.abs(a - b) <= 5.0 * np.hypot(se_a, se_b) + 1e-6), name
    glass = np.s_[8:15, 18:24]
    noise = [run["Direct"][:, *glass].var(axis=0).sum() for run in (pick, split)]
    assert noise[1] < 0.85 * noise[0], noise  # 0.12 and, with the world as light, 0.71


def veiled(opacity):
    """A see-through sheet, partly diffuse and turned about, before a wall."""
    wall = (s.quad((0, 1, 0), (4, 0, 0), (0, 0, 4), "wall"), s.diffuse(0.5))
    sheet = (s.quad((0, 0, 0), (2, 0, 0), (0, 0, 2), "sheet"), s.mixed(s.transparent(1.0), s.diffuse(0.8), opacity))
    sun, view = s.sun_lamp((0.2, 1.0, -0.3), 0.0, 1.0), s.camera((0, -4, 0), (0, 0, 0))
    return s.build([wall, sheet], [sun], view, picture=s.frame(8))


@pytest.mark.parametrize("opacity", [0.25, 0.75])
def test_guides_of_a_sheet_are_weighed_by_its_opacity(opacity):
    """Albedo is that of the sheet plus what it lets see, normals count alike; depth is of the half opaque surface."""
    scene = veiled(opacity)
    split, _ = engine(scene, 1, splits=1, **FEW)
    pick, _ = engine(scene, 64, splits=0, **FEW)
    albedo = opacity * 0.8 + (1.0 - opacity) * 0.5
    assert np.allclose(split["Albedo"], albedo, atol=1e-5)
    assert np.allclose(split["Normal"][..., 1], -1.0, atol=1e-5)
    assert np.allclose(split["Depth"], 4.0 if opacity > 0.5 else 5.0, atol=1e-4)
    assert abs(pick["Albedo"].mean() - albedo) < 0.01  # picks of 64 x 64 paths: 0.4%
    assert np.all(pick["Depth"] < 5.0 + 1e-4)  # a pick that ends at the sheet has the sheet's depth
    assert np.all(split["Alpha"] == 1.0)


def test_footprints_stay_finite():
    """64 bounces in curved glass at eight splits: widths of pixels grew beyond float32, and caustics were no number."""
    scene = s.cornell("lamp", 24)
    passes, _ = engine(scene, 2, splits=8, caustic_radius=50.0, **FEW)
    assert all(np.isfinite(picture).all() for picture in passes.values())
