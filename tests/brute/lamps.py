"""Lamps: met by rays, sampled from points, and sending out photons. Cycles' units."""

import math

import numpy as np

from photon_engine.issues import RenderError

from .jit import kernel
from .maths import cone_direction, cosine_direction, dot, in_frame, madd, scale, uniform, unit

RECTANGLE, DISK, SPHERE, FACING, SUN = range(5)

# fields of a lamp's row
P, N, X, Y, LE, RADIUS, AREA, COS_SUN, SPREAD, SPOT_SIZE, BLEND, SEEN = 0, 3, 6, 9, 12, 15, 16, 17, 18, 19, 20, 21
SPOT_M = 22  # 9 numbers: world direction to the lamp's space
N_FIELDS = 31


def area_lamp(light, row):
    """Fill an AREA lamp's row; its kind."""
    m = np.asarray(light.matrix, float)
    round_shape = light.shape in ("DISK", "ELLIPSE")
    size = (light.size[0], light.size[0]) if light.shape in ("SQUARE", "DISK") else light.size
    row[X : X + 3], row[Y : Y + 3] = 0.5 * size[0] * m[:3, 0], 0.5 * size[1] * m[:3, 1]
    row[N : N + 3] = -m[:3, 2] / np.linalg.norm(m[:3, 2])
    row[AREA] = 4.0 * np.linalg.norm(np.cross(row[X : X + 3], row[Y : Y + 3])) * (np.pi / 4 if round_shape else 1.0)
    row[LE : LE + 3] /= np.pi * (row[AREA] if light.normalize else 1.0)
    row[SPREAD] = light.spread
    return DISK if round_shape else RECTANGLE


def round_lamp(light, row):
    """Fill a POINT or SPOT lamp's row; its kind. A point without size has its intensity in LE [W/sr]."""
    r = row[RADIUS] = light.radius
    row[AREA] = np.pi * r * r
    if r == 0.0:
        row[LE : LE + 3] /= 4.0 * np.pi
    else:
        row[LE : LE + 3] /= np.pi * (4.0 * row[AREA] if light.normalize else 1.0)
    if light.kind == "SPOT":
        row[SPOT_SIZE], row[BLEND] = light.spot_size, light.spot_blend
        row[SPOT_M : SPOT_M + 9] = np.linalg.inv(np.asarray(light.matrix, float)[:3, :3]).ravel()
    return FACING if light.soft_falloff and r > 0.0 else SPHERE


def sun_lamp(light, row):
    """Fill a SUN lamp's row; its kind. Without an angle LE is the irradiance."""
    m = np.asarray(light.matrix, float)
    row[N : N + 3] = -m[:3, 2] / np.linalg.norm(m[:3, 2])
    row[COS_SUN] = np.cos(0.5 * light.angle)
    if light.angle > 0.0 and light.normalize:
        row[LE : LE + 3] /= np.pi * np.sin(0.5 * light.angle) ** 2
    return SUN


def lamp_rows(lights):
    """(kinds (L,) i32, rows (L, N_FIELDS) f64) of all lamps."""
    kind = np.zeros(len(lights), np.int32)
    rows = np.zeros((len(lights), N_FIELDS))
    build = {"AREA": area_lamp, "POINT": round_lamp, "SPOT": round_lamp, "SUN": sun_lamp}
    for i, light in enumerate(lights):
        if not light.cast_shadow:
            raise RenderError(light.name, "a lamp without shadows", "the reference tracer knows only shadowed lamps")
        rows[i, P : P + 3] = np.asarray(light.matrix, float)[:3, 3]
        rows[i, LE : LE + 3] = light.strength
        rows[i, SPREAD] = np.pi
        rows[i, SEEN] = light.visible_camera
        kind[i] = build[light.kind](light, rows[i])
    return kind, rows


@kernel
def field3(rows, i, f):
    """Three numbers of a row from field f."""
    return (rows[i, f], rows[i, f + 1], rows[i, f + 2])


@kernel
def is_delta(kind, rows, i):
    """Whether no ray can meet the lamp."""
    return rows[i, COS_SUN] == 1.0 if kind[i] == SUN else kind[i] > DISK and rows[i, RADIUS] == 0.0


