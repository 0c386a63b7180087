"""The table of lights that every kernel reads, and how it is built from SceneData.

Order: lamps, suns last among them, then the group of emissive triangles (MESH), then the world. Lengths are relative to
an origin that is subtracted from world positions, so that single-precision geometry and lights share one frame.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..issues import IssueLog, RenderError
from ..scene.data import Light, SceneData
from .beams import Beams, axes_of, mean_share, pack_beams
from .sky import SkyMap, mean_radiance, no_map
from .tree import Bounds, LightTree, build_tree, empty_bounds, spot_half_angle, spot_solid_angle, triangle_bounds

# kinds
POINT, SPOT, SUN, AREA, MESH, WORLD = range(6)
KINDS = {"POINT": POINT, "SPOT": SPOT, "SUN": SUN, "AREA": AREA}

# flags
DELTA = 1  # cannot be hit by a ray: a point, one direction, or parallel rays from an area
SOFT = 2  # POINT, SPOT with a radius: a disk that faces whoever looks
ELLIPSE = 4  # AREA: round instead of rectangular
SHADOW = 8  # casts shadows
CAMERA = 16  # seen by the camera
FOCUSED = 32  # AREA: spread below 180 degrees
SHADED = 64  # its nodes are evaluated at each sample (lights/nodes.py); kernels take them for white

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
MANY = 32  # above so many lamps a tree selects among them instead of a look at each
UNIFORM_SHARE = 0.5  # of the static selection; the rest follows power
# of the photons, shared evenly by all lights, and within the emissive triangles by area: where a lamp of 1e-6 of the
# power is alone, as in the next room, there is light and an error bar instead of neither
PHOTON_FLOOR = 0.05
MIN_AXIS = 1e-12  # a shorter column of a matrix [m] has no direction


class Emitters(NamedTuple):
    """Triangles that radiate, in recentred world space."""

    tri: np.ndarray  # (M,) i32, global triangle ids
    v0: np.ndarray  # (M, 3) f32 [m]
    v1: np.ndarray  # (M, 3) f32 [m]
    v2: np.ndarray  # (M, 3) f32 [m]
    radiance: np.ndarray  # (M, 3) f32, average over the triangle [W/m^2/sr]; both sides radiate
    shaded: np.ndarray | None = None  # (M,) bool, radiance varies over the triangle or with direction; None: nowhere
    outward: np.ndarray | None = None  # (M,) f32, as in `tree.triangle_bounds`; None: 0


class LightTable(NamedTuple):
    """All lights of a scene, L of them; M emissive triangles, T triangles in all."""

    kind: np.ndarray  # (L,) i32
    flags: np.ndarray  # (L,) i32, bits DELTA ... SHADED
    source: np.ndarray  # (L,) i32, index into the scene's lamps, or -1
    position: np.ndarray  # (L, 3) f64 [m]; MESH: centroid
    axis_u: np.ndarray  # (L, 3) f64, unit, AREA
    axis_v: np.ndarray  # (L, 3) f64, unit, AREA
    normal: np.ndarray  # (L, 3) f64, unit: AREA, SPOT: where it shines; SUN: where its light travels
    radiance: np.ndarray  # (L, 3) f64 [W/m^2/sr]; POINT, SPOT with DELTA: intensity [W/sr]; SUN, AREA with DELTA:
    # irradiance [W/m^2]; MESH: mean of its triangles
    size: np.ndarray  # (L, 3) f64: POINT, SPOT, MESH: radius; AREA: half u, half v, area; SUN: 1 - cos(half angle)
    cone: np.ndarray  # (L, 3) f64: SPOT: cos(half angle), blend; AREA: tan(half spread), gain 1 / (tan h - h), sin^2 h
    to_world: np.ndarray  # (L, 3, 3) f64, SPOT: local to world directions, with the object's scale
    to_local: np.ndarray  # (L, 3, 3) f64, SPOT: its inverse
    flux: np.ndarray  # (L, 3) f64, entering the bounding sphere of the scene [W]
    power: np.ndarray  # (L,) f64, what `selection.light_weight` scales: intensity, irradiance or flux by kind
    near_cdf: np.ndarray  # (n_near,) f64, half uniform, half by flux: the share of every lamp where a tree selects
    photon_cdf: np.ndarray  # (L,) f64, by flux, PHOTON_FLOOR evenly: whole-scene photons
    emitter_of_tri: np.ndarray  # (T,) i32, index into the M emissive triangles, or -1
    tri_id: np.ndarray  # (M,) i32, global triangle
    tri_v0: np.ndarray  # (M, 3) f64 [m]
    tri_e1: np.ndarray  # (M, 3) f64, v1 - v0 [m]
    tri_e2: np.ndarray  # (M, 3) f64, v2 - v0 [m]
    tri_radiance: np.ndarray  # (M, 3) f64 [W/m^2/sr], average
    tri_shaded: np.ndarray  # (M,) bool, whether it must be evaluated at the point: light from it is then given as white
    tri_area: np.ndarray  # (M,) f64 [m^2]
    tri_cdf: np.ndarray  # (M,) f64, by flux, PHOTON_FLOOR by area
    lamp_tree: LightTree  # over the lamps that are not suns; empty where there are at most MANY
    tri_tree: LightTree  # over the M emissive triangles
    center: np.ndarray  # (3,) f64, bounding sphere of the geometry [m]
    radius: float  # of that sphere [m]
    beams: Beams  # of lamps whose nodes vary with direction: their radiance is the largest
    sky: SkyMap  # radiance of the WORLD by direction; empty: it is constant
    n_near: int  # lamps that are not suns come first


class _Row:
    """One light while the table is being built; the fields are those of LightTable."""

    def __init__(self, kind: int, radiance: np.ndarray, flags: int = SHADOW | CAMERA) -> None:
        self.kind = kind
        self.flags = flags
        self.source = -1
        self.radiance = np.asarray(radiance, np.float64)
        self.position = np.zeros(3)
        self.axis_u = np.array([1.0, 0.0, 0.0])
        self.axis_v = np.array([0.0, 1.0, 0.0])
        self.normal = np.array([0.0, 0.0, -1.0])
        self.size = np.zeros(3)
        self.cone = np.zeros(3)
        self.to_world = np.eye(3)
        self.to_local = np.eye(3)
        self.flux = np.zeros(3)
        self.power = 0.0
        self.beam: np.ndarray | None = None
        self.frame = np.eye(3)


def build_lights(
    scene: SceneData,
    emitters: Emitters,
    n_triangles: int,
    center: np.ndarray,
    radius: float,
    origin: np.ndarray,
    issues: IssueLog | None = None,
    sky: SkyMap | None = None,
) -> LightTable:
    """The light table of a scene.

    emitters : M emissive triangles, recentred;  n_triangles : T;  center (3,), radius [m] : sphere around all
    geometry, recentred;  origin (3,) f64 : subtracted from world positions.
    sky : of a world that varies. Lights without power are left out.
    Raises RenderError for a lamp whose numbers are not finite.
    """
    issues = IssueLog() if issues is None else issues
    radius = max(float(radius), 1e-6)
    rows = []
    for i, light in enumerate(scene.lights):
        if (row := _lamp(light, np.asarray(origin, np.float64), issues)) is not None:
            row.source = i
            rows.append(row)
    rows.sort(key=lambda row: row.kind == SUN)
    for row in rows:
        row.flux *= _entering(row, np.asarray(center, np.float64), radius)
    triangles = _triangles(emitters)
    if len(triangles["tri_cdf"]) and triangles["tri_cdf"][-1] > 0.0:
        rows.append(_mesh(triangles))
    sky = no_map() if sky is None else sky
    world = mean_radiance(sky) if len(sky.rows) else np.asarray(scene.world.color, np.float64)
    if not np.all(np.isfinite(world)):
        raise RenderError(scene.world.name, "the world's colour is not finite", "check its strength")
    if np.any(world < 0.0):
        issues.warn(scene.world.name, "a negative world is not supported: taken as 0", "use a positive strength")
        world = np.maximum(world, 0.0)
    if np.any(world):
        row = _Row(WORLD, world)
        row.flux = world * (4.0 * math.pi**2 * radius**2)
        row.power = math.pi * _weight(world)
        rows.append(row)
    lookup = np.full(n_triangles, -1, np.int32)
    lookup[emitters.tri] = np.arange(len(emitters.tri), dtype=np.int32)
    return _pack(rows, triangles, lookup, (np.asarray(center, np.float64), radius, sky))


def _pack(rows: list[_Row], triangles: dict, lookup: np.ndarray, sphere: tuple) -> LightTable:
    """Stack rows into arrays and add the selection tables."""
    flux = np.array([row.flux for row in rows], np.float64).reshape(-1, 3)
    weights = flux @ LUMINANCE
    near = [row for row in rows if row.kind in (POINT, SPOT, AREA)]

    def stack(name: str, *shape: int) -> np.ndarray:
        return np.array([getattr(row, name) for row in rows], np.float64).reshape(len(rows), *shape)

    return LightTable(
        kind=np.array([row.kind for row in rows], np.int32),
        flags=np.array([row.flags for row in rows], np.int32),
        source=np.array([row.source for row in rows], np.int32),
        **{name: stack(name, 3) for name in ("position", "axis_u", "axis_v", "normal", "radiance", "size", "cone")},
        to_world=stack("to_world", 3, 3),
        to_local=stack("to_local", 3, 3),
        flux=flux,
        power=stack("power"),
        near_cdf=make_cdf(_shares(weights[: len(near)], UNIFORM_SHARE, np.ones(len(near)))),
        photon_cdf=make_cdf(_shares(weights, PHOTON_FLOOR, weights > 0.0)),
        emitter_of_tri=lookup,
        **triangles,
        lamp_tree=build_tree(lamp_bounds(near if len(near) > MANY else [])),
        center=sphere[0],
        radius=sphere[1],
        beams=pack_beams([row.beam for row in rows], [row.frame for row in rows]),
        sky=sphere[2],
        n_near=len(near),
    )


def _shares(weights: np.ndarray, floor: float, sizes: np.ndarray) -> np.ndarray:
    """Probabilities (n,) by weight, `floor` of them by size; all of them even where nothing has weight."""
    total = weights.sum()
    if not total > 0.0:
        return np.full(len(weights), 1.0 / max(len(weights), 1))
    return floor * (sizes / sizes.sum()) + (1.0 - floor) * (weights / total)


def lamp_bounds(rows: list[_Row]) -> Bounds:
    """What the light tree must know of lamps that are not suns."""
    bounds = empty_bounds(len(rows))
    for i, row in enumerate(rows):
        extent = np.full(3, row.size[0])
        if row.kind == AREA:
            extent = np.abs(row.axis_u) * row.size[0] + np.abs(row.axis_v) * row.size[1]
            if row.flags & (FOCUSED | DELTA):
                bounds.reach[i] = math.asin(math.sqrt(row.cone[2])) + 1e-3
        elif row.kind == POINT:
            bounds.spread[i] = math.pi
        else:
            bounds.spread[i], bounds.reach[i] = spot_half_angle(row.cone[0], row.to_world, row.normal), 1e-3
        bounds.low[i], bounds.high[i] = row.position - extent, row.position + extent
        bounds.axis[i], bounds.power[i], bounds.solid[i] = row.normal, row.power, not row.flags & DELTA
    return bounds


def without_lights(lights: LightTable) -> LightTable:
    """The table for rays that shall see no light."""
    return lights._replace(kind=lights.kind[:0], n_near=0, lamp_tree=build_tree(empty_bounds(0)))


def make_cdf(probabilities: np.ndarray) -> np.ndarray:
    """Cumulative sum that ends at exactly 1 from the last possible entry on."""
    total = np.cumsum(probabilities)
    if len(total):
        total[np.flatnonzero(probabilities)[-1] if np.any(probabilities) else -1 :] = 1.0
    return total


def _weight(rgb: np.ndarray) -> float:
    """Importance of a colour: its luminance."""
    return float(rgb @ LUMINANCE)


def _triangles(emitters: Emitters) -> dict:
    """Emissive triangles in double precision, with a CDF by flux and a tree."""
    v0, v1, v2 = (np.asarray(v, np.float64).reshape(-1, 3) for v in (emitters.v0, emitters.v1, emitters.v2))
    e1, e2 = v1 - v0, v2 - v0
    area = 0.5 * np.linalg.norm(np.cross(e1, e2), axis=1)
    radiance = np.asarray(emitters.radiance, np.float64).reshape(-1, 3)
    weights = area * (radiance @ LUMINANCE)
    lit = np.where(weights > 0.0, area, 0.0)
    cdf = make_cdf(_shares(weights, PHOTON_FLOOR, lit)) if weights.any() else np.zeros(len(weights))
    outward = np.zeros(len(area)) if emitters.outward is None else np.asarray(emitters.outward, np.float64)
    shaded = np.zeros(len(area), bool) if emitters.shaded is None else np.asarray(emitters.shaded, bool)
    return {
        "tri_id": np.asarray(emitters.tri, np.int32),
        "tri_v0": v0, "tri_e1": e1, "tri_e2": e2, "tri_radiance": radiance, "tri_area": area, "tri_cdf": cdf,
        "tri_shaded": shaded, "tri_tree": build_tree(triangle_bounds(np.stack([v0, v1, v2], 1), weights, outward)),
    }  # fmt: skip


def _mesh(triangles: dict[str, np.ndarray]) -> _Row:
    """The group of emissive triangles as one light."""
    area, radiance = triangles["tri_area"], triangles["tri_radiance"]
    row = _Row(MESH, (area[:, None] * radiance).sum(0) / area.sum())
    row.flux = 2.0 * math.pi * (area[:, None] * radiance).sum(0)
    row.power = float((area * (radiance @ LUMINANCE)).sum())  # intensity along the normal, one side
    weights = np.diff(triangles["tri_cdf"], prepend=0.0)
    middle = triangles["tri_v0"] + (triangles["tri_e1"] + triangles["tri_e2"]) / 3.0
    row.position = weights @ middle
    spread = weights @ ((middle - row.position) ** 2).sum(1) + weights @ area / math.pi
    row.size = np.array([math.sqrt(spread), 0.0, area.sum()])
    return row


def _lamp(light: Light, origin: np.ndarray, issues: IssueLog) -> _Row | None:
    """A lamp's row, or None when it gives no light."""
    strength = np.asarray(light.strength, np.float64)
    matrix = np.asarray(light.matrix, np.float64)
    numbers = (light.radius, light.spot_size, light.spot_blend, light.angle, light.spread, *light.size)
    if not (np.all(np.isfinite(strength)) and np.all(np.isfinite(matrix)) and np.all(np.isfinite(numbers))):
        raise RenderError(light.name, "a number of this lamp is not finite", "check transform, size and strength")
    if light.kind not in KINDS:
        raise RenderError(light.name, f"no lamp is of kind {light.kind}", "use a point, spot, sun or area lamp")
    if np.any(strength < 0.0):
        issues.warn(light.name, "negative light is not supported: taken as 0", "use a positive power and colour")
        strength = np.maximum(strength, 0.0)
    if not np.any(strength):
        return None
    flags = (SHADOW if light.cast_shadow else 0) | (CAMERA if light.visible_camera else 0)
    flags |= SHADED if light.graph is not None else 0
    row = _Row(KINDS[light.kind], strength, flags)
    row.position = matrix[:3, 3] - origin
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    if light.kind != "POINT" and scales[2] < MIN_AXIS:
        issues.warn(light.name, "the object's scale is 0, so that the lamp has no direction: left out", "set its scale")
        return None
    if scales[2] >= MIN_AXIS:
        row.normal = -matrix[:3, 2] / scales[2]
    build = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}[light.kind]
    if not build(row, light, matrix, issues):
        return None
    if light.beam is not None:
        row.beam, row.frame = light.beam, axes_of(matrix)
        row.flux = row.flux * mean_share(light.beam, light.kind)
    return row


