"""Even light stays even at walls, corners, rims and contacts, and does not leak; the integrals against brute force."""

from itertools import pairwise

import numpy as np
import pytest

from ...geometry.flatten import Geometry
from ...geometry.intersect import Intersector
from ...jit import kernel
from ...photons.batch import Deposits
from ...photons.map import build_map
from ...photons.packing import body, pack_direction, pack_facet
from ...vec import load3
from ..clearing import share_clearings
from ..clearing_kernels import CELL, FAN, REACH, Sites
from ..clipping import LEAST_SHARE, MOST_LINES, free_shares
from ..gather_kernels import cut_at, flux_on_plane
from ..near_kernels import empty_near

R = 0.2  # gather radius in most tests
SPACING = 0.004  # of the photons: the lattice alone moves an estimate by up to 1.5% where a line cuts it


@kernel
def shares(work, count, n, r, out):
    """free_shares()."""
    out[0], out[1] = free_shares(work, count, n, r)


@kernel
def gathered(sites, clearings, photons, r, near, out):
    """Irradiance and its bias at every site, as `gather` computes them, and the share of K that is left."""
    for m in range(len(sites.prim)):
        p, n = load3(sites.p, m), load3(sites.n, m)
        cut = cut_at(clearings, m, p, n, r)
        flux, smear = flux_on_plane(p, n, body(True, 0), photons, r, cut, near)
        out[m, 0], out[m, 1], out[m, 2] = flux[0], smear[0], cut[2]


def quad(a, b, c, d, split=1):
    """Triangles of a quadrangle, divided into split x split: (T, 3, 3)."""
    a, b, c, d = (np.array(x, float) for x in (a, b, c, d))

    def at(u, v):
        return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d

    out = []
    for i in range(split):
        for j in range(split):
            corner = [at((i + x) / split, (j + y) / split) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
            out += [[corner[0], corner[1], corner[2]], [corner[0], corner[2], corner[3]]]
    return np.array(out)


def box(low, high):
    """A closed box."""
    x, y, z = ((a, b) for a, b in zip(low, high, strict=True))
    return np.concatenate([
        quad((x[0], y[0], h), (x[1], y[0], h), (x[1], y[1], h), (x[0], y[1], h)) for h in z
    ] + [
        quad((h, y[0], z[0]), (h, y[1], z[0]), (h, y[1], z[1]), (h, y[0], z[1])) for h in x
    ] + [
        quad((x[0], h, z[0]), (x[1], h, z[0]), (x[1], h, z[1]), (x[0], h, z[1])) for h in y
    ])  # fmt: skip


def geometry_of(*parts):
    """Flat triangles as kernels take them."""
    corners = np.concatenate(parts).astype(np.float32)
    n = len(corners)
    triangles = np.arange(3 * n, dtype=np.int32).reshape(n, 3)
    zero = np.zeros(n, np.int32)
    return Geometry(
        corners.reshape(-1, 3), triangles, np.full(n, -1, np.int32), np.zeros((0, 3, 3), np.float32), zero, zero
    )


def lit_floor(lit, low=-1.0, high=1.0):
    """Photons on z = 0 with E = lit(x, y)."""
    axis = np.arange(low + SPACING / 2, high, SPACING)
    x, y = (a.ravel() for a in np.meshgrid(axis, axis))
    value = lit(x, y).astype(float) * SPACING**2
    x, y, value = x[value > 0], y[value > 0], value[value > 0]
    up = np.full(len(x), pack_direction((0.0, 0.0, 1.0)), np.uint32)
    facet = np.full(len(x), pack_facet((0.0, 0.0, 1.0), True, 0), np.uint32)
    position = np.stack([x, y, 0 * x], axis=1).astype(np.float32)
    flux = np.repeat(value[:, None], 3, axis=1).astype(np.float32)
    return build_map(Deposits(position, flux, up, facet, np.zeros(len(x), np.uint8)), R)


def look(geometry, points, photons, r=R, around=2.0, normal=(0.0, 0.0, 1.0)):
    """Irradiance, bias and share (m, 3) at points (m, 2 or 3), and the rays that it took a point."""
    points = np.array(points, float)
    if points.shape[1] == 2:
        points = np.concatenate([points, np.zeros((len(points), 1))], axis=1)
    n = len(points)
    normals = np.tile(np.array(normal, float), (n, 1))
    intersector = Intersector(geometry)
    above = (points + 1e-3 * normals).astype(np.float32)
    prim = intersector.closest(above, (-normals).astype(np.float32)).prim
    key = np.random.default_rng(7).integers(1 << 60, size=n).astype(np.uint64)
    sites = Sites(points, normals, np.full(n, around * r), prim, key, np.zeros(n, np.uint64))
    clearings, rays = share_clearings(intersector, geometry, sites)
    out = np.zeros((n, 3))
    gathered(sites, clearings, photons, r, empty_near(), out)
    return out, rays / n


FLOOR = quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0))  # goes on below and behind everything
WALL = quad((0, -3, -1), (0, 3, -1), (0, 3, 2), (0, -3, 2))  # x = 0, stands through the floor
SECOND = quad((-3, 0, -1), (3, 0, -1), (3, 0, 2), (-3, 0, 2))  # y = 0
SLANTED = quad((0, -3, 0), (0, 3, 0), (0.5, 3, 2), (0.5, -3, 2))  # leans over x > 0, from its foot at x = 0


