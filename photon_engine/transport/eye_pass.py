"""The eye pass: from pixels through specular surfaces to visible points, and the light gathered there."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import NamedTuple

import numpy as np

from ..photons.batch import head
from ..photons.map import PhotonMap
from ..scene.data import Frame
from .camera_kernels import Region, camera_rays, draw_points, further_rays
from .clearing import find_clearings
from .clipping import no_clearings
from .clock import Clock
from .direct_kernels import (
    add_unoccluded,
    attenuate_shadows,
    empty_second_paths,
    empty_shadow_rays,
    sample_lights,
    sample_lobes,
)
from .emission import multiply_radiance
from .eye_batch import EyePaths, Tile, VisiblePoints, empty_paths, empty_points, empty_tile
from .eye_kernels import eye_step
from .gather_kernels import gather
from .glints import Glints, mixture, no_glints
from .lamp_nodes import meet_lamps, multiply_nodes, see_lamps
from .lobes import ALL, NARROW, WIDE, most_lobe_rays
from .near_kernels import Radius, look_up
from .photon_kernels import Surfaces
from .render_scene import BACKGROUND_DEPTH, RenderScene
from .second_kernels import narrow_points, second_step
from .subsurface import light_below, light_below_landings

PIXELS_AT_ONCE = 8192
SAMPLES_AT_ONCE = 4  # shadow rays of a visible point that are traced together
MOST_LIT = 2  # landings in a row that are lit by rays; what enters and leaves rough glass meets two an object
LANDING_CLEARING = 2.0  # width of clearings where rays of a final gather land, in gather radii


class Maps(NamedTuple):
    """The photon maps of a pass with their radii; None: left out."""

    caustic: PhotonMap | None
    diffuse: PhotonMap | None  # every D after the first
    first: PhotonMap | None  # every first D, for final gathering
    caustic_radius: Radius
    diffuse_radius: Radius


class LampImages(NamedTuple):
    """Where lamps are seen by a part of a pixel, and further paths look; see lamp_edges.find_images."""

    edges: np.ndarray  # (n,) bool, pixels at an edge of a lamp that is seen
    further: int  # paths more that go evenly to such a pixel
    glints: Glints


def no_images(n: int) -> LampImages:
    """Nowhere among n pixels."""
    return LampImages(np.zeros(n, bool), 0, no_glints(n))


class EyeRun(NamedTuple):
    """What an eye pass does."""

    key: int  # random numbers
    max_bounces: int
    splits: int  # at how many forks an eye path goes every way
    paths: int  # from the camera through each pixel
    light_samples: int  # 0: no direct light
    caustics: bool  # whether caustics are gathered at visible points, not only behind final gathers
    lobe_rays: int  # from a narrow lobe, one from others; 0: none can meet a light or gather
    gather_all: bool  # final gather at every visible point
    gather_narrow: bool  # final gather for narrow lobes
    around: float  # how many footprints around visible points walls and rims are looked for; 0: they are not
    images: LampImages
    clock: Clock  # told where the time goes: eye, direct, edges, gather


def render_tiles(
    scene: RenderScene, pool: Executor, run: EyeRun, maps: Maps, picture: Tile, cancelled: Callable[[], bool]
) -> int:
    """Draw every pixel of the region into the picture (arrays of n pixels), the mean of its paths; out: rays traced.

    Depth is that of the first path: no surface lies at the mean depth of an edge and what is behind it.
    Threads share runs of pixels and the paths through them: a small picture has too few runs to share out evenly.
    """
    parts = [(first, k) for first in range(0, len(picture.alpha), PIXELS_AT_ONCE) for k in range(run.paths)]
    rays = 0
    for (first, k), (tile, traced) in zip(
        parts, pool.map(partial(_render_part, scene, run, maps, picture, cancelled), parts), strict=True
    ):
        rays += traced
        if k > 0:
            for total, part in zip(_averaged(_part(picture, first)), _averaged(tile), strict=True):
                total += part
    if run.paths > 1:
        for total in _averaged(picture):
            total *= np.float32(1.0 / run.paths)
    return rays


def _part(picture: Tile, first: int) -> Tile:
    """One run of a picture's pixels."""
    return Tile(*(field[first : first + PIXELS_AT_ONCE] for field in picture))


