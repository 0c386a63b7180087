"""Images of lamps far smaller than a pixel are found, and looked at without bias and without fireflies."""

import math

import numpy as np
import pytest

from ...issues import IssueLog
from ...scene.data import Frame, Light
from ...settings import Settings
from ..eye_pass import LampImages, further_paths, no_images
from ..glints import LARGE, MOST_PATHS, MOST_SHARE, Glints, allot, area, find_boxes, merged, mixture
from ..lamp_edges import LARGER
from ..renderer import Renderer
from .plan_scenes import place, scene

FEW = {"caustic_photons": 64, "diffuse_photons": 64, "light_samples": 1, "threads": 1, "seed": 3}
PASSES = 96
IMAGES = np.array([[3.3, 4.7], [9.1, 2.2], [5.5, 8.25]])  # on the film [px]
RADIUS = 0.02  # of each [px]
SPECKS = {
    "straight": ((0.1, 0.05, 2.0), "Matte", 2.0, 1.0),
    # behind the camera, which the floor shows at 4 + 5 m; its reflectance is 0.8, 0.7, 0.6
    "in a mirror": ((-0.5, 0.3, 5.0), "Mirror", 9.0, 0.7),
}


def met(film, size):
    """Emission of the three images, 500 each."""
    gap = np.linalg.norm(film[:, None] - IMAGES, axis=2).min(axis=1, initial=np.inf)
    return np.where(gap < size * RADIUS, 500.0, 0.0)


def found():
    """Boxes about the images, and the light in them."""
    film = np.random.default_rng(1).random((8192, 2)) * 12.0
    return find_boxes(met, film[met(film, LARGER) > 0.0], 5)


def test_images_are_found_with_all_of_their_extent():
    boxes, light = found()
    for x, y in IMAGES:
        around = boxes[(boxes[:, 0] < x) & (x < boxes[:, 1]) & (boxes[:, 2] < y) & (y < boxes[:, 3])]
        assert len(around) == 1
        assert area(around)[0] < 9.0 * (2.0 * RADIUS) ** 2 and area(around)[0] > 0.5 * (2.0 * RADIUS) ** 2
    assert len(boxes) == len(IMAGES)
    # a disk in a square about it, whose sides are up to 3 times as long: 0.087 to 0.785 of 500
    assert ((light[:, 0] > 20.0) & (light[:, 0] < 480.0) & (light[:, 1] > 50.0)).all()


def test_nothing_is_found_where_nothing_is_met():
    boxes, light = find_boxes(lambda film, _size: np.zeros(len(film)), np.ones((7, 2)), 5)
    assert boxes.shape == (0, 4) and light.shape == (0, 2)
    boxes, light = find_boxes(met, np.empty((0, 2)), 5)
    assert boxes.shape == (0, 4) and light.shape == (0, 2)


def test_large_images_are_left_to_other_paths():
    boxes, _ = find_boxes(lambda film, size: np.where(np.abs(film - 6.0).max(axis=1) < 2.0 * size, 9.0, 0.0),
                          np.full((9, 2), 6.0), 5)  # fmt: skip
    assert (area(boxes) < LARGE).all() and len(boxes) < 9


def test_boxes_with_their_middle_in_another_become_one():
    boxes = np.array([[0.0, 4.0, 0.0, 4.0], [3.0, 4.5, 1.0, 2.0], [3.9, 6.0, 0.0, 1.0], [8.0, 9.0, 8.0, 9.0]])
    assert merged(boxes).tolist() == [[0.0, 4.5, 0.0, 4.0], [3.9, 6.0, 0.0, 1.0], [8.0, 9.0, 8.0, 9.0]]


def test_every_pixel_whose_filter_reaches_an_image_has_it():
    table = np.linspace(0.0, 1.5, 5)
    boxes, light = found()
    frame = Frame(40, 30, 1, 2, 11, 12)
    glints = allot(boxes, light, table, frame)
    assert glints.first[0] == 0 and glints.first[-1] == len(glints.box) == len(glints.count)
    assert 1 <= glints.count.min() and glints.count.max() <= MOST_PATHS and glints.count.sum() <= MOST_SHARE * 100
    with_any = np.flatnonzero(np.diff(glints.first))
    x, y = with_any % 10 + 1 + 0.5, with_any // 10 + 2 + 0.5
    gap = np.abs(np.stack([x, y], 1)[:, None] - IMAGES).max(axis=2).min(axis=1)
    assert (gap < 1.5 + RADIUS * 3).all()
    own = [(int(py) - 2) * 10 + int(px) - 1 for px, py in IMAGES]
    assert np.isin(own, with_any).all()
    sides = glints.box[:, 1::2] - glints.box[:, ::2]
    assert (sides > 0.0).all() and (glints.box >= 0.0).all() and (glints.box <= 1.0).all()