def right_of_zero(x, y):
    return x > 0


def distances(n=40, seed=1):
    """Points at x from 0.005 r to 1.2 r, anywhere in y."""
    rng = np.random.default_rng(seed)
    return np.stack([R * np.linspace(0.005, 1.2, n), rng.uniform(-0.5, 0.5, n)], axis=1)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
def test_shares_are_the_integrals_over_what_lines_leave(count):
    """Against a million points of the disc: their noise is 0.1% of K and 0.2% of K_4."""
    rng = np.random.default_rng(count)
    r = 0.7
    radius, angle = r * np.sqrt(rng.random(1_000_000)), 2 * np.pi * rng.random(1_000_000)
    x, y, y2 = radius * np.cos(angle), radius * np.sin(angle), (radius / r) ** 2
    for _ in range(3):
        turn, d = 2 * np.pi * rng.random(count), r * rng.random(count) ** 1.5
        work = np.zeros((MOST_LINES, 4))
        work[:count] = np.stack([np.cos(turn), np.sin(turn), 0 * turn, d], axis=1)
        free = np.ones(len(x), bool)
        for a, b, _, c in work[:count]:
            free &= a * x + b * y <= c
        kernel_k = 2 * (1 - y2) * free
        out = np.zeros(2)
        shares(work, count, (0.0, 0.0, 1.0), r, out)
        assert np.allclose(out, [kernel_k.mean(), (kernel_k * (3 - 6 * y2)).mean()], atol=0.008)


@pytest.mark.parametrize("wall", [WALL, SLANTED, quad((0, -3, -1), (0, 3, -1), (0, 3, 2), (0, -3, 2), 24)])
def test_even_light_stays_even_along_a_wall(wall):
    """Without the wall's line the estimate would be down to a half; its bias is said to be nothing."""
    found, _ = look(geometry_of(FLOOR, wall), distances(), lit_floor(right_of_zero))
    assert np.allclose(found[:, 0], 1.0, atol=0.02) and np.allclose(found[:, 1], 0.0, atol=0.05)
    assert found[:, 2].min() < 0.55 and found[-1, 2] == 1.0


def test_even_light_stays_even_in_a_corner_of_three():
    rng = np.random.default_rng(2)
    points = R * rng.random((200, 2)) ** 2
    photons = lit_floor(lambda x, y: (x > 0) & (y > 0))
    found, _ = look(geometry_of(FLOOR, WALL, SECOND), points, photons)
    assert abs(found[:, 0].mean() - 1.0) < 0.01 and np.percentile(abs(found[:, 0] - 1.0), 95) < 0.04
    assert found[:, 2].min() < 0.3