def _point(row: _Row, light: Light, matrix: np.ndarray, issues: IssueLog) -> bool:
    """Le = S / (4 pi^2 r^2), or intensity S / (4 pi); not normalised: S / pi. Flux, before a spot's cone: S."""
    radius = max(light.radius, 0.0)
    area = (4.0 * math.pi * radius**2 if radius > 0.0 else 4.0) if light.normalize else 1.0
    row.radiance = row.radiance / (math.pi * area)
    row.size = np.array([radius, 0.0, 0.0])
    row.flags |= DELTA if radius == 0.0 else (SOFT if light.soft_falloff else 0)
    intensity = row.radiance * (math.pi * radius**2 if radius > 0.0 else 1.0)
    row.flux = 4.0 * math.pi * intensity
    row.power = _weight(intensity)
    return True


def _spot(row: _Row, light: Light, matrix: np.ndarray, issues: IssueLog) -> bool:
    """As a point lamp, within a cone that the object's scale makes elliptic."""
    _point(row, light, matrix, issues)
    if light.spot_size <= 0.0:
        return False
    linear = matrix[:3, :3]
    if abs(np.linalg.det(linear)) < MIN_AXIS**3:
        issues.warn(light.name, "the object's scale is 0 along an axis: left out", "set its scale")
        return False
    cos_half = math.cos(0.5 * min(light.spot_size, math.pi))
    blend = min(max(light.spot_blend, 0.0), 1.0)
    row.cone = np.array([cos_half, blend, 0.0])
    row.to_world = linear.copy()
    row.to_local = np.linalg.inv(linear)
    row.flux = row.flux * (spot_solid_angle(linear, cos_half, blend) / (4.0 * math.pi))
    return True