def _averaged(tile: Tile) -> list[np.ndarray]:
    """What is the mean over the paths of a pixel."""
    return [field for name, field in zip(tile._fields, tile, strict=True) if name != "depth"]


def region_of(frame: Frame, stride: int = 1, path: int = 0, paths: int = 1) -> Region:
    """The region of a frame; stride: of the pixels that are drawn; path: which of their `paths`."""
    return Region(frame.x0, frame.y0, frame.x1 - frame.x0, frame.width, stride, path, paths)


def room_for(scene: RenderScene, splits: np.ndarray) -> int:
    """How many paths may go on from a batch at most; memory that is not written costs nothing."""
    return len(splits) + int(np.count_nonzero(splits)) * (scene.most_ways - 1)


def _render_part(
    scene: RenderScene, run: EyeRun, maps: Maps, picture: Tile, cancelled: Callable[[], bool], part: tuple[int, int]
) -> tuple[Tile, int]:
    """A run of pixels by their k-th paths, the first ones in the picture itself; out: the tile, rays traced."""
    first, k = part
    tile = _part(picture, first)
    if k > 0:
        tile = empty_tile(len(tile.alpha), scene.plan.guides.runs)
    return tile, _render_paths(scene, run, maps, tile, cancelled, first, k)


def _render_paths(scene: RenderScene, run: EyeRun, maps: Maps, tile: Tile, cancelled, first: int, k: int) -> int:
    """The k-th path through each pixel of a run of them; out: rays traced."""
    n = len(tile.alpha)
    region = region_of(scene.frame, 1, k, run.paths)
    paths = empty_paths(n, scene.absorbs, scene.trails)
    paths.inside[:] = scene.camera_inside
    camera_rays(scene.camera, run.key, region, first, run.splits, paths)
    paths.unguided[:] = scene.plan.guides.runs
    tile.depth[:] = BACKGROUND_DEPTH
    light = partial(_light_points, scene, run, maps)
    rays = follow(scene, run, paths, tile, cancelled, lambda surfaces, points: light(surfaces, points, tile, 0))
    if not cancelled():
        rays += _see_images(scene, run, region, tile, first, cancelled)
    return rays


def follow(
    scene: RenderScene,
    run: EyeRun,
    paths: EyePaths,
    tile: Tile,
    cancelled: Callable[[], bool],
    light: Callable[[Surfaces, VisiblePoints], int] | None = None,
) -> int:
    """Carry eye paths to their ends; light(surfaces, points) is called for the visible points; out: rays traced."""
    rays = 0
    rules = scene.rules._replace(key=run.key)
    for bounce in range(run.max_bounces):
        if cancelled():
            break
        with run.clock("eye"):
            surfaces = scene.surfaces(paths.o, paths.d, paths.t_max, trail=paths.trail)
            rays += len(paths.key)
            if scene.absorbs:
                scene.absorb(paths.inside, surfaces, paths.beta)
            if scene.plan.subsurface and light is not None:
                rays += light_below(scene, surfaces, paths, bounce, light)
            points = empty_points(len(paths.key), scene.absorbs, scene.trails)
            paths = paths._replace(sky=scene.sky_seen(surfaces, paths.d, paths.trail))
            see_lamps(scene, surfaces, paths, tile)
            onward = empty_paths(room_for(scene, paths.splits), scene.absorbs, scene.trails)
            n, ended = eye_step(scene.laws, rules, scene.seen_lights, surfaces, paths, bounce, onward, points, tile)
        if ended and light is not None:
            rays += light(surfaces, head(points, ended))
        paths = head(onward, n)
        if not scene.plan.mirrors:
            paths = straight_on(paths)
        if len(paths.key) == 0:
            break
    return rays


def straight_on(paths: EyePaths) -> EyePaths:
    """The paths that have met nothing but see-through surfaces."""
    if paths.bare.all():
        return paths
    index = np.flatnonzero(paths.bare)
    return EyePaths(*(field[index] if len(field) else field for field in paths))