def test_light_behind_a_thin_wall_does_not_count():
    """Ten times as bright in the next room, behind a wall of a twentieth of the radius."""
    wall = box((-0.05 * R, -3, 0), (0, 3, 2))
    photons = lit_floor(lambda x, y: np.where(x > 0, 1.0, np.where(x < -0.05 * R, 10.0, 0.0)))
    found, _ = look(geometry_of(FLOOR, wall), distances(), photons)
    assert np.allclose(found[:, 0], 1.0, atol=0.02)


def test_rims_of_solids_and_of_free_sheets():
    """A box's top from z = 0 downward; a sheet of two triangles; one of 800; all end at x = 0."""
    flip = distances() * [-1, 1]
    photons = lit_floor(lambda x, y: x < 0)
    solid = box((-1, -1, -0.5), (0, 1, 0))
    sheet = ((-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0))
    below = FLOOR - [0, 0, 0.9]
    for name, part in (("solid", solid), ("sheet", quad(*sheet)), ("fine sheet", quad(*sheet, 20))):
        found, _ = look(geometry_of(part, below), flip, photons)
        assert np.allclose(found[:, 0], 1.0, atol=0.025), (name, found[:, 0])
        assert found[:, 2].min() < 0.55


def test_a_bevelled_rim_ends_the_surface():
    """No edge turns by more than 45 degrees, so that none is sharp by itself."""
    b = 0.02 * R
    top = quad((-1, -1, 0), (-b, -1, 0), (-b, 1, 0), (-1, 1, 0))
    bevel = quad((-b, -1, 0), (0, -1, -b), (0, 1, -b), (-b, 1, 0))
    side = quad((0, -1, -b), (0, -1, -1), (0, 1, -1), (0, 1, -b))
    found, _ = look(geometry_of(top, bevel, side), distances() * [-1, 1] - [b, 0], lit_floor(lambda x, y: x < -b))
    assert np.allclose(found[:, 0], 1.0, atol=0.06)  # the bevel's own photons are missing here


def test_boards_side_by_side_are_one_floor():
    """Solids with slits of a hundredth of the radius between them: no rim, the whole disc is used."""
    slit = 0.01 * R
    boards = [box((x, -2, -0.5), (x + 0.1 - slit, 2, 0)) for x in np.arange(-2, 2, 0.1)]
    found, _ = look(geometry_of(*boards), distances(), lit_floor(lambda x, y: x > -9))
    assert np.allclose(found[:, 0], 1.0, atol=0.01) and found[:, 2].min() == 1.0


def test_a_box_on_the_floor_that_shares_no_edge_with_it():
    """Points all around the foot of a box of twice the radius: the floor goes on beneath it, without light."""
    half = R
    cube = box((-half, -half, 0), (half, half, 2 * half))
    rng = np.random.default_rng(3)
    points = rng.uniform(-2 * R, 2 * R, (600, 2))
    points = points[(abs(points) > half).any(axis=1)]
    photons = lit_floor(lambda x, y: (abs(x) > half) | (abs(y) > half))
    found, _ = look(geometry_of(FLOOR, cube), points, photons)
    assert abs(found[:, 0].mean() - 1.0) < 0.005 and np.percentile(abs(found[:, 0] - 1.0), 98) < 0.03
    assert (found[:, 2] < 0.9).mean() > 0.2