def _sun(row: _Row, light: Light, matrix: np.ndarray, issues: IssueLog) -> bool:
    """Le = S / (pi sin^2(angle / 2)), or irradiance S; not normalised: Le = S (no disk: irradiance S)."""
    half = 0.5 * min(max(light.angle, 0.0), math.pi)
    projected = math.pi * math.sin(half) ** 2
    if half == 0.0:
        row.flags |= DELTA
        irradiance = row.radiance
    else:
        row.radiance = row.radiance / projected if light.normalize else row.radiance
        irradiance = row.radiance * projected
    row.size = np.array([2.0 * math.sin(0.5 * half) ** 2, 0.0, 0.0])
    row.flux = irradiance.copy()  # times the area of the scene's disk, in `_entering`
    row.power = _weight(irradiance)
    return True


def _area(row: _Row, light: Light, matrix: np.ndarray, issues: IssueLog) -> bool:
    """One-sided along local -Z, Le = S / (pi A); not normalised: S / pi. Spread keeps the flux."""
    size_v = light.size[1] if light.shape in ("RECTANGLE", "ELLIPSE") else light.size[0]
    u, v = matrix[:3, 0] * light.size[0], matrix[:3, 1] * size_v
    length_u, length_v = np.linalg.norm(u), np.linalg.norm(v)
    if length_u < MIN_AXIS or length_v < MIN_AXIS:
        return False
    row.axis_u = u / length_u
    across = v - row.axis_u * (v @ row.axis_u)
    if np.linalg.norm(across) < 1e-6 * length_v:
        return False
    if np.linalg.norm(across) < 0.999 * length_v:
        issues.warn(light.name, "its shear is ignored: it stays a rectangle or ellipse", "apply the parent's scale")
    row.axis_v = across / np.linalg.norm(across)
    upright = np.cross(row.axis_u, row.axis_v)
    row.normal = upright if upright @ row.normal > 0.0 else -upright
    round_shape = light.shape in ("DISK", "ELLIPSE")
    area = length_u * length_v * (0.25 * math.pi if round_shape else 1.0)
    row.size = np.array([0.5 * length_u, 0.5 * length_v, area])
    row.flags |= ELLIPSE if round_shape else 0
    row.radiance = row.radiance / (math.pi * (area if light.normalize else 1.0))
    row.flux = row.radiance * (math.pi * area)
    _spread(row, 0.5 * max(light.spread, 0.0))
    row.power = _weight(row.flux) / math.pi * max(1.0, row.cone[0] * row.cone[1] if row.flags & FOCUSED else 1.0)
    return True