def _see_images(scene: RenderScene, run: EyeRun, region: Region, tile: Tile, first: int, cancelled) -> int:
    """Emission of the pixels of a tile in which lamps have images by further paths too; out: rays traced."""
    pixels, numbers, boxes = further_paths(run.images, first, len(tile.alpha))
    if not len(pixels):
        return 0
    points, weight = np.empty((len(pixels), 2)), np.empty(len(pixels))
    draw_points(run.key, region, pixels, numbers, boxes, points)
    even = 1.0 + run.images.further * run.images.edges[pixels]
    mixture(run.images.glints, pixels, points, even, weight)
    main = numbers == 0
    tile.emission[pixels[main] - first] *= weight[main, None]
    rays = 0
    pixels, numbers, points, weight = (field[~main] for field in (pixels, numbers, points, weight))
    for start in range(0, len(pixels), PIXELS_AT_ONCE):
        part = slice(start, start + PIXELS_AT_ONCE)
        seen = empty_tile(len(pixels[part]), False)
        paths = empty_paths(len(pixels[part]), scene.absorbs, scene.trails)
        paths.inside[:] = scene.camera_inside
        further_rays(scene.camera, run.key, region, pixels[part], numbers[part], points[part], run.splits, paths)
        paths.unguided[:] = False
        rays += follow(scene, run, paths, seen, cancelled)
        np.add.at(tile.emission, pixels[part] - first, seen.emission * weight[part, None].astype(np.float32))
    return rays