def test_what_lies_above_on_another_board_does_not_count():
    """Shelves half the radius apart: light on the upper one, five times as bright, is not the lower one's."""
    height = 0.55 * R
    shelves = [box((-1, -1, h - 0.01), (1, 1, h)) for h in (0.0, height)]
    lower = lit_floor(lambda x, y: x > -9)
    n = len(lower.position)
    position = np.concatenate([lower.position, lower.position + np.float32([0, 0, height])])
    fields = [np.concatenate([f, f]) for f in (lower.wi, lower.normal)]
    flux = np.concatenate([lower.flux, 5 * lower.flux])
    photons = build_map(Deposits(position, flux, *fields, np.zeros(2 * n, np.uint8)), R)
    found, _ = look(geometry_of(*shelves), np.array([[0.1, 0.2], [-0.3, 0.3]]), photons)
    assert np.allclose(found[:, 0], 1.0, atol=0.02)


def test_a_needle_cuts_nothing_off():
    """A post of a tenth of the radius, a third of it away: a line there would take a third of the photons."""
    post = box((0.3 * R, -0.05 * R, 0), (0.4 * R, 0.05 * R, 1))
    found, _ = look(geometry_of(FLOOR, post), [(0.0, 0.0)], lit_floor(lambda x, y: x > -9))
    assert found[0, 2] == 1.0


def test_leaves_smaller_than_a_share_see_their_neighbours():
    """Triangles of a tenth of the radius, apart from each other: the whole disc, as if nothing were cut."""
    side = 0.1 * R
    corner = np.stack(np.meshgrid(np.arange(-8, 8), np.arange(-8, 8)), axis=-1).reshape(-1, 1, 2) * 4 * side
    leaf = np.array([[0, 0], [side, 0], [0, side]])
    leaves = np.concatenate([corner + leaf, np.zeros((256, 3, 1))], axis=2)
    found, _ = look(geometry_of(leaves), [(0.03 * R, 0.03 * R)], lit_floor(lambda x, y: x > -9))
    assert found[0, 2] == 1.0 and abs(found[0, 0] - 1.0) < 0.01


def test_a_ball_has_no_rims():
    """On a curved surface neighbours bend away from the tangent plane and stay the same surface."""
    rows, columns = np.linspace(0, np.pi, 60), np.linspace(0, 2 * np.pi, 120)
    parts = []
    for a, b in pairwise(rows):
        for c, d in pairwise(columns):
            around = ((a, c), (b, c), (b, d), (a, d))
            at = [(np.sin(t) * np.cos(f), np.sin(t) * np.sin(f), np.cos(t)) for t, f in around]
            parts.append(quad(*at))
    point = np.array([[0.6, 0.0, 0.8]]) * 0.9995
    photons = lit_floor(lambda x, y: x > -9)
    found, _ = look(geometry_of(*parts), point, photons, normal=(0.6, 0.0, 0.8))
    assert found[0, 2] == 1.0


def test_points_share_what_rays_found():
    """Pixels a tenth of the radius apart: about two rays each, and the reach that makes sharing safe."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(0.01, 0.6, 0.02), np.arange(-0.3, 0.3, 0.02)))
    photons = lit_floor(right_of_zero)
    found, rays = look(geometry_of(FLOOR, WALL), np.stack([x, y], axis=1), photons)
    assert rays < 2.0 and np.allclose(found[:, 0], 1.0, atol=0.02)
    # a long wall within the disc of any point of a cell is met by one ray at least
    assert REACH * np.cos(np.pi / FAN) >= 1.0 + CELL * np.sqrt(2.0) - 1e-12 and LEAST_SHARE < 0.25


def test_the_bias_of_a_slope_at_a_wall_is_seen():
    """E = 1 + x beside a wall: the true bias is O(r), and more than half of it is claimed, with its sign."""
    found, _ = look(geometry_of(FLOOR, WALL), distances(20)[:10], lit_floor(lambda x, y: np.where(x > 0, 1 + x, 0.0)))
    true = found[:, 0] - (1 + distances(20)[:10, 0])
    assert (true[:5] > 0.02).all() and (found[:5, 1] > 0.4 * true[:5]).all() and (found[:5, 1] < 1.1 * true[:5]).all()