@kernel
def falloff(rows, i, w):
    """Spread and spot factors for light that leaves along w."""
    out = 1.0
    if rows[i, SPREAD] < math.pi:
        h = 0.5 * rows[i, SPREAD]
        c = dot(w, field3(rows, i, N))
        out = max(0.0, (math.tan(h) - math.sqrt(max(0.0, 1.0 - c * c)) / c) / (math.tan(h) - h))
    if rows[i, SPOT_SIZE] > 0.0:
        local = unit((dot(w, field3(rows, i, SPOT_M)), dot(w, field3(rows, i, SPOT_M + 3)),
                      dot(w, field3(rows, i, SPOT_M + 6))))
        edge = math.cos(0.5 * rows[i, SPOT_SIZE])
        width = (1.0 - edge) * rows[i, BLEND]
        if width == 0.0:
            return out if -local[2] > edge else 0.0
        x = min(1.0, max(0.0, (-local[2] - edge) / width))
        out *= x * x * (3.0 - 2.0 * x)
    return out


@kernel
def meet(kind, rows, i, o, d):
    """Distance at which a ray meets lamp i's shining side; < 0: never."""
    if is_delta(kind, rows, i):
        return -1.0
    if kind[i] == SUN:
        return np.inf if -dot(d, field3(rows, i, N)) > rows[i, COS_SUN] else -1.0
    to = madd(field3(rows, i, P), -1.0, o)
    if kind[i] == SPHERE:
        b = dot(to, d)
        r2 = rows[i, RADIUS] ** 2
        off = madd(to, -b, d)
        h2 = r2 - dot(off, off)
        return b - math.sqrt(h2) if h2 > 0.0 and dot(to, to) > r2 else -1.0
    n = field3(rows, i, N) if kind[i] != FACING else scale(unit(to), -1.0)
    slope = dot(d, n)
    if slope >= 0.0:
        return -1.0
    t = dot(to, n) / slope
    at = madd(scale(to, -1.0), t, d)
    if kind[i] == FACING:
        inside = dot(at, at) < rows[i, RADIUS] ** 2
    else:
        x, y = field3(rows, i, X), field3(rows, i, Y)
        u, v = dot(at, x) / dot(x, x), dot(at, y) / dot(y, y)
        inside = u * u + v * v < 1.0 if kind[i] == DISK else abs(u) < 1.0 and abs(v) < 1.0
    return t if inside else -1.0


@kernel
def lamps_seen(sc, o, d, t_max, by_camera):
    """Radiance of all lamps that a ray meets before t_max; lamps stop nothing."""
    out = (0.0, 0.0, 0.0)
    for i in range(len(sc.lamp_kind)):
        t = meet(sc.lamp_kind, sc.lamps, i, o, d)
        if 0.0 < t and (t < t_max or t == np.inf == t_max) and not (by_camera and sc.lamps[i, SEEN] == 0.0):
            out = madd(out, falloff(sc.lamps, i, scale(d, -1.0)), field3(sc.lamps, i, LE))
    return out


@kernel
def area_point(kind, rows, i, state):
    """A uniform point on an area lamp."""
    if kind[i] == DISK:
        r, phi = math.sqrt(uniform(state)), 2.0 * math.pi * uniform(state)
        u, v = r * math.cos(phi), r * math.sin(phi)
    else:
        u, v = 2.0 * uniform(state) - 1.0, 2.0 * uniform(state) - 1.0
    return madd(madd(field3(rows, i, P), u, field3(rows, i, X)), v, field3(rows, i, Y))


