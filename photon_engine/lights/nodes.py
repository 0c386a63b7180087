"""What a lamp's nodes make of its light where that varies over the lamp, with direction or with distance.

Kernels take such a lamp as plain; every sample of it is multiplied afterwards by what its nodes give for the point on
the lamp, the direction and the distance, all found from where the light arrives. The coordinates are Cycles'.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..issues import IssueLog
from ..sampling.sobol import sobol
from ..scene.data import Camera, Image, Instance, Light
from ..shading.points import ObjectTable, ShadePoints, sky_points
from ..shading.program import Program, compile_graph
from ..shading.trail import DEPTH, FROM_LIGHT

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
FAR = float(np.finfo(np.float32).max)  # how far away a sun is, as in Cycles
AT_ONCE = 1 << 16
TRIED = 1024  # samples that tell how strong a lamp is in the mean
LEAST = 0.01  # of its strongest sample: a lamp that is dark at all others is not taken for dark


@dataclass
class LampNodes:
    """A lamp whose nodes are evaluated at each sample."""

    light: Light
    program: Program
    camera: Camera = field(default_factory=Camera)
    origin: np.ndarray = field(default_factory=lambda: np.zeros(3))  # subtracted from positions [m]
    share: float = 1.0  # about the mean of what the nodes give; the light table's strength is multiplied by it

    def arriving(self, p: np.ndarray, wi: np.ndarray, trail: np.ndarray | None = None) -> np.ndarray:
        """What light is multiplied by that arrives at points p (n, 3), recentred, from unit directions wi (n, 3).

        trail : (n,) i64 of the eye paths that meet the lamp; None: light is sampled. Out (n, 3) f32, divided by
        `share`; black where the nodes give no number.
        """
        out = np.empty((len(p), 3), np.float32)
        for first in range(0, len(p), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            looking = None if trail is None else trail[part]
            place, normal, distance = on_lamp(self.light, p[part] + self.origin, np.asarray(wi[part], np.float64))
            points = lamp_points(self.light, place, normal, -wi[part], distance, looking)
            points.p, points.origin = (place - self.origin).astype(np.float32), self.origin
            self._add_camera(points)
            out[part] = emission_of(self.program, points)
        return out / np.float32(self.share)

    def _add_camera(self, points: ShadePoints) -> None:
        if "camera" in self.program.needs:
            points.camera = points.to_space(self.camera.from_world())
            points.window = (*self.camera.window, float(self.camera.kind == "PERSP"))


def emission_of(program: Program, points: ShadePoints) -> np.ndarray:
    """Emission (n, 3) f32, not below 0; black where it is no number."""
    with np.errstate(over="ignore", invalid="ignore"):
        value = np.broadcast_to(program.emission(points), points.p.shape)
    return np.where(np.isfinite(value), np.maximum(value, 0.0), 0.0).astype(np.float32)


def make_lamp_nodes(
    light: Light, images: list[Image], camera: Camera, origin: np.ndarray, sphere: tuple[np.ndarray, float]
) -> LampNodes:
    """The nodes of a lamp that has some; sphere : centre (3,) and radius [m] of what it lights, recentred."""
    assert light.graph is not None
    program = compile_graph(light.graph, light.name, images, IssueLog())  # said when the scene was read
    nodes = LampNodes(light, program, camera, np.asarray(origin, np.float64))
    p, wi = lit_points(light, np.asarray(sphere[0]) + nodes.origin, sphere[1])
    values = nodes.arriving(p - nodes.origin, wi) @ LUMINANCE
    mean = max(float(values.mean()), LEAST * float(values.max()))
    nodes.share = mean if mean > 0.0 else 1.0
    return nodes


def shine_direction(light: Light) -> np.ndarray:
    """The unit direction (3,) of a lamp's local -Z."""
    axis = -np.asarray(light.matrix, np.float64)[:3, 2]
    return axis / max(float(np.linalg.norm(axis)), 1e-30)


