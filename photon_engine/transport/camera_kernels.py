"""Where eye paths begin: one in each pixel, its point of the pixel and of the lens spread evenly over neighbours."""

from __future__ import annotations

from typing import NamedTuple

from ..camera.rays import generate_ray
from ..jit import kernel
from ..sampling.even import even_pair, morton
from ..sampling.rng import path_key, uniform
from ..vec import madd, store3
from .eye_batch import FILTER, LATTICE_X, LATTICE_Y, LENS

FURTHER = 1 << 20  # keys of a pixel's further paths; forks take the first numbers
ROUND = 1 << 22  # keys of a pixel's paths after the first


class Region(NamedTuple):
    """Which pixels are drawn, and which of their paths."""

    x0: int  # left column [px]
    y0: int  # bottom row
    width: int  # of the region
    row: int  # width of the full frame
    stride: int  # every so many pixels are drawn, counted row by row
    path: int  # which path of each pixel
    paths: int  # of how many


@kernel
def camera_rays(camera, key, region, first, splits, paths):
    """Eye paths of pixels first, first + stride, ... of a Region, row by row.

    splits : at how many forks a path goes every way
    """
    for i in range(len(paths.key)):
        x, y = _pixel_at(region, first + i * region.stride)
        place = _place(region, x, y)
        u0, u1 = even_pair(key, place, FILTER)
        u2, u3 = even_pair(key, place, LENS) if camera.aperture_radius > 0.0 else (0.0, 0.0)
        _begin(paths, i, _first_key(key, region, x, y), i, generate_ray(camera, x, y, u0, u1, u2, u3), splits)
        paths.place[i] = place


@kernel
def draw_points(key, region, pixels, numbers, boxes, points):
    """Where in their pixels' filter further paths go: points (m, 2) f64 in the unit square.

    pixels : (m,) i64 of the region;  numbers : (m,) i64, which path of its pixel each is; 0: that of `camera_rays`
    boxes : (m, 4) f64, low and high edges in the unit square. A path with the whole square belongs to a lattice about
    that of `camera_rays`, so that all of them cover the pixel evenly while each is distributed as a single one.
    """
    for i in range(len(pixels)):
        x, y = _pixel_at(region, pixels[i])
        if boxes[i, 0] == 0.0 and boxes[i, 1] == 1.0 and boxes[i, 2] == 0.0 and boxes[i, 3] == 1.0:
            u0, u1 = even_pair(key, _place(region, x, y), FILTER)
            points[i, 0] = (u0 + numbers[i] * LATTICE_X) % 1.0
            points[i, 1] = (u1 + numbers[i] * LATTICE_Y) % 1.0
        else:
            k = path_key(_first_key(key, region, x, y), FURTHER + numbers[i])
            points[i, 0] = boxes[i, 0] + uniform(k, 0) * (boxes[i, 1] - boxes[i, 0])
            points[i, 1] = boxes[i, 2] + uniform(k, 1) * (boxes[i, 3] - boxes[i, 2])


@kernel
def further_rays(camera, key, region, pixels, numbers, points, splits, paths):
    """Eye paths of chosen pixels besides those of `camera_rays`, as of `draw_points`: path i adds to pixel i."""
    for i in range(len(paths.key)):
        x, y = _pixel_at(region, pixels[i])
        k = path_key(_first_key(key, region, x, y), FURTHER + numbers[i])
        ray = generate_ray(camera, x, y, points[i, 0], points[i, 1], uniform(k, 2), uniform(k, 3))
        _begin(paths, i, k, i, ray, splits)


@kernel
def _pixel_at(region, index):
    """Place in the full frame of a region's pixel, counted row by row."""
    return region.x0 + index % region.width, region.y0 + index // region.width


@kernel
def _place(region, x, y):
    """Which even numbers a pixel's path takes: those of one pixel follow each other."""
    return morton(x, y) * region.paths + region.path


@kernel
def _first_key(key, region, x, y):
    """Key of a pixel's path."""
    first = path_key(key, y * region.row + x)
    return first if region.path == 0 else path_key(first, ROUND + region.path)


@kernel
def _begin(paths, i, key, pixel, ray, splits):
    """Write path i: along a ray of `generate_ray`, for a pixel of the tile."""
    o, d, t_near, t_far, spread, width = ray
    store3(paths.o, i, madd(o, t_near, d))
    store3(paths.d, i, d)
    store3(paths.beta, i, (1.0, 1.0, 1.0))
    paths.key[i] = key
    paths.place[i] = -1
    paths.pixel[i] = pixel
    paths.width[i] = width + spread * t_near
    paths.spread[i] = spread
    paths.t_max[i] = t_far - t_near
    paths.bare[i] = True
    paths.splits[i] = splits
    paths.unguided[i] = True