def further_paths(images: LampImages, first: int, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Paths of pixels first ... first + n - 1 with images: pixel (m,) i64, number (m,) i64, box (m, 4) f64.

    Each such pixel's path 0 is the one that is lit too; then come those all over the pixel, then those of its boxes.
    """
    glints = images.glints
    of_box = np.repeat(np.arange(n), np.diff(glints.first[first : first + n + 1]))
    boxes = slice(glints.first[first], glints.first[first + n])
    count = glints.count[boxes]
    edges = np.flatnonzero(images.edges[first : first + n])
    here = np.union1d(edges, of_box)
    pixels = np.concatenate([here, np.repeat(edges, images.further), np.repeat(of_box, count)])
    whole = np.tile([0.0, 1.0, 0.0, 1.0], (len(here) + len(edges) * images.further, 1))
    box = np.concatenate([whole, np.repeat(glints.box[boxes], count, axis=0)])
    order = np.argsort(pixels, kind="stable")
    pixels, box = pixels[order], box[order]
    numbers = np.arange(len(pixels)) - np.searchsorted(pixels, pixels)
    return pixels + first, numbers, box


def _light_points(
    scene: RenderScene, run: EyeRun, maps: Maps, surfaces: Surfaces, points: VisiblePoints, tile: Tile, landing: int
) -> int:
    """Direct, caustic and diffuse light at visible points; landing: how many rough lobes the path has met before.

    Behind a rough lobe all light is diffuse light, and only narrow lobes are lit so.
    """
    rays = 0
    lobes = NARROW if landing else ALL
    with run.clock("direct"):
        for first in range(0, run.light_samples, SAMPLES_AT_ONCE):
            samples = range(first, min(first + SAMPLES_AT_ONCE, run.light_samples))
            rays += _shadow_rays(scene, run, surfaces, points, samples, tile, lobes)
    direct_only = run.gather_all or landing > 0
    clearings = no_clearings()
    caustic = maps.caustic if run.caustics or landing else None
    if caustic is not None or (maps.diffuse is not None and not direct_only):
        most = LANDING_CLEARING * maps.caustic_radius.bound if landing else scene.flat.radius
        with run.clock("edges"):
            clearings, more = _clearings(scene, run, surfaces, points, most)
            rays += more
    with run.clock("gather"):
        if caustic is not None:
            lookup = look_up(caustic, maps.caustic_radius, clearings)
            gather(scene.laws, surfaces, points, lookup, lobes, tile.caustic, tile.caustic_bias)
        if maps.diffuse is not None and not direct_only:
            lookup = look_up(maps.diffuse, maps.diffuse_radius, clearings)
            wide = WIDE if run.gather_narrow else ALL
            gather(scene.laws, surfaces, points, lookup, wide, tile.diffuse, tile.diffuse_bias)
    if run.lobe_rays:
        with run.clock("direct"):
            rays += _second_rays(scene, run, maps, surfaces, points, tile, landing)
    return rays


def _clearings(scene: RenderScene, run: EyeRun, surfaces: Surfaces, points: VisiblePoints, most: float):
    """Clearings around visible points, at most so wide [m], and how many rays they took."""
    if run.around <= 0.0:
        return no_clearings(), 0
    return find_clearings(scene.intersector, surfaces, points, run.around, most)


def _shadow_rays(
    scene: RenderScene, run: EyeRun, surfaces: Surfaces, points: VisiblePoints, samples: range, tile: Tile, lobes: int
) -> int:
    """Shadow rays of some of the light samples from every visible point."""
    rays = empty_shadow_rays(len(points.hit) * len(samples), scene.absorbs)
    count = sample_lights(
        scene.laws, scene.lights, surfaces, points, samples.start, samples.stop, run.light_samples, run.lobe_rays,
        lobes, rays,
    )  # fmt: skip
    rays = head(rays, count)
    multiply_radiance(scene, rays.emitter, rays.place, -rays.d, rays.light)
    multiply_nodes(scene, rays)
    traced = count
    if not scene.plan.see_through:
        occluded = scene.intersector.occluded(rays.o, rays.d, rays.t_max)
        if scene.absorbs:
            scene.absorb(rays.inside, None, rays.light, rays.t_max)
        add_unoccluded(rays, occluded, count, tile.direct)
        return traced
    for _ in range(run.max_bounces):
        if not count:
            break
        between = scene.surfaces(rays.o, rays.d, rays.t_max, is_shadow=True)
        if scene.absorbs:
            scene.absorb(rays.inside, between, rays.light, rays.t_max)
        add_unoccluded(rays, between.prim >= 0, count, tile.direct)
        count = attenuate_shadows(scene.laws, between, rays, scene.casts_shadow)
        rays = head(rays, count)
        traced += count
    return traced


def _second_rays(
    scene: RenderScene, run: EyeRun, maps: Maps, surfaces: Surfaces, points: VisiblePoints, tile: Tile, landing: int
) -> int:
    """One ray from the lobes of every visible point: direct light by MIS, diffuse light by final gather."""
    paths = empty_second_paths(len(points.hit) * most_lobe_rays(run.lobe_rays), scene.absorbs, scene.trails)
    gathers = 2 if run.gather_all else 1 if run.gather_narrow else 0
    count = sample_lobes(scene.laws, surfaces, points, gathers, NARROW if landing else ALL, run.lobe_rays, paths)
    paths = head(paths, count)
    traced = 0
    for bounce in range(run.max_bounces):
        if len(paths.key) == 0:
            break
        there = scene.surfaces(paths.o, paths.d, trail=paths.trail)
        traced += len(paths.key)
        if scene.absorbs:
            scene.absorb(paths.inside, there, paths.beta)
            scene.absorb(paths.inside, there, paths.gather)
        if scene.plan.subsurface and gathers:
            below = partial(_light_landings, scene, run, maps, tile=tile, landing=landing + 1)
            traced += light_below_landings(scene, there, paths, bounce, below)
        landings = empty_points(len(paths.key), scene.absorbs, scene.trails)
        samples = max(run.light_samples, 1)
        meet_lamps(scene, there, paths, samples, tile.direct)
        count, landed = second_step(scene.laws, scene.lights, there, paths, bounce, samples, landings, tile.direct)
        if landed:
            traced += _light_landings(scene, run, maps, there, head(landings, landed), tile, landing + 1)
        paths = head(paths, count)
    return traced


def _light_landings(
    scene: RenderScene, run: EyeRun, maps: Maps, surfaces: Surfaces, landings: VisiblePoints, tile: Tile, landing: int
) -> int:
    """Diffuse light from where a final gather's legs end: photons for wide lobes, rays for narrow ones."""
    lit = landing <= MOST_LIT
    lobes = WIDE if lit else ALL
    with run.clock("edges"):
        clearings, rays = _clearings(scene, run, surfaces, landings, LANDING_CLEARING * maps.diffuse_radius.bound)
    with run.clock("gather"):
        for photons in (maps.first, maps.diffuse):
            if photons is not None:
                lookup = look_up(photons, maps.diffuse_radius, clearings)
                gather(scene.laws, surfaces, landings, lookup, lobes, tile.diffuse, tile.diffuse_bias)
    if not lit:
        return rays
    points = empty_points(len(landings.hit), scene.absorbs, scene.trails)
    count = narrow_points(surfaces, landings, landing, points)
    if not count:
        return rays
    run = run._replace(light_samples=1, lobe_rays=1)
    diffuse = tile._replace(direct=tile.diffuse, caustic=tile.diffuse, caustic_bias=tile.diffuse_bias)
    return rays + _light_points(scene, run, maps, surfaces, head(points, count), diffuse, landing)