def lit_points(light: Light, center: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in the world that a lamp lights, about as far away as what is in a sphere, and directions to it."""
    u = sobol(TRIED, 5) * 2.0**-32 + 0.5 / TRIED
    matrix = np.asarray(light.matrix, np.float64)
    place, axis = matrix[:3, 3], shine_direction(light)
    reach = float(np.linalg.norm(place - center))
    low, high = max(reach - radius, 0.05 * radius), reach + radius
    width = {"POINT": 2.0 * math.pi, "SPOT": light.spot_size, "SUN": light.angle, "AREA": light.spread}[light.kind]
    h = (1.0 - math.cos(0.5 * (width if light.kind == "POINT" else min(width, math.pi)))) * u[:, 0]
    sine, phi = np.sqrt(np.maximum(h * (2.0 - h), 0.0)), 2.0 * math.pi * u[:, 1]
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    d = (sine * np.cos(phi))[:, None] * side + (sine * np.sin(phi))[:, None] * np.cross(axis, side)
    d += (1.0 - h)[:, None] * axis
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    start = np.broadcast_to(place, d.shape)
    if light.kind == "AREA":
        spread = (u[:, 2:4] - 0.5) * (0.7 if light.shape in ("DISK", "ELLIPSE") else 1.0)
        start = start + spread[:, :1] * matrix[:3, 0] * light.size[0] + spread[:, 1:] * matrix[:3, 1] * light.size[1]
    return start + (low + (high - low) * u[:, 4:]) * d, -d


def on_lamp(light: Light, p: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where rays from world points p (n, 3) along wi (n, 3) meet a lamp: place, normal (n, 3), distance (n,) [m].

    A lamp with soft falloff is a disk that faces p; a sun's place is a direction, and it is FAR away.
    """
    if light.kind == "SUN":
        return -wi, -wi, np.full(len(p), FAR)
    r = np.asarray(light.matrix, np.float64)[:3, 3] - p
    if light.kind == "AREA":
        normal = np.broadcast_to(shine_direction(light), p.shape)
        cosine = -(wi * normal).sum(axis=1)
        distance = -(r * normal).sum(axis=1) / np.where(cosine > 1e-9, cosine, 1e-9)
        return p + distance[:, None] * wi, normal, distance
    d2, along = (r * r).sum(axis=1), (r * wi).sum(axis=1)
    if light.radius <= 0.0:
        return p + r, -wi, np.sqrt(d2)
    if light.soft_falloff:
        distance = d2 / np.maximum(along, 1e-9 * np.sqrt(d2))
        return p + distance[:, None] * wi, -wi, distance
    half_chord = np.sqrt(np.maximum(light.radius**2 - d2 + along * along, 0.0))
    distance = along - np.where(d2 > light.radius**2, half_chord, -half_chord)
    normal = distance[:, None] * wi - r
    return p + distance[:, None] * wi, normal / np.linalg.norm(normal, axis=1, keepdims=True), distance


def lamp_points(
    light: Light, place: np.ndarray, normal: np.ndarray, d: np.ndarray, distance: np.ndarray,
    trail: np.ndarray | None = None,
) -> ShadePoints:  # fmt: skip
    """What a lamp's nodes see at places (n, 3) in the world of light that leaves along d (n, 3).

    distance : (n,) [m] to where it arrives;  trail : (n,) i64 as in `LampNodes.arriving`. Of the ray a lamp knows its
    length and depth alone: all flags of Light Path are 0, as in Cycles.
    """
    matrix = np.asarray(light.matrix, np.float64)
    linear, location = matrix[:3, :3], matrix[:3, 3]
    inverse = np.linalg.pinv(linear)
    points = sky_points(d)
    local = ((place - location) @ inverse.T).astype(np.float32)
    points.p, points.wo = place.astype(np.float32), np.ascontiguousarray(d, np.float32)
    points.ng = points.ns = np.ascontiguousarray(normal, np.float32)
    points.backfacing = (normal * d).sum(axis=1) < 0.0
    points.generated = points.object = local
    points.ray_length = np.minimum(distance, FAR).astype(np.float32)
    u, v = surface_uv(light, local, normal, d, inverse)
    points.uvs[""] = np.stack([u, v], axis=1).astype(np.float32)
    points.parametric = np.stack([v, 1.0 - u - v], axis=1).astype(np.float32)
    inward = normal @ linear
    points.normal_local = (inward / np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-30)).astype(np.float32)
    points.objects = ObjectTable.from_instances([Instance(0, matrix, [])])
    points.trail = None if trail is None else (trail >> DEPTH << DEPTH) + FROM_LIGHT
    points.is_lamp = True
    return points


def surface_uv(
    light: Light, local: np.ndarray, normal: np.ndarray, d: np.ndarray, inverse: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cycles' UV coordinates of a lamp: over an area, across a spot's beam or a sun's disk, round a point lamp."""
    if light.kind == "AREA":
        size_v = light.size[1] if light.shape in ("RECTANGLE", "ELLIPSE") else light.size[0]
        return tuple(np.clip(local[:, k] / max(size, 1e-30), -0.5, 0.5) + 0.5
                     for k, size in enumerate((light.size[0], size_v)))  # fmt: skip
    if light.kind == "POINT":
        x, y, z = (normal @ inverse.T).T
        length = np.sqrt(x * x + y * y + z * z)
        u = np.where((x == 0.0) & (y == 0.0), 0.0, 0.5 - np.arctan2(x, y) / (2.0 * math.pi))
        return u, 1.0 - np.arccos(np.clip(z / np.maximum(length, 1e-30), -1.0, 1.0)) / math.pi
    if light.kind == "SPOT":
        x, y, z = (d @ inverse.T).T
        factor = 0.5 / math.tan(0.5 * light.spot_size) / np.where(z == 0.0, -1e-30, -z)
        return x * factor + 0.5, y * factor + 0.5
    quarter = 0.25 * light.angle
    away = np.linalg.norm(d + shine_direction(light), axis=1)  # 2 cos(a / 2) at the angle a from the middle
    factor = (0.5 / math.sin(quarter) if quarter > 0.0 else 0.0) / np.maximum(away, 1e-30)
    return (d @ inverse[0]) * -factor + 0.5, (d @ inverse[1]) * -factor + 0.5
