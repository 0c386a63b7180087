import numpy as np
import pytest

from ..nodes.light_path import LIGHT_PATH_COUNTS, LIGHT_PATH_FLAGS, light_path
from ..points import probe_points
from ..trail import CAMERA, DIFFUSE, GLOSSY, MOST, SINGULAR, bounced, no_trails, passed

NAMES = {*LIGHT_PATH_FLAGS, *LIGHT_PATH_COUNTS, "Is Shadow Ray", "Ray Length", "Portal Depth"}


def answers(trail=None, **fields):
    """Outputs of the node that are not 0."""
    points = probe_points(1)
    points.trail = None if trail is None else np.full(1, trail, np.int64)
    for name, value in fields.items():
        setattr(points, name, value)
    found = light_path({}, {"used": NAMES}, points)
    return {name: float(value[0]) for name, value in found.items() if value[0]}


def test_from_the_camera():
    assert answers(CAMERA) == {"Is Camera Ray": 1.0}
    assert answers(passed(passed(CAMERA))) == {"Is Camera Ray": 1.0, "Transparent Depth": 2.0}


@pytest.mark.parametrize(
    ("kind", "reflected", "expected"),
    [
        (DIFFUSE, True, {"Is Diffuse Ray", "Is Reflection Ray", "Diffuse Depth"}),
        (GLOSSY, True, {"Is Glossy Ray", "Is Reflection Ray", "Glossy Depth"}),
        (GLOSSY | SINGULAR, True, {"Is Glossy Ray", "Is Singular Ray", "Is Reflection Ray", "Glossy Depth"}),
        (GLOSSY | SINGULAR, False, {"Is Glossy Ray", "Is Singular Ray", "Is Transmission Ray", "Transmission Depth"}),
        (DIFFUSE, False, {"Is Diffuse Ray", "Is Transmission Ray", "Transmission Depth"}),
    ],
)
def test_bounces_replace_flags_and_add_counts(kind, reflected, expected):
    assert answers(bounced(CAMERA, kind, reflected)) == dict.fromkeys({*expected, "Ray Depth"}, 1.0)
    after = answers(bounced(bounced(CAMERA, GLOSSY, True), DIFFUSE, True))
    assert "Is Glossy Ray" not in after and after["Glossy Depth"] == 1.0 and after["Ray Depth"] == 2.0


def test_light_and_photons():
    assert answers() == {"Ray Depth": 1.0}
    assert answers(is_shadow=True, ray_length=np.ones(1, np.float32)) == {
        "Is Shadow Ray": 1.0, "Ray Depth": 1.0, "Ray Length": 1.0,
    }  # fmt: skip
    photon = {"Is Diffuse Ray": 1.0, "Is Reflection Ray": 1.0, "Ray Depth": 1.0, "Diffuse Depth": 1.0}
    assert answers(is_photon=True, ray_length=np.ones(1, np.float32)) == photon


def test_counts_stop():
    """A count that is full does not run over into the next."""
    trail = CAMERA
    for _ in range(MOST + 9):
        trail = bounced(trail, GLOSSY, True)
    counts = {"Ray Depth": float(MOST), "Glossy Depth": float(MOST)}
    assert answers(trail) == {"Is Glossy Ray": 1.0, "Is Reflection Ray": 1.0, **counts}


def test_nothing_is_kept_where_nobody_asks():
    assert len(no_trails(7, False)) == 0 and (no_trails(7, True) == CAMERA).all()
