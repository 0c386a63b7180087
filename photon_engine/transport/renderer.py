"""One scene, rendered pass by pass. A pass depends on (seed, number) alone.

Pass 0 is the first; the pilot has numbers of its own.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ..film.passes import ALL_NAMES
from ..geometry.kept import Kept
from ..issues import IssueLog, log
from ..jit import compile_seconds
from ..kernel_cache import KernelCache
from ..photons.batch import ONE_ROUGH, Deposits
from ..photons.map import PhotonMap, build_map
from ..photons.radius import radius_factor
from ..plan import Plan
from ..sampling.rng import STREAM_EYE, make_key
from ..scene.data import SceneData
from ..settings import Settings
from ..shading.textures import texture_bytes
from .clock import Clock
from .eye_batch import Tile, empty_tile
from .eye_pass import EyeRun, Maps, render_tiles
from .lamp_edges import find_images
from .near_kernels import Radius
from .photon_kernels import DROPPED, EMITTED
from .photon_pass import Rooms, run_for, trace_photons
from .photon_rules import CAUSTIC, DIFFUSE, GLOBAL
from .pilot import FINEST, Pilot, Reach, gather_mode, run_pilot
from .render_scene import RenderScene

MOST_DROPPED = 0.01  # of the light of photons: what is cut off beyond that is reported
# how far around visible points walls and rims are looked for: so many gather radii, for several points to share a look
LOOK_AROUND = 2.0
LEAST_AROUND = 8.0  # [px] at least; objects of less than half of this are overlooked
# from a narrow lobe: for equal noise 4 take 1.07 times as long on material_shelf, 1.17 on clevr_objects
MOST_LOBE_RAYS = 2
MOST_CELLS = 4.0  # a query reads up to (2 x 4 + 1)^2 rows; a plane that runs to the horizon asked for millions
PASS_NAMES = (
    "Direct", "Caustic", "Diffuse", "Emission", "Environment", "Alpha", "Depth", "Normal", "Albedo", "CausticBias",
    "DiffuseBias", "Denoising Albedo", "Denoising Normal",
)  # in the order of eye_batch.Tile; fmt: skip
GATHERED = ("caustic", "diffuse", "caustic_bias", "diffuse_bias")  # what reads the maps
# of one group, all maps together: 33 bytes each and three times that while it is sorted, hence less than 1 GB
MOST_DEPOSITS = 1 << 23
MOST_PHOTONS = 1 << 22  # of one group: 24 bytes each for the numbers that they start with, 72 while those are made


class PassPart(NamedTuple):
    """A pass, or a part of its photons."""

    i: int  # the pass
    group: int  # the part
    groups: int  # in how many parts its maps are made


class Renderer:
    """Renders passes of a scene: photons out, maps built, eye paths in."""

    def __init__(
        self,
        scene: SceneData,
        settings: Settings,
        issues: IssueLog,
        outputs: frozenset[str] = ALL_NAMES,
        kept: Kept | None = None,
    ) -> None:
        self.kept = kept or Kept()
        self.data = scene
        self.outputs = outputs
        self.settings = settings = settings.resolved()
        self.issues = issues
        self.statistics: dict = {"seconds": {}, "photons": {}, "rays": {}, "flux": {}, "map_bytes": 0, "radii": {}}
        self.rooms = Rooms()  # deposits are sorted into a map before the next are traced
        self._capped: set[str] = set()  # maps whose photons were reported to reach the cap of bounces
        self._compiled = compile_seconds()
        self._pool = ThreadPoolExecutor(settings.threads or os.cpu_count() or 1, thread_name_prefix="photon-map")

    def prepare(self, stage: Callable[[str], None], cancelled: Callable[[], bool] = lambda: False) -> None:
        """Everything that passes share. stage(text) is told what is being done; cancelled: no pass may follow."""
        start = time.perf_counter()
        self.scene = RenderScene(self.data, self.settings, self.issues, stage, self.outputs, self.kept)
        self.statistics["texture_bytes"] = texture_bytes(self.data.images)
        self._count("prepare", start)
        stage("Pilot pass")
        start = time.perf_counter()
        modes = [CAUSTIC] * self.plan.caustic_map.runs + [DIFFUSE] * self.plan.diffuse_map.runs
        self.pilot: Pilot = run_pilot(self.scene, self._pool, self.settings, modes, cancelled)
        self.scene.settle_gather(self.settings, *gather_mode(self.settings, self.pilot))
        log.info("%s", self.plan)
        self.lamp_images = find_images(self.scene, self._pool, self.settings, cancelled)
        self._count("pilot", start)
        if (groups := self._groups()) > 1:
            self.issues.info("Photons", f"a pass holds more than memory should: it is traced in {groups} parts")

    def render_pass(self, i: int, cancelled: Callable[[], bool]) -> dict[str, np.ndarray] | None:
        """Pass i = 0, 1, ...: float32 pictures (h, w, channels), bottom row first; None when cancelled.

        More photons than fit into memory are traced in groups, whose pictures of the same eye paths are averaged.
        """
        factor = radius_factor(i + 1, self.settings.alpha)
        radii = (
            self._radius(self.settings.caustic_radius * factor, self.pilot.caustic, factor),
            self._diffuse_radius(factor),
        )
        self._note_radii(i, *radii)
        groups = self._groups()
        frame = self.data.frame
        height, width = frame.y1 - frame.y0, frame.x1 - frame.x0
        picture = empty_tile(height * width, self.plan.guides.runs)
        for group in range(groups):
            maps = self._maps(PassPart(i, group, groups), radii, cancelled)
            part = picture if group == 0 else empty_tile(height * width, self.plan.guides.runs)
            if cancelled():
                return None
            self._look(self._eye_run(i, group, radii), maps, part, cancelled)
            if group:
                for name in GATHERED:
                    getattr(picture, name)[:] += getattr(part, name)
        if cancelled():
            return None
        for name in GATHERED:
            getattr(picture, name)[:] *= np.float32(1.0 / groups)
        if not self.plan.direct:
            picture.direct[:] = 0.0  # a final gather's rays found a part of it
        black = np.zeros((1, 3), np.float32)
        fields = (field if len(field) else np.broadcast_to(black, (height * width, 3)) for field in picture)
        return {name: field.reshape(height, width, -1) for name, field in zip(PASS_NAMES, fields, strict=True)}

    def _look(self, run: EyeRun, maps: Maps, picture: Tile, cancelled: Callable[[], bool]) -> None:
        """Follow the eye paths of a run into the picture, and count time and rays."""
        start = time.perf_counter()
        rays = render_tiles(self.scene, self._pool, run, maps, picture, cancelled)
        for name, seconds in run.clock.split(time.perf_counter() - start).items():
            self._add(name, seconds)
        self.statistics["rays"]["eye"] = self.statistics["rays"].get("eye", 0) + rays

    def close(self) -> None:
        """Let the threads go; say if what was compiled could not be kept for the next start."""
        self._pool.shutdown(wait=True, cancel_futures=True)
        if KernelCache.failed is not None and not KernelCache.told:
            KernelCache.told = True
            self.issues.warn(
                "kernels", f"what was compiled cannot be kept ({KernelCache.failed}): each start takes a minute longer",
                "set PHOTON_MAP_CACHE to a folder that can be written",
            )  # fmt: skip

    @property
    def plan(self) -> Plan:
        """What is done and left out; known once the scene is prepared."""
        return self.scene.plan

    def _eye_run(self, i: int, group: int, radii: tuple[Radius, Radius]) -> EyeRun:
        """What the eye pass of pass i does; after the first group, only what reads the maps."""
        plan, pixel = self.plan, self.pilot.footprint or np.inf
        around = max(LOOK_AROUND * max(r.pixels, r.least / pixel) for r in radii[: 1 if plan.gather_all else 2])
        gathers = plan.gather_all.runs or plan.gather_narrow.runs
        return EyeRun(
            make_key(self.settings.seed, i, STREAM_EYE),
            self.settings.max_bounces,
            self.settings.splits,
            plan.more_paths.count,
            self.settings.light_samples if plan.direct and group == 0 else 0,
            plan.caustic_points.runs,
            min(self.settings.light_samples, MOST_LOBE_RAYS) if plan.lobe_rays and (group == 0 or gathers) else 0,
            plan.gather_all.runs,
            plan.gather_narrow.runs,
            max(around, LEAST_AROUND) if plan.edges else 0.0,
            self.lamp_images,
            Clock(),
        )

    def _groups(self) -> int:
        """In how many parts the photons of a pass are traced: what memory holds.

        As many for both maps, since rays of a final gather that land on glossy surfaces read both, and lamps, into one
        picture. Told from the settings and the pilot alone: on another machine the picture is the same.
        """
        caustic = self.settings.caustic_photons if self.plan.caustic_map else 0
        diffuse = self.settings.diffuse_photons if self.plan.diffuse_map else 0
        # GLOBAL keeps one more
        return max(parts(caustic, self.pilot.caustic.stored), parts(diffuse, self.pilot.diffuse.stored + 1.0))

    def _maps(self, part: PassPart, radii: tuple[Radius, Radius], cancelled: Callable[[], bool]) -> Maps:
        """Trace the photons of a part of a pass and sort them into maps."""
        caustic = diffuse = first = None
        caustic_radius, diffuse_radius = radii
        if self.plan.caustic_map:
            deposits = self._trace(part, CAUSTIC, cancelled)
            caustic = self._build(deposits, caustic_radius)
        if self.plan.diffuse_map and not cancelled():
            gathering = self.plan.gathers
            deposits = self._trace(part, GLOBAL if gathering else DIFFUSE, cancelled)
            if gathering:
                later = deposits.seen >= ONE_ROUGH
                first = self._build(Deposits(*(field[~later] for field in deposits)), diffuse_radius)
                deposits = Deposits(*(field[later] for field in deposits))
            diffuse = self._build(deposits, diffuse_radius)
        self.statistics["map_bytes"] = sum(m.nbytes() for m in (caustic, diffuse, first) if m is not None)
        return Maps(caustic, diffuse, first, caustic_radius, diffuse_radius)

    def _note_radii(self, i: int, caustic: Radius, diffuse: Radius) -> None:
        """Keep the radii of a pass for the log: pass, pixels, bound [m], least [m]."""
        for name, needed, radius in (
            ("caustic", self.plan.caustic_map, caustic),
            ("diffuse", self.plan.diffuse_map, diffuse),
        ):
            if needed:
                self.statistics["radii"].setdefault(name, []).append([i, radius.pixels, radius.bound, radius.least])

    def _diffuse_radius(self, factor: float) -> Radius:
        """The radius of the diffuse map: the same wherever rays of a final gather end, if only they read it."""
        if not (self.plan.gather_all and self.pilot.diffuse.one > 0.0):
            return self._radius(self.settings.diffuse_radius * factor, self.pilot.diffuse, factor)
        radius = self.pilot.diffuse.landing * factor
        return Radius(self.settings.diffuse_radius * factor, radius, radius)

    def _radius(self, pixels: float, reach: Reach, factor: float) -> Radius:
        """The radius of a pass; toward the horizon a pixel may not reach over more than MOST_CELLS of the map."""
        radius = Radius(pixels, reach.least * factor, reach.bound * factor)
        return radius._replace(bound=min(radius.bound, MOST_CELLS * self._cell(radius)))

    def _cell(self, radius: Radius) -> float:
        """Edge of the map's cells [m]: the radius of most queries."""
        reach = radius.bound
        if self.pilot.footprint > 0.0:
            reach = min(reach, radius.pixels * self.pilot.footprint)
        return max(reach, radius.least, FINEST * self.scene.flat.radius)

    def _trace(self, part: PassPart, mode: int, cancelled: Callable[[], bool]) -> Deposits:
        """Deposits of a part of a pass in a mode, counted in the statistics."""
        start = time.perf_counter()
        name = "caustic" if mode == CAUSTIC else "diffuse"
        run = run_for(self.settings, part.i, mode, part.group, part.groups)
        deposits, tally, rays = trace_photons(self.scene, self._pool, run, cancelled, self.rooms)
        self._count(f"trace {name}", start)
        self.statistics["rays"][name] = self.statistics["rays"].get(name, 0) + rays
        self.statistics["photons"][name] = self.statistics["photons"].get(name, 0) + len(deposits.wi)
        flux = self.statistics["flux"].setdefault(name, np.zeros((4, 3)))
        flux += tally / part.groups
        self._report_cap(name, tally)
        return deposits

    def _report_cap(self, name: str, tally: np.ndarray) -> None:
        """Say, once for each map, when the photons of a pass were still carrying light at the last bounce."""
        emitted, dropped = tally[EMITTED].sum(), tally[DROPPED].sum()
        if dropped > MOST_DROPPED * emitted and name not in self._capped:
            self._capped.add(name)
            self.issues.warn(
                self.data.name,
                f"{dropped / emitted:.1%} of the light of {name} photons was still under way after "
                f"{self.settings.max_bounces} bounces and is missing",
                "raise Bounces",
            )

    def _build(self, deposits: Deposits, radius: Radius) -> PhotonMap | None:
        """A map whose cells suit queries of this radius; None without photons."""
        if len(deposits.wi) == 0:
            return None
        start = time.perf_counter()
        built = build_map(deposits, self._cell(radius))
        self._count("build", start)
        return built

    def _count(self, name: str, start: float) -> None:
        """Add the time since `start` to the seconds of a stage."""
        self._add(name, time.perf_counter() - start)

    def _add(self, name: str, more: float) -> None:
        """Add to the seconds of a stage. Compiling happens within the others and is counted beside them."""
        seconds = self.statistics["seconds"]
        seconds[name] = seconds.get(name, 0.0) + more
        seconds["compile"] = compile_seconds() - self._compiled


def parts(photons: int, stored: float) -> int:
    """In how many groups to trace photons of which each is stored so many times."""
    return max(1, -(-photons // MOST_PHOTONS), math.ceil(photons * stored / MOST_DEPOSITS))
