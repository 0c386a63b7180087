import numpy as np
import pytest

from ...issues import RenderError
from ...scene.data import Camera, Frame
from ..filters import REACH
from ..rays import build_camera, generate_ray

CENTRE = 0.5  # of the filter: no offset


def look(rng):
    """A random rigid camera matrix."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = q * np.sign(np.linalg.det(q))
    matrix[:3, 3] = rng.normal(size=3) * 10.0
    return matrix


def project(camera, frame, p):
    """Pixel coordinates of world points by the pinhole formula, (n, 2)."""
    local = (p - camera.matrix[:3, 3]) @ camera.matrix[:3, :3]
    left, right, bottom, top = camera.window
    xy = local[:, :2] if camera.kind == "ORTHO" else local[:, :2] / -local[:, 2:]
    return (xy - (left, bottom)) / (right - left, top - bottom) * (frame.width, frame.height)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_rays_pass_through_their_pixel(kind):
    rng = np.random.default_rng(1)
    frame = Frame(width=40, height=30)
    for _ in range(20):
        camera = Camera(kind=kind, matrix=look(rng), window=(-0.7, 0.4, -0.3, 0.6))
        origin = rng.normal(size=3) * 5.0
        table = build_camera(camera, frame, origin)
        px, py = int(rng.integers(40)), int(rng.integers(30))
        o, d, *_ = generate_ray(table, px, py, CENTRE, CENTRE, 0.0, 0.0)
        p = np.array(o) + origin + rng.uniform(1.0, 9.0) * np.array(d)
        assert np.linalg.norm(d) == pytest.approx(1.0, abs=1e-12)
        np.testing.assert_allclose(project(camera, frame, p[None])[0], (px + 0.5, py + 0.5), atol=1e-9)


@pytest.mark.parametrize("name", list(REACH))
def test_the_filter_moves_the_ray_by_pixels(name):
    frame = Frame(width=16, height=16, filter=name, filter_width=1.2)
    camera = Camera(window=(-1.0, 1.0, -1.0, 1.0))
    o, d, *_ = generate_ray(build_camera(camera, frame), 8, 3, 0.0, 1.0 - 1e-16, 0.0, 0.0)
    xy = project(camera, frame, (np.array(o) + np.array(d))[None])[0]
    # the ends of the unit interval are the ends of the filter
    # (1e-3 px: how far the last number below 1 is from 1 where the filter is thinnest)
    np.testing.assert_allclose(xy, (8.5 - REACH[name] * 1.2, 3.5 + REACH[name] * 1.2), atol=1e-3)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_clipping_planes_lie_across_the_view_axis(kind):
    rng = np.random.default_rng(2)
    camera = Camera(kind=kind, matrix=look(rng), clip_start=0.5, clip_end=7.0, aperture_radius=0.2, focus_distance=3.0)
    table = build_camera(camera, Frame(width=8, height=8))
    for px in range(8):
        o, d, near, far, *_ = generate_ray(table, px, 2, *rng.random(4))
        for t, depth in ((near, 0.5), (far, 7.0)):
            local = (np.array(o) + t * np.array(d) - camera.matrix[:3, 3]) @ camera.matrix[:3, :3]
            assert -local[2] == pytest.approx(depth, abs=1e-12)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_circle_of_confusion(kind):
    """On the plane at depth z the lens images a point as a disk of radius R |z - f| / f around the pinhole's."""
    rng = np.random.default_rng(3)
    radius, focus = 0.15, 4.0
    frame = Frame(width=8, height=8, filter="BOX", filter_width=1e-9)
    camera = Camera(kind=kind, aperture_radius=radius, focus_distance=focus)
    table = build_camera(camera, frame)
    pinhole = build_camera(Camera(kind=kind), frame)
    sharp_o, sharp_d, *_ = generate_ray(pinhole, 6, 1, CENTRE, CENTRE, 0.0, 0.0)
    for depth in (1.0, 4.0, 11.0):
        centre = np.array(sharp_o) + np.array(sharp_d) * depth / -sharp_d[2]
        spots = []
        for _ in range(500):
            o, d, *_ = generate_ray(table, 6, 1, CENTRE, CENTRE, *rng.random(2))
            spots.append(np.array(o) + np.array(d) * depth / -d[2] - centre)
        r = np.linalg.norm(spots, axis=1)
        largest = radius * abs(depth - focus) / focus
        assert r.max() <= largest + 1e-8
        # 500 uniform points of a disk: E r^2 = R^2 / 2, standard deviation R^2 / sqrt(12 * 500)
        assert (r**2).mean() == pytest.approx(largest**2 / 2.0, abs=4.0 * largest**2 / np.sqrt(6000.0) + 1e-12)


def test_footprint_is_half_a_pixel():
    frame = Frame(width=10, height=20)
    camera = Camera(window=(-0.8, 0.9, -0.5, 0.6))
    table = build_camera(camera, frame)
    for px, py in ((0, 0), (5, 10), (9, 19)):
        *_, spread, radius0 = generate_ray(table, px, py, CENTRE, CENTRE, 0.0, 0.0)
        # solid angle of the pixel by the four corner directions' triangles [Van Oosterom and Strackee 1983]
        x = -0.8 + 0.17 * (px + np.array([0.0, 1.0]))
        y = -0.5 + 0.055 * (py + np.array([0.0, 1.0]))
        corners = [np.array(c) / np.linalg.norm(c) for c in
                   ((x[0], y[0], -1), (x[1], y[0], -1), (x[1], y[1], -1), (x[0], y[1], -1))]  # fmt: skip
        omega = sum(triangle_solid_angle(*(corners[k] for k in t)) for t in ((0, 1, 2), (0, 2, 3)))
        # 0.5%: the density at the pixel's centre stands for its mean
        assert (2.0 * spread) ** 2 == pytest.approx(omega, rel=5e-3)
        assert radius0 == 0.0
    ortho = build_camera(Camera(kind="ORTHO", window=(-2.0, 2.0, -2.0, 2.0)), Frame(width=10, height=10))
    *_, spread, radius0 = generate_ray(ortho, 3, 3, CENTRE, CENTRE, 0.0, 0.0)
    assert (spread, radius0) == (0.0, pytest.approx(0.2))


def triangle_solid_angle(a, b, c):
    """Solid angle of the spherical triangle of three unit vectors."""
    return 2.0 * np.arctan2(abs(np.dot(a, np.cross(b, c))), 1.0 + a @ b + b @ c + c @ a)


def test_far_from_the_origin_no_digit_is_lost():
    matrix = np.eye(4)
    matrix[:3, 3] = (1e7, -2e7, 3e7)
    table = build_camera(Camera(matrix=matrix), Frame(), origin=(1e7, -2e7, 3e7 + 1.0))
    o, *_ = generate_ray(table, 3, 4, 0.1, 0.2, 0.3, 0.4)
    assert o == (0.0, 0.0, -1.0)


@pytest.mark.parametrize("bad", [
    {"window": (1.0, 1.0, -1.0, 1.0)}, {"clip_end": 0.05}, {"aperture_radius": 0.1, "focus_distance": 0.0},
])  # fmt: skip
def test_cameras_that_see_nothing_are_refused(bad):
    with pytest.raises(RenderError, match="Camera"):
        build_camera(Camera(**bad), Frame())
