"""One scene, rendered pass by pass. A pass depends on (seed, number) alone.

Pass 0 is the first; the pilot has numbers of its own.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..film.passes import ALL_NAMES
from ..geometry.kept import Kept
from ..issues import IssueLog, log
from ..jit import compile_seconds
from ..photons.batch import Deposits
from ..photons.map import PhotonMap, build_map
from ..photons.radius import radius_factor
from ..plan import Plan
from ..sampling.rng import STREAM_EYE, make_key
from ..scene.data import SceneData
from ..settings import Settings
from ..shading.textures import texture_bytes
from .clock import Clock
from .eye_batch import empty_tile
from .eye_pass import EyeRun, Maps, render_tiles
from .gather_kernels import Radius
from .photon_kernels import DROPPED, EMITTED
from .photon_pass import run_for, trace_photons
from .photon_rules import CAUSTIC, DIFFUSE, GLOBAL
from .pilot import Pilot, run_pilot
from .render_scene import RenderScene

MOST_DROPPED = 0.01  # of the light of photons: what is cut off beyond that is reported
# how far around visible points walls and rims are looked for: so many gather radii, for several points to share a look
LOOK_AROUND = 2.0
LEAST_AROUND = 8.0  # [px] at least; objects of less than half of this are overlooked
MOST_CELLS = 4.0  # a query reads up to (2 x 4 + 1)^2 rows; a plane that runs to the horizon asked for millions
PASS_NAMES = (
    "Direct", "Caustic", "Diffuse", "Emission", "Environment", "Alpha", "Depth", "Normal", "Albedo", "CausticBias",
    "DiffuseBias", "Denoising Albedo", "Denoising Normal",
)  # in the order of eye_batch.Tile; fmt: skip


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
        self._capped: set[str] = set()  # maps whose photons were reported to reach the cap of bounces
        self._compiled = compile_seconds()
        self._pool = ThreadPoolExecutor(settings.threads or os.cpu_count() or 1, thread_name_prefix="photon-map")

    def prepare(self, stage: Callable[[str], None], cancelled: Callable[[], bool] = lambda: False) -> None:
        """Everything that passes share. stage(text) is told what is being done; cancelled: no pass may follow."""
        start = time.perf_counter()
        self.scene = RenderScene(self.data, self.settings, self.issues, stage, self.outputs, self.kept)
        log.info("%s", self.plan)
        self.statistics["texture_bytes"] = texture_bytes(self.data.images)
        self._count("prepare", start)
        stage("Pilot pass")
        start = time.perf_counter()
        modes = [CAUSTIC] * self.plan.caustic_map.runs + [DIFFUSE] * self.plan.diffuse_map.runs
        self.pilot: Pilot = run_pilot(self.scene, self._pool, self.settings, modes, cancelled)
        self._count("pilot", start)

    def render_pass(self, i: int, cancelled: Callable[[], bool]) -> dict[str, np.ndarray] | None:
        """Pass i = 0, 1, ...: float32 pictures (h, w, channels), bottom row first; None when cancelled."""
        factor = radius_factor(i + 1, self.settings.alpha)
        caustic_radius = self._radius(self.settings.caustic_radius * factor, self.pilot.caustic_bound * factor)
        diffuse_radius = self._radius(self.settings.diffuse_radius * factor, self.pilot.diffuse_bound * factor)
        self._note_radii(i, caustic_radius, diffuse_radius)
        maps = self._maps(i, caustic_radius, diffuse_radius, cancelled)
        if cancelled():
            return None
        start = time.perf_counter()
        frame = self.data.frame
        height, width = frame.y1 - frame.y0, frame.x1 - frame.x0
        picture = empty_tile(height * width, self.plan.guides.runs)
        run = self._eye_run(i, caustic_radius, diffuse_radius)
        rays = render_tiles(self.scene, self._pool, run, maps, picture, cancelled)
        for name, seconds in run.clock.split(time.perf_counter() - start).items():
            self._add(name, seconds)
        self.statistics["rays"]["eye"] = self.statistics["rays"].get("eye", 0) + rays
        if cancelled():
            return None
        if not self.plan.direct:
            picture.direct[:] = 0.0  # a final gather's rays found a part of it
        black = np.zeros((1, 3), np.float32)
        fields = (field if len(field) else np.broadcast_to(black, (height * width, 3)) for field in picture)
        return {name: field.reshape(height, width, -1) for name, field in zip(PASS_NAMES, fields, strict=True)}

    def close(self) -> None:
        """Let the threads go."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    @property
    def plan(self) -> Plan:
        """What is done and left out; known once the scene is prepared."""
        return self.scene.plan

    def _eye_run(self, i: int, caustic_radius: Radius, diffuse_radius: Radius) -> EyeRun:
        """What the eye pass of pass i does."""
        plan = self.plan
        around = max(LOOK_AROUND * max(caustic_radius.pixels, diffuse_radius.pixels), LEAST_AROUND)
        return EyeRun(
            make_key(self.settings.seed, i, STREAM_EYE),
            self.settings.max_bounces,
            self.settings.splits,
            self.settings.light_samples if plan.direct else 0,
            plan.caustic_points.runs,
            plan.lobe_rays.runs,
            plan.gather_all.runs,
            plan.gather_narrow.runs,
            around if plan.edges else 0.0,
            Clock(),
        )

    def _maps(self, i: int, caustic_radius: Radius, diffuse_radius: Radius, cancelled: Callable[[], bool]) -> Maps:
        """Trace the photons of pass i and sort them into maps."""
        caustic = diffuse = first = None
        if self.plan.caustic_map:
            deposits = self._trace(i, CAUSTIC, cancelled)
            caustic = self._build(deposits, caustic_radius)
        if self.plan.diffuse_map and not cancelled():
            gathering = self.plan.gathers
            deposits = self._trace(i, GLOBAL if gathering else DIFFUSE, cancelled)
            if gathering:
                later = deposits.seen > 1
                first = self._build(Deposits(*(field[~later] for field in deposits)), diffuse_radius)
                deposits = Deposits(*(field[later] for field in deposits))
            diffuse = self._build(deposits, diffuse_radius)
        self.statistics["map_bytes"] = sum(m.nbytes() for m in (caustic, diffuse, first) if m is not None)
        return Maps(caustic, diffuse, first, caustic_radius, diffuse_radius)

    def _note_radii(self, i: int, caustic: Radius, diffuse: Radius) -> None:
        """Keep the radii of a pass for the log: pass, pixels, bound [m]."""
        for name, needed, radius in (
            ("caustic", self.plan.caustic_map, caustic),
            ("diffuse", self.plan.diffuse_map, diffuse),
        ):
            if needed:
                self.statistics["radii"].setdefault(name, []).append([i, radius.pixels, radius.bound])

    def _radius(self, pixels: float, bound: float) -> Radius:
        """The radius of a pass; toward the horizon a pixel may not reach over more than MOST_CELLS of the map."""
        return Radius(pixels, min(bound, MOST_CELLS * self._cell(Radius(pixels, bound))))

    def _cell(self, radius: Radius) -> float:
        """Edge of the map's cells [m]: the radius of most queries."""
        reach = radius.bound
        if self.pilot.footprint > 0.0:
            reach = min(reach, radius.pixels * self.pilot.footprint)
        return max(reach, 1e-6 * self.scene.flat.radius)

    def _trace(self, i: int, mode: int, cancelled: Callable[[], bool]) -> Deposits:
        """Deposits of pass i in a mode, counted in the statistics."""
        start = time.perf_counter()
        name = "caustic" if mode == CAUSTIC else "diffuse"
        run = run_for(self.settings, i, mode)
        deposits, tally, rays = trace_photons(self.scene, self._pool, run, cancelled)
        self._count(f"trace {name}", start)
        self.statistics["rays"][name] = self.statistics["rays"].get(name, 0) + rays
        self.statistics["photons"][name] = self.statistics["photons"].get(name, 0) + len(deposits.wi)
        flux = self.statistics["flux"].setdefault(name, np.zeros((4, 3)))
        flux += tally
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
