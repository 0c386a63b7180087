"""A scene made ready for rays: triangles, tree, materials, lights, camera and what photons are aimed at."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..bsdf.layout import EMISSION
from ..camera.rays import build_camera
from ..film.passes import ALL_NAMES
from ..geometry.flatten import bounding_sphere
from ..geometry.intersect import Hits
from ..geometry.kept import Kept
from ..issues import IssueLog
from ..lights.sky import build_sky
from ..lights.table import Emitters, build_lights
from ..lights.targets import build_targets
from ..plan import make_plan
from ..scene.data import SceneData
from ..settings import Settings
from ..survey import survey
from .displace import displaced
from .eye_kernels import EyeRules
from .materials import MaterialTable
from .media import absorb, find_media, inside_at, locate_lights
from .photon_kernels import Laws, Surfaces

BACKGROUND_DEPTH = 1e10  # as Cycles writes it
MOST_EMITTERS_AT_ONCE = 1 << 16


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
        self.frame = scene.frame
        scene = displaced(scene, issues)
        self.flat = kept.flatten(scene, issues)
        stage("Building the ray tree")
        self.intersector = kept.intersector()
        stage("Compiling materials")
        self.materials = MaterialTable(scene, self.flat, settings.specular_threshold, issues)
        stage("Preparing lights")
        self.emitters = self._emitters(scene)
        self.sky = build_sky(scene.world, scene.images, issues)
        self.lights = build_lights(
            scene,
            self.emitters,
            len(self.flat.geometry.triangles),
            self.flat.center,
            self.flat.radius,
            self.flat.origin,
            issues,
            None if self.sky is None else self.sky.map,
        )
        self.camera = build_camera(scene.camera, scene.frame, self.flat.origin)
        facts = survey(scene, settings.specular_threshold, self.materials.programs)
        self.plan = make_plan(scene, settings, outputs, facts if len(self.lights.kind) else facts.unlit())
        self.seen_lights = self.lights if self.plan.sees_lights else self.lights._replace(kind=self.lights.kind[:0])
        self.targets = self._targets() if self.plan.caustic_map else None
        terminator = np.array([item.terminator_offset for item in scene.instances] + [0.0], np.float32)
        sigma = [program.absorption for program in self.materials.programs]
        media = find_media(scene, self.flat, sigma, issues)
        media = locate_lights(media, self.flat, self.intersector, self.lights)
        bounces = settings.diffuse_bounces
        self.laws = Laws(settings.specular_threshold, self.flat.radius, bounces, terminator, media)
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
        hits = self.intersector.closest(o, d, t_max)
        rows, row = self.materials.shade(hits, d, **path)
        scratch = np.empty((rows.kind.shape[1], 8))
        return Surfaces(self.flat.geometry, rows, row, hits.prim, hits.u, hits.v, hits.t, scratch)

    def sky_seen(self, surfaces: Surfaces, d: np.ndarray, is_camera: bool) -> np.ndarray:
        """Exact radiance (n, 3) f32 of a varying world where rays along d escape; (0, 3): the lights' table says it."""
        if self.sky is None or not self.plan.sees_lights:
            return np.zeros((0, 3), np.float32)
        out = np.zeros((len(d), 3), np.float32)
        free = np.flatnonzero(surfaces.prim < 0)
        if len(free):
            out[free] = self.sky.radiance_at(d[free], is_camera)
        return out

    def absorb(self, inside: np.ndarray, surfaces: Surfaces | None, colors: np.ndarray, t_max=np.inf) -> np.ndarray:
        """Take from colours (n, 3) what media absorb up to the hits, else to t_max [m]; out: (3,) all that is lost."""
        far = np.broadcast_to(np.float32(t_max), inside.shape)
        distance = far if surfaces is None else np.where(surfaces.prim >= 0, surfaces.t, far)
        lost = np.zeros(3)
        absorb(self.laws.media, inside, np.ascontiguousarray(distance, np.float32), colors, lost)
        return lost

    def _emitters(self, scene: SceneData) -> Emitters:
        """Triangles whose material radiates, with their mean radiance."""
        geometry, table = self.flat.geometry, self.materials
        tri = (
            np.flatnonzero(table.emits[geometry.material]).astype(np.int32)
            if len(geometry.material)
            else np.zeros(0, np.int32)
        )
        radiance = np.zeros((len(tri), 3), np.float32)
        material = geometry.material[tri]
        for m in np.unique(material):
            index = np.flatnonzero(material == m)
            if m in table.varying:
                for part in np.array_split(index, max(1, len(index) // MOST_EMITTERS_AT_ONCE)):
                    radiance[part] = self._mean_radiance(m, tri[part])
            else:
                radiance[index] = emission_of(table.fixed.kind[m : m + 1], table.fixed.params[m : m + 1])
        lit = (radiance != 0.0).any(axis=1)
        tri, radiance = tri[lit], radiance[lit]
        corner = geometry.positions[geometry.triangles[tri]]
        return Emitters(tri, corner[:, 0], corner[:, 1], corner[:, 2], radiance)

    def _mean_radiance(self, m: int, tri: np.ndarray) -> np.ndarray:
        """Radiance (n, 3) of triangles of a varying material: mean of four points, seen along the normal."""
        total = np.zeros((len(tri), 3))
        samples = ((1 / 3, 1 / 3), (0.6, 0.2), (0.2, 0.6), (0.2, 0.2))
        geometry = self.flat.geometry
        corner = geometry.positions[geometry.triangles[tri]].astype(np.float64)
        ng = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        ng /= np.maximum(np.linalg.norm(ng, axis=1, keepdims=True), 1e-300)
        for u, v in samples:
            ones = np.ones(len(tri), np.float32)
            rows = self.materials.rows_at(
                m, Hits(tri, ones * np.float32(u), ones * np.float32(v), ones), ng.astype(np.float32)
            )
            total += emission_of(rows.kind, rows.params)
        return total / len(samples)

    def _targets(self):
        """Bounding spheres of the instances that have a specular surface; of all instances when none has one."""
        geometry = self.flat.geometry
        sharp = self.materials.has_sharp[geometry.material]
        if not sharp.any():
            sharp = np.ones(len(geometry.material), bool)
        centers, radii = [], []
        for i in np.unique(geometry.instance[sharp]):
            first, last = self.flat.first_triangle[i], self.flat.first_triangle[i + 1]
            inside = geometry.triangles[first:last][sharp[first:last]]
            center, radius = bounding_sphere(geometry.positions[inside.ravel()])
            centers.append(center)
            radii.append(radius)
        return build_targets(self.lights, np.array(centers), np.array(radii))


def emission_of(kind: np.ndarray, params: np.ndarray) -> np.ndarray:
    """Radiance (n, 3) of rows of lobes without regard to layers above."""
    return (params[:, :, :3] * (kind == EMISSION)[:, :, None]).sum(axis=1)
