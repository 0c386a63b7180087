"""A scene made ready for rays: triangles, tree, materials, lights, camera and what photons are aimed at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..camera.rays import build_camera
from ..film.passes import ALL_NAMES
from ..geometry.flatten import bounding_sphere
from ..geometry.intersect import Hits
from ..geometry.kept import Kept
from ..issues import IssueLog
from ..lights.allot import one_ray_to_suns
from ..lights.sky import build_sky
from ..lights.table import SHADOW, build_lights, without_lights
from ..lights.targets import build_targets
from ..plan import make_plan
from ..scene.data import SceneData
from ..scene.repair import with_finite_images, with_lamps_in_reach
from ..settings import Settings
from ..shading.material import refracting_materials
from ..survey import survey
from .cull import boxes_of
from .displace import displaced
from .emission import find_emitters
from .eye_batch import EyeRules
from .materials import MaterialTable
from .media import absorb, find_media, inside_at, locate_lights
from .photon_kernels import Laws, Surfaces

BACKGROUND_DEPTH = 1e10  # as Cycles writes it
SMALLEST = 1e-9  # of the scene's radius: what photons are aimed at is no smaller, positions are not that fine


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
        stage("Preparing geometry")
        scene = with_lamps_in_reach(with_finite_images(scene, issues), issues)
        self.frame = scene.frame
        scene = displaced(scene, issues)
        self.flat = kept.flatten(scene, issues, refracting_materials(scene))
        stage("Building the ray tree")
        self.intersector = kept.intersector()
        stage("Compiling materials")
        self.materials = MaterialTable(scene, self.flat, settings.specular_threshold, issues)
        stage("Preparing lights")
        facts = survey(scene, settings.specular_threshold, self.materials.programs, reach=settings.plan)
        self.emitters = find_emitters(self.flat, self.materials)
        self.shaded_emitters = bool(self.emitters.shaded.any())
        self.sky = build_sky(scene.world, scene.images, issues)
        self.lights = build_lights(
            replace(scene, lights=[light for i, light in enumerate(scene.lights) if i not in facts.idle]),
            self.emitters,
            len(self.flat.geometry.triangles),
            self.flat.center,
            self.flat.radius,
            self.flat.origin,
            issues,
            None if self.sky is None else self.sky.map,
        )
        programs = [*self.materials.programs, *([] if self.sky is None else [self.sky.program])]
        self.trails = any("trail" in program.needs for program in programs)
        self.casts_all_shadows = bool((self.lights.flags & SHADOW).all())
        self.camera = build_camera(scene.camera, scene.frame, self.flat.origin)
        self.plan = make_plan(scene, settings, outputs, facts if len(self.lights.kind) else facts.unlit(self.trails))
        if not self.plan.sun_rays:
            self.lights = one_ray_to_suns(self.lights, settings.light_samples)
        self.seen_lights = self.lights if self.plan.sees_lights else without_lights(self.lights)
        forks = bool(self.materials.has_sharp.any() or facts.see_through)
        self.most_ways = max(2 * self.materials.slots, 2) if forks else 1  # that can lead on from one hit
        self.targets = self._targets() if self.plan.caustic_map else None
        geometry, sharp = self.flat.geometry, self.materials.has_sharp[self.flat.geometry.material]
        self.caster_boxes = self.object_boxes = None  # what new photons must meet; None: all are carried
        if not self.plan.stray_photons:
            self.caster_boxes = boxes_of(geometry.positions, geometry.triangles[sharp], geometry.instance[sharp])
            self.object_boxes = boxes_of(geometry.positions, geometry.triangles, geometry.instance)
        terminator = np.array([item.terminator_offset for item in scene.instances] + [0.0], np.float32)
        sigma = [program.absorption for program in self.materials.programs]
        media = find_media(scene, self.flat, sigma, issues)
        media = locate_lights(media, self.flat, self.intersector, self.lights)
        bounces = settings.diffuse_bounces
        self.laws = Laws(settings.specular_threshold, self.flat.reach, bounces, terminator, media)
        self.absorbs = len(media.sigma) > 0
        eye = scene.camera.matrix[:3, 3] - self.flat.origin
        self.camera_inside = inside_at(media, self.flat, self.intersector, eye)
        visible = np.array([item.visible_camera for item in scene.instances] + [True], bool)
        self.casts_shadow = np.array([item.visible_shadow for item in scene.instances] + [True], bool)
        holdout = np.array([item.holdout for item in scene.instances] + [False], bool)
        forward = -scene.camera.matrix[:3, 2] / np.linalg.norm(scene.camera.matrix[:3, 2])
        eye = scene.camera.matrix[:3, 3] - self.flat.origin
        self.rules = EyeRules(
            scene.frame.transparent, visible, holdout, np.ascontiguousarray(forward, np.float64), eye
        )

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

    def _targets(self):
        """Bounding spheres of the instances that have a specular surface; of all instances when none has one."""
        geometry, least = self.flat.geometry, SMALLEST * self.flat.radius
        sharp = self.materials.has_sharp[geometry.material]
        if not sharp.any():
            sharp = np.ones(len(geometry.material), bool)
        centers, radii = [], []
        for i in np.unique(geometry.instance[sharp]):
            first, last = self.flat.first_triangle[i], self.flat.first_triangle[i + 1]
            inside = geometry.triangles[first:last][sharp[first:last]]
            center, radius = bounding_sphere(geometry.positions[inside.ravel()])
            centers.append(center)
            radii.append(max(radius, least))
        return build_targets(self.lights, np.array(centers), np.array(radii))