def _spread(row: _Row, half: float) -> None:
    """Focusing of an area lamp: gain (tan h - tan a) / (tan h - h) at angle a; half = 0: parallel rays."""
    if half == 0.0:
        row.flags |= DELTA
        row.radiance = row.radiance * math.pi  # the irradiance of the beam
    elif half < 0.5 * math.pi - 1e-6:
        row.flags |= FOCUSED
        tangent = math.tan(half)
        excess = tangent - half if half > 1e-3 else half**3 / 3.0 * (1.0 + 0.4 * half**2)
        row.cone = np.array([tangent, 1.0 / excess, math.sin(half) ** 2])


def _entering(row: _Row, center: np.ndarray, radius: float) -> float:
    """Share of a lamp's flux that enters the scene's bounding sphere, roughly; a sun's: the area of its disk [m^2]."""
    if row.kind == SUN:
        return math.pi * radius**2
    distance = float(np.linalg.norm(row.position - center))
    if distance <= radius:
        return 1.0
    sphere = 2.0 * math.pi * (1.0 - math.sqrt(1.0 - (radius / distance) ** 2))
    beam = {POINT: 4.0 * math.pi, AREA: math.pi, SPOT: 2.0 * math.pi * (1.0 - row.cone[0])}[row.kind]
    if row.kind == AREA and row.flags & FOCUSED:
        beam *= row.cone[2]
    return min(1.0, sphere / max(beam, 1e-12))