def test_weights_of_a_mixture_sum_to_one_and_to_any_integral():
    """Four paths over the pixel and six over two boxes that overlap: the mean of their sum, of 1 and of u v^2."""
    glints = Glints(np.array([0, 0, 2]), np.array([[0.2, 0.3, 0.5, 0.9], [0.25, 0.6, 0.6, 0.65]]), np.array([4, 2]))
    n, rng = 20_000, np.random.default_rng(2)
    corner = np.repeat([[0.0, 1.0, 0.0, 1.0], *glints.box], [4, 4, 2], axis=0)
    u = corner[:, ::2] + rng.random((n, 10, 2)) * (corner[:, 1::2] - corner[:, ::2])
    weight = np.empty(n * 10)
    mixture(glints, np.ones(n * 10, np.int64), u.reshape(-1, 2), np.full(n * 10, 4.0), weight)
    for value, integral in ((np.ones(n * 10), 1.0), (u[..., 0].ravel() * u[..., 1].ravel() ** 2, 1.0 / 6.0)):
        sums = (weight * value).reshape(n, 10).sum(axis=1)
        assert abs(sums.mean() - integral) < 3.5 * sums.std() / n**0.5


def test_paths_of_a_run_of_pixels_are_numbered_within_each():
    glints = Glints(np.array([0, 0, 1, 1, 3]), np.array([[0.1, 0.2, 0.0, 1.0]] * 3), np.array([2, 1, 3]))
    images = LampImages(np.array([True, False, False, True]), 2, glints)
    pixels, numbers, boxes = further_paths(images, 0, 4)
    assert pixels.tolist() == [0, 0, 0, 1, 1, 1, 3, 3, 3, 3, 3, 3, 3]
    assert numbers.tolist() == [0, 1, 2, 0, 1, 2, 0, 1, 2, 3, 4, 5, 6]
    assert (boxes[:, 1] == 1.0).tolist() == [True] * 4 + [False] * 2 + [True] * 3 + [False] * 4
    pixels, numbers, _ = further_paths(images, 2, 2)
    assert pixels.tolist() == [3] * 7 and numbers.tolist() == list(range(7))


@pytest.mark.parametrize("case", list(SPECKS))
def test_a_lamp_of_a_thousandth_of_a_pixel_has_its_light_and_no_fireflies(case):
    position, floor, distance, reflectance = SPECKS[case]
    pixel = 0.7 / 12.0  # at 1 m
    share = 1e-3
    cosine = distance / math.hypot(distance, position[0], position[1])
    radius = math.sqrt(share * pixel**2 * cosine**3 / math.pi) * distance / cosine
    data = scene(floor, "Matte", "Matte", lamps=())
    data.instances = data.instances[:1]
    data.lights.append(Light("Speck", "POINT", place(*position), (1.0, 1.0, 1.0), radius=radius))
    told = {}
    for name in ("with", "plain"):
        renderer = Renderer(data, Settings(**FEW), IssueLog(), frozenset({"Emission"}))
        renderer.prepare(lambda _text: None)
        expected = renderer.scene.lights.radiance[0, 1] * share * reflectance
        if name == "plain":
            renderer.lamp_images = no_images(144)
        else:
            assert len(renderer.lamp_images.glints.count) > 0
        told[name] = np.array([renderer.render_pass(i, lambda: False)["Emission"][..., 1].sum() for i in range(PASSES)])
        renderer.close()
    mean, se = told["with"].mean(), told["with"].std(ddof=1) / PASSES**0.5
    assert se < 0.1 * expected
    assert abs(mean - expected) < 3.5 * se
    # a path in a thousand meets it: its variance is a thousand times the square of the mean
    assert told["with"].var() < 0.02 * 1e3 * expected**2
    assert told["plain"].max() > 100.0 * expected or told["plain"].max() == 0.0
