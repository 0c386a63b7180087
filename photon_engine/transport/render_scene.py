"""A scene made ready for rays: triangles, tree, materials, lights, camera and what photons are aimed at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ..camera.rays import build_camera
from ..film.passes import ALL_NAMES
from ..geometry.intersect import Hits
from ..geometry.kept import Kept
from ..issues import IssueLog
from ..lights.allot import one_ray_to_suns
from ..lights.rings import no_rings
from ..lights.table import SHADOW, without_lights
from ..plan import make_plan
from ..scene.data import SceneData
from ..scene.repair import with_finite_images, with_lamps_in_reach
from ..settings import Settings
from ..shading.material import refracting_materials
from ..shading.program import Program
from ..survey import survey
from .displace import displaced
from .eye_batch import EyeRules
from .materials import MaterialTable
from .media import absorb, inside_at
from .photon_kernels import Laws, Surfaces
from .standing import (
    absorbing_media,
    caster_bounds,
    glowing_triangles,
    light_table,
    material_programs,
    node_rays,
    photon_targets,
    sky_table,
)

BACKGROUND_DEPTH = 1e10  # as Cycles writes it


class RenderScene:
    """Everything that stays the same from pass to pass."""

    def __init__(
        self,
        scene: SceneData,
        settings: Settings,
        issues: IssueLog,
        stage: Callable[[str], None],
        outputs: frozenset[str] = ALL_NAMES,
        kept: Kept | None = None,
    ) -> None:
        kept = kept or Kept()
        memo = kept.memo
        stage("Preparing geometry")
        scene = with_lamps_in_reach(with_finite_images(scene, issues), issues)
        self.frame = scene.frame
        scene = displaced(scene, issues, memo)
        self.flat = kept.flatten(scene, issues, refracting_materials(scene))
        stage("Building the ray tree")
        self.intersector = kept.intersector()
        stage("Compiling materials")
        programs = material_programs(memo, scene, not settings.plan, issues)
        self.materials = MaterialTable(
            scene, self.flat, settings.specular_threshold, programs, node_rays(memo, self.flat, self.intersector)
        )
        stage("Preparing lights")
        facts = survey(scene, settings.specular_threshold, programs, reach=settings.plan)
        self.emitters = glowing_triangles(memo, scene, self.flat, self.materials)
        self.shaded_emitters = bool(self.emitters.shaded.any())
        self.sky = sky_table(memo, scene, issues)
        self.lights, self.lamp_nodes = light_table(
            memo, scene, facts.idle, self.emitters, self.sky, self.flat, issues
        )
        self.trails = any("trail" in program.needs for program in self._looked_up(programs))
        self.casts_all_shadows = bool((self.lights.flags & SHADOW).all())
        self.camera = build_camera(scene.camera, scene.frame, self.flat.origin)
        self._plan_of = partial(
            make_plan, scene, outputs=outputs, known=facts if len(self.lights.kind) else facts.unlit(self.trails)
        )
        self.plan = self._plan_of(settings=settings)
        if not self.plan.sun_rays:
            self.lights = one_ray_to_suns(self.lights, settings.light_samples)
        self.seen_lights = self.lights if self.plan.sees_lights else without_lights(self.lights)
        forks = bool(self.materials.has_sharp.any() or facts.see_through)
        self.most_ways = max(2 * self.materials.slots, 2) if forks else 1  # that can lead on from one hit
        # where caustic photons go, and diffuse ones; these are told by the pilot, which sees where the camera looks
        self.targets, self.rings = None, no_rings(self.lights)
        self.caster_boxes = self.object_boxes = None  # what new photons must meet; None: all are carried
        if self.plan.caustic_map or self.plan.diffuse_map:
            casters = caster_bounds(memo, self.flat, self.materials.has_sharp[self.flat.geometry.material])
            self.targets = photon_targets(memo, self.lights, casters) if self.plan.caustic_map else None
            if not self.plan.stray_photons:
                self.caster_boxes, self.object_boxes = casters.boxes, casters.all_boxes
        terminator = np.array([item.terminator_offset for item in scene.instances] + [0.0], np.float32)
        media = absorbing_media(memo, scene, self.flat, self.intersector, programs, self.lights, issues)
        memo.drop_unused()
        bounces = settings.diffuse_bounces
        self.laws = Laws(settings.specular_threshold, self.flat.radius, bounces, terminator, media)
        self.absorbs = len(media.sigma) > 0
        eye = scene.camera.matrix[:3, 3] - self.flat.origin
        self.camera_inside = inside_at(media, self.flat, self.intersector, eye)
        visible = np.array([item.visible_camera for item in scene.instances] + [True], bool)
        self.casts_shadow = np.array([item.visible_shadow for item in scene.instances] + [True], bool)
        holdout = np.array([item.holdout for item in scene.instances] + [False], bool)
        forward = -scene.camera.matrix[:3, 2] / np.linalg.norm(scene.camera.matrix[:3, 2])
        self.rules = EyeRules(
            scene.frame.transparent, visible, holdout, np.ascontiguousarray(forward, np.float64), eye
        )

    def _looked_up(self, programs: list[Program]) -> list[Program]:
        """All programs that paths ask: of materials, the world and lamps."""
        sky = [] if self.sky is None else [self.sky.program]
        return [*programs, *sky, *(nodes.program for nodes in self.lamp_nodes.values())]

    def settle_gather(self, settings: Settings, mode: str, why: str) -> None:
        """Plan again once it is known where diffuse light is gathered (pilot.gather_mode), if that was left open."""
        if settings.final_gather == "AUTO":
            self.plan = self._plan_of(settings=settings.replace(final_gather=mode))
            if self.plan.diffuse_map:
                self.plan = replace(self.plan, gather_all=replace(self.plan.gather_all, reason=why))

    def surfaces(self, o: np.ndarray, d: np.ndarray, t_max: np.ndarray | None = None, **path) -> Surfaces:
        """What rays hit and how it scatters; o, d : (n, 3) f32."""
        return self.surfaces_at(self.intersector.closest(o, d, t_max), d, **path)

    def surfaces_at(self, hits: Hits, d: np.ndarray, **path) -> Surfaces:
        """How what was hit by rays along d (n, 3) f32 scatters."""
        rows, row = self.materials.shade(hits, d, **path)
        scratch = np.empty((rows.kind.shape[1], 8))
        return Surfaces(self.flat.geometry, rows, row, hits.prim, hits.u, hits.v, hits.t, scratch)

    def sky_seen(self, surfaces: Surfaces, d: np.ndarray, trail: np.ndarray) -> np.ndarray:
        """Exact radiance (n, 3) f32 of a varying world where rays along d escape; (0, 3): the lights' table says it."""
        if self.sky is None or not self.plan.sees_lights:
            return np.zeros((0, 3), np.float32)
        out = np.zeros((len(d), 3), np.float32)
        free = np.flatnonzero(surfaces.prim < 0)
        if len(free):
            out[free] = self.sky.radiance_at(d[free], trail[free] if len(trail) else None)
        return out

    def absorb(self, inside: np.ndarray, surfaces: Surfaces | None, colors: np.ndarray, t_max=np.inf) -> np.ndarray:
        """Take from colours (n, 3) what media absorb up to the hits, else to t_max [m]; out: (3,) all that is lost."""
        far = np.broadcast_to(np.float32(t_max), inside.shape)
        distance = far if surfaces is None else np.where(surfaces.prim >= 0, surfaces.t, far)
        lost = np.zeros(3)
        absorb(self.laws.media, inside, np.ascontiguousarray(distance, np.float32), colors, lost)
        return lost
