"""A small pass (seed, 0) that sees how large pixels are in the scene and how dense photons lie.

It bounds the first gather radius on both sides. Never larger than what the photons of a pass need, so that a picture of
few pixels is not blurred over half the scene; never so small that hardly a photon is expected in it, so that a
picture of a few micrometres is not black but for one pixel in thousands. Both bounds shrink from pass to pass as the
radius does, so the mean still converges, and the bias that they leave is estimated like any other.
What it learns depends on the seed alone, so passes stay memoryless.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

from ..issues import log
from ..lights.rings import build_rings
from ..photons.batch import head
from ..photons.radius import neighbour_radius
from ..sampling.rng import STREAM_PILOT, make_key
from ..settings import Settings
from .camera_kernels import camera_rays
from .eye_batch import empty_paths, empty_points, empty_tile
from .eye_kernels import eye_step
from .eye_pass import region_of
from .photon_pass import PhotonRun, trace_photons
from .photon_rules import CAUSTIC, DIFFUSE
from .render_scene import RenderScene
from .subsurface import seen_below

PILOT_PHOTONS = 16384
PILOT_PIXELS = 4096
PROBES = 1000
# photons within the bound, as many as a good estimate needs: few where light is focused, many where it is smooth
CAUSTIC_NEIGHBOURS = 24
DIFFUSE_NEIGHBOURS = 60
# expected within the least radius. The relMSE of a room's diffuse light after 32 passes was 1.3 with 1 photon, 0.15
# with 7, 0.025 with 115; focused light is sharper, and a denoiser wants noise that differs from pixel to pixel
CAUSTIC_LEAST = 1.0
DIFFUSE_LEAST = 8.0
# where rays of a final gather end, each of them an average already. On diffuse_room 3 and 8 were as good denoised, 8 a
# quarter better raw, 60 twice worse and four times slower
LANDING_NEIGHBOURS = 8.0
FULL = 100_000  # photons; passes with fewer are meant to add up, and their least radius is that of so many
NEAREST = 8  # photons of the pilot that a distance is measured to
FINEST = 1e-6  # of the scene's size: positions in single precision are no finer


class Reach(NamedTuple):
    """What the photons of one map allow."""

    least: float = 0.0  # radius [m] of the first pass, whatever the pixels; 0: not known
    bound: float = 0.0  # at most [m]; 0: no such photons are traced
    stored: float = 0.0  # photons in the map for each one emitted
    one: float = 0.0  # radius that holds one photon of a pass, where most are [m]; 0: not known

    @property
    def landing(self) -> float:
        """First radius [m] where a ray of a final gather ends."""
        return min(self.one * LANDING_NEIGHBOURS**0.5, self.bound)


class Pilot(NamedTuple):
    """Bounds on the first radius, and the scale of pixels."""

    footprint: float  # radius of a pixel that three quarters of visible points stay below [m]; 0: none, or nobody asks
    caustic: Reach
    diffuse: Reach


def run_pilot(
    scene: RenderScene, pool: Executor, settings: Settings, modes: list[int], cancelled: Callable[[], bool]
) -> Pilot:
    """Trace a few eye paths and a few photons of each mode; when cancelled, what it returns means nothing.

    What the eye paths see tells where `scene` sends its diffuse photons.
    """
    reaches = {CAUSTIC: Reach(), DIFFUSE: Reach()}
    seen = _look(scene, settings, cancelled) if modes else Seen(np.zeros(0), np.zeros((0, 3)))  # nobody gathers
    if DIFFUSE in modes:
        scene.rings = build_rings(scene.lights, seen.position)
        if widths := [f"{radius:.3g}" for radius in scene.rings.radius]:
            log.info("Photons of suns and sky go to disks of %s m radius around what is seen", ", ".join(widths))
    for mode in modes:
        key = make_key(settings.seed, mode, STREAM_PILOT)
        deposits, _, _ = trace_photons(
            scene, pool, PhotonRun(mode, PILOT_PHOTONS, key, settings.max_bounces), cancelled
        )
        total = settings.caustic_photons if mode == CAUSTIC else settings.diffuse_photons
        wanted = (CAUSTIC_LEAST, CAUSTIC_NEIGHBOURS) if mode == CAUSTIC else (DIFFUSE_LEAST, DIFFUSE_NEIGHBOURS)
        reaches[mode] = _reach(deposits.position, wanted, total, scene.flat.radius)
    footprint = float(np.quantile(seen.footprint, 0.75)) if len(seen.footprint) else 0.0
    return Pilot(footprint, reaches[CAUSTIC], reaches[DIFFUSE])


def _reach(photons: np.ndarray, wanted: tuple[float, float], total: int, radius: float) -> Reach:
    """What the photons (n, 3) of the pilot tell of a pass of `total`; radius: of the scene [m].

    wanted : how many to expect within the least radius, and within the bound

    The density is measured around photons, since most of a picture has no caustic. With N times more photons the same
    number lies within 1 / sqrt(N) of the distance. So few that no density can be told (a light so far off that hardly
    one arrives) leave it to the pixels how wide to gather.
    """
    n = len(photons)
    if n < 2:
        return Reach(0.0, radius, n / PILOT_PHOTONS)
    k = min(NEAREST, n)
    probes = photons[:: max(1, n // PROBES)]
    near = float(np.median(neighbour_radius(photons, probes, k + 1 if n > k else k)))
    one = near * np.sqrt(PILOT_PHOTONS / (k * total))  # radius that holds one photon of a pass
    # where most of them are: one object far away does not make the others coarser
    finest = FINEST * min(float(np.median(np.abs(photons).max(axis=1))) or radius, radius)
    bound = max(one * np.sqrt(wanted[1]), finest)
    least = one * np.sqrt(wanted[0] * min(total / FULL, 1.0)) if n > k else 0.0
    return Reach(min(max(least, finest), bound), bound, n / PILOT_PHOTONS, max(one, finest) if n > k else 0.0)


def gather_mode(settings: Settings, pilot: Pilot) -> tuple[str, str]:
    """Final Gather decided, where it was left to the engine, and why.

    A denoiser removes what differs from pixel to pixel. A diffuse map with many photons in every pixel has such noise,
    and little of it; with fewer its noise is blotches, which stay, while rays of a final gather trade them for noise
    of single pixels. Denoised relMSE at equal time, All against Glossy: 0.0010 and 0.0020 on diffuse_room (8 photons
    within 4 half pixels of 128 x 128), 0.0045 and 0.0049 on material_shelf (2.6), 0.0063 and 0.0068 on pool, 0.0011 and
    0.0007 on cornell_caustics (0.5); but 0.0023 and 0.0020 on wine_glass, whose diffuse light is weak and smooth.
    """
    if settings.final_gather != "AUTO":
        return settings.final_gather, f"Final Gather is {settings.final_gather.capitalize()}"
    if not (pilot.diffuse.one > 0.0 and pilot.footprint > 0.0):
        return "GLOSSY", "too few photons or pixels were met to tell how dense they lie"
    pixels = pilot.diffuse.one * LANDING_NEIGHBOURS**0.5 / pilot.footprint
    told = f"the picture is denoised, and {LANDING_NEIGHBOURS:.0f} diffuse photons lie within {pixels:.2g} half pixels"
    return ("ALL" if pixels > 1.0 else "GLOSSY"), told


class Seen(NamedTuple):
    """Visible points of a few pixels."""

    footprint: np.ndarray  # (n,) radius of a pixel there [m]
    position: np.ndarray  # (n, 3) [m]


def _look(scene: RenderScene, settings: Settings, cancelled: Callable[[], bool]) -> Seen:
    """What a few eye paths see."""
    frame = scene.frame
    pixels = (frame.x1 - frame.x0) * (frame.y1 - frame.y0)
    count = min(pixels, PILOT_PIXELS)
    paths = empty_paths(count, scene.absorbs, scene.trails)
    paths.inside[:] = scene.camera_inside
    tile = empty_tile(count, False)
    footprints, positions = [np.zeros(0, np.float32)], [np.zeros((0, 3), np.float32)]
    # an odd stride walks through all columns
    stride = max(1, pixels // count - 1) | 1
    key = make_key(settings.seed, 0, STREAM_PILOT)
    camera_rays(scene.camera, key, region_of(frame, stride), 0, 0, paths)
    paths.unguided[:] = False
    for bounce in range(settings.max_bounces):
        surfaces = scene.surfaces(paths.o, paths.d, paths.t_max, trail=paths.trail)
        points = empty_points(len(paths.key), scene.absorbs, scene.trails)
        onward = empty_paths(len(paths.key), scene.absorbs, scene.trails)
        if scene.plan.subsurface:
            footprint, position = seen_below(scene, surfaces, paths, bounce)
            footprints.append(footprint)
            positions.append(position)
        n, ended = eye_step(scene.laws, scene.rules, scene.seen_lights, surfaces, paths, bounce, onward, points, tile)
        if ended:
            hit = points.hit[:ended]
            footprints.append(points.footprint[:ended].copy())
            positions.append(paths.o[hit] + surfaces.t[hit, None] * paths.d[hit])
        paths = head(onward, n)
        if n == 0 or cancelled():
            break
    return Seen(np.concatenate(footprints), np.concatenate(positions))