@kernel
def toward_lamp(sc, i, p, state):
    """A shadow ray: (wi, distance, radiance / density by solid angle); for a delta lamp the irradiance it makes."""
    rows, kind = sc.lamps, sc.lamp_kind[i]
    le = field3(rows, i, LE)
    if kind == SUN:
        axis = scale(field3(rows, i, N), -1.0)
        if rows[i, COS_SUN] == 1.0:
            return axis, np.inf, le
        wi = cone_direction(axis, rows[i, COS_SUN], state)
        return wi, np.inf, scale(le, 2.0 * math.pi * (1.0 - rows[i, COS_SUN]))
    to = madd(field3(rows, i, P), -1.0, p)
    d2 = dot(to, to)
    if rows[i, RADIUS] == 0.0 and kind > DISK:
        wi = unit(to)
        return wi, math.sqrt(d2), scale(le, falloff(rows, i, scale(wi, -1.0)) / d2)
    if kind == SPHERE:
        return toward_sphere(sc, i, p, to, state)
    if kind == FACING:
        n = scale(unit(to), -1.0)
        r, phi = rows[i, RADIUS] * math.sqrt(uniform(state)), 2.0 * math.pi * uniform(state)
        on = madd(field3(rows, i, P), 1.0, in_frame(r * math.cos(phi), r * math.sin(phi), 0.0, n))
    else:
        n = field3(rows, i, N)
        on = area_point(sc.lamp_kind, rows, i, state)
    to = madd(on, -1.0, p)
    d2 = dot(to, to)
    wi = unit(to)
    cos_l = -dot(wi, n)
    if cos_l <= 0.0:
        return wi, 0.0, (0.0, 0.0, 0.0)
    return wi, math.sqrt(d2), scale(le, falloff(rows, i, scale(wi, -1.0)) * cos_l * rows[i, AREA] / d2)


@kernel
def toward_sphere(sc, i, p, to, state):
    """As `toward_lamp` for a sphere, uniform in the cone it fills; nothing from inside."""
    rows = sc.lamps
    d2, r2 = dot(to, to), rows[i, RADIUS] ** 2
    if d2 <= r2:
        return unit(to), 0.0, (0.0, 0.0, 0.0)
    cos_max = math.sqrt(1.0 - r2 / d2)
    wi = cone_direction(unit(to), cos_max, state)
    t = meet(sc.lamp_kind, rows, i, p, wi)
    # a ray that rounding lets pass beside the sphere still ends at its silhouette
    distance = t if t > 0.0 else math.sqrt(d2 - r2)
    # 1 - cos, without cancellation for a far lamp
    solid = 2.0 * math.pi * (r2 / d2) / (1.0 + cos_max)
    return wi, distance, scale(field3(rows, i, LE), solid * falloff(rows, i, scale(wi, -1.0)))


@kernel
def emit(sc, i, state):
    """A photon of lamp i as if it were the only one: (o, d, flux [W])."""
    rows, kind = sc.lamps, sc.lamp_kind[i]
    le = field3(rows, i, LE)
    if kind == SUN:
        axis = field3(rows, i, N)
        d, flux = axis, 1.0
        if rows[i, COS_SUN] < 1.0:
            d = cone_direction(axis, rows[i, COS_SUN], state)
            flux = 2.0 * math.pi * (1.0 - rows[i, COS_SUN])
        return from_disk(sc, d, state), d, scale(le, flux * math.pi * sc.world_radius**2)
    if kind <= DISK:
        d = cosine_direction(field3(rows, i, N), state)
        flux = math.pi * rows[i, AREA] * falloff(rows, i, d)
        return area_point(sc.lamp_kind, rows, i, state), d, scale(le, flux)
    n = cone_direction((0.0, 0.0, 1.0), -1.0, state)
    if rows[i, RADIUS] == 0.0:
        return field3(rows, i, P), n, scale(le, 4.0 * math.pi * falloff(rows, i, n))
    d = cosine_direction(n, state)
    flux = 4.0 * math.pi * rows[i, AREA] * falloff(rows, i, d)
    return madd(field3(rows, i, P), rows[i, RADIUS], n), d, scale(le, flux)


@kernel
def from_disk(sc, d, state):
    """Origin of a parallel ray along d: uniform on a disk that covers the scene, in front of it."""
    r, phi = sc.world_radius * math.sqrt(uniform(state)), 2.0 * math.pi * uniform(state)
    centre = (sc.world_centre[0], sc.world_centre[1], sc.world_centre[2])
    on = madd(centre, 1.0, in_frame(r * math.cos(phi), r * math.sin(phi), 0.0, d))
    return madd(on, -1.001 * sc.world_radius, d)


@kernel
def first_hit_kept(sc, i, p, d):
    """Whether a photon of lamp i that lands at p along d exists: a facing disk is thinner than its sphere when near."""
    if sc.lamp_kind[i] != FACING:
        return True
    return meet(sc.lamp_kind, sc.lamps, i, p, scale(d, -1.0)) > 0.0
