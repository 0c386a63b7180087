"""Photons leaving a light: origin, direction and flux, for the whole light.

The flux of a photon is phi = Le cos / pdf [W] when one photon is emitted and its light is certain.
"""

from __future__ import annotations

import math

from ..jit import inlined
from ..sampling.warps import (
    square_to_cone,
    square_to_cosine_hemisphere,
    square_to_disk,
    square_to_sphere,
    turn,
)
from ..vec import add, cross, dot, load3, madd, normalize, scale, sub, to_world
from .area import area_gain, area_point
from .beams import radiance_along
from .mesh import leave_mesh, mesh_origin, triangle_radiance
from .round import spot_falloff, transform
from .sky_sample import map_sample
from .table import AREA, DELTA, ELLIPSE, FOCUSED, MESH, SOFT, SPOT, SUN, WORLD

MARGIN = 1.001  # photons from infinity start this far out, in radii of the scene


@inlined
def emit_photon(lights, l, u0, u1, u2, u3):
    """A photon of light l over its whole emission: (o, d, phi, m); u0 ... u3 in [0, 1).

    m : the emissive triangle, or -1; where lights.tri_shaded[m], its radiance must be multiplied in.
    phi = black: nothing leaves that way. Lamps with soft falloff: see `dark_distance`.
    """
    kind = lights.kind[l]
    if kind == MESH:
        return _emit_mesh(lights, u0, u1, u2, u3)
    if kind == AREA:
        o, d, phi = _emit_area(lights, l, u0, u1, u2, u3)
        return o, d, phi, -1
    if kind == SUN or kind == WORLD:
        d, le = distant_direction(lights, l, u2, u3)
        o = from_outside(lights, disk_point(scene_center(lights), lights.radius, d, u0, u1), d)
        return o, d, scale(le, math.pi * lights.radius * lights.radius), -1
    d, gain = round_direction(lights, l, u2, u3)
    o = disk_point(load3(lights.position, l), lights.size[l, 0], d, u0, u1)
    phi = scale(radiance_along(lights, l, d), gain * round_disk(lights, l))
    return round_surface(lights, l, o, d), d, phi, -1


@inlined
def scene_center(lights):
    """Centre of the scene's bounding sphere."""
    return (lights.center[0], lights.center[1], lights.center[2])


@inlined
def round_disk(lights, l):
    """Area [m^2] of a point or spot lamp across any direction; 1 for a point, whose radiance is an intensity."""
    return 1.0 if lights.flags[l] & DELTA else math.pi * lights.size[l, 0] * lights.size[l, 0]


@inlined
def round_surface(lights, l, o, d):
    """Where a photon on the line (o, d), o being its closest point to the centre, starts: on a sphere's front."""
    r2 = lights.size[l, 0] * lights.size[l, 0]
    if r2 == 0.0 or lights.flags[l] & SOFT:
        return o
    offset = sub(o, load3(lights.position, l))
    return madd(o, math.sqrt(max(0.0, r2 - dot(offset, offset))), d)


@inlined
def dark_distance(lights, l, o, d):
    """Distance [m] from its origin below which a photon of `emit_photon` or `emit_aimed` lights nothing.

    A surface that it meets sooner is not lit, and stops what it does not let straight through. 0 for all but lamps with
    soft falloff. Such a lamp is a disk of radius R that faces every point p: a line whose closest approach to the
    centre is b carries Le at distance s beyond it where b / s < R / sqrt(b^2 + s^2), that is from
    s = b^2 / sqrt(R^2 - b^2) on. This is a light field with a dark stretch along each line;
    E = S / (4 pi (d^2 + R^2)) on a surface that faces the lamp at d.
    """
    if not lights.flags[l] & SOFT:
        return 0.0
    offset = sub(o, load3(lights.position, l))
    b2 = dot(offset, offset)
    rest = lights.size[l, 0] * lights.size[l, 0] - b2
    return b2 / math.sqrt(rest) if rest > 0.0 else math.inf


@inlined
def round_direction(lights, l, u0, u1):
    """Direction of a point or spot lamp's photon, by its falloff: (d, falloff / density [sr])."""
    if lights.kind[l] != SPOT:
        return square_to_sphere(u0, u1), 4.0 * math.pi
    cos_half = lights.cone[l, 0]
    blend = lights.cone[l, 1]
    # local height h = 1 - cos: a flat core, then a rim whose falloff integrates to half its width
    core = 1.0 - blend
    total = core + 0.5 * blend
    if u0 * total < core:
        h = (1.0 - cos_half) * u0 * total
    else:
        x = smoothstep_inverse((u0 * total - core) / (0.5 * blend))
        h = (1.0 - cos_half) * (core + blend * x)
    sine = math.sqrt(max(0.0, h * (2.0 - h)))
    c, s = turn(u1)
    local = (sine * c, sine * s, h - 1.0)
    d = normalize(transform(lights.to_world, l, local))
    return d, spot_integral(lights, l) / spot_jacobian(lights, l, d)


@inlined
def spot_integral(lights, l):
    """A spot's falloff over all directions of its own space [sr]."""
    return 2.0 * math.pi * (1.0 - lights.cone[l, 0]) * (1.0 - 0.5 * lights.cone[l, 1])


@inlined
def round_direction_pdf_w(lights, l, d):
    """Density of a spot's `round_direction` in solid angle."""
    return spot_falloff(lights, l, d) * spot_jacobian(lights, l, d) / spot_integral(lights, l)


@inlined
def spot_jacobian(lights, l, d):
    """Local solid angle over world solid angle along d: |det A| / |A d|^3 for the world-to-local matrix A."""
    v = transform(lights.to_local, l, d)
    a = lights.to_local
    x = (a[l, 0, 0], a[l, 1, 0], a[l, 2, 0])
    y = (a[l, 0, 1], a[l, 1, 1], a[l, 2, 1])
    z = (a[l, 0, 2], a[l, 1, 2], a[l, 2, 2])
    return abs(dot(cross(x, y), z)) / dot(v, v) ** 1.5


@inlined
def smoothstep_inverse(u):
    """The x where the integral of 1 - smoothstep from 0 reaches the share u of its total 1/2: 2x - 2x^3 + x^4 = u."""
    x = 1.0 - math.sqrt(math.sqrt(max(0.0, 1.0 - u)))  # near x = 1, 1 - u ~ 2 (1 - x)^3, near 0 u ~ 2 x
    low = 0.0
    high = 1.0
    for _ in range(60):
        value = x * (2.0 + x * x * (x - 2.0)) - u
        if value > 0.0:
            high = x
        else:
            low = x
        slope = 2.0 + x * x * (4.0 * x - 6.0)
        step = x - value / slope if slope > 1e-9 else 0.5 * (low + high)
        following = step if low < step < high else 0.5 * (low + high)
        if abs(following - x) < 1e-14:
            break
        x = following
    return x


@inlined
def distant_direction(lights, l, u0, u1):
    """Direction in which light of a sun or the world travels, and its radiance over the density: (d, rgb [W/m^2]).

    Uniform, or by the brightness of a world that varies; a delta sun: its irradiance.
    """
    if lights.kind[l] == WORLD:
        if len(lights.sky.rows):
            wi, le, pdf_w = map_sample(lights.sky, u0, u1)
            return scale(wi, -1.0), scale(le, 1.0 / pdf_w)
        return square_to_sphere(u0, u1), scale(load3(lights.radiance, l), 4.0 * math.pi)
    axis = load3(lights.normal, l)
    h = lights.size[l, 0]
    if h == 0.0:
        return axis, radiance_along(lights, l, axis)
    d = to_world(square_to_cone(u0, u1, h), axis)
    return d, scale(radiance_along(lights, l, d), 2.0 * math.pi * h)


@inlined
def disk_point(center, radius, d, u0, u1):
    """Point uniform on the disk about `center` across the unit direction d."""
    x, y = square_to_disk(u0, u1)
    return add(center, to_world((radius * x, radius * y, 0.0), d))


@inlined
def from_outside(lights, x, d):
    """Point on the line through x along d that lies just before the scene's bounding sphere."""
    r = sub(x, scene_center(lights))
    along = dot(r, d)
    miss2 = max(0.0, dot(r, r) - along * along)
    before = math.sqrt(max(0.0, lights.radius * lights.radius - miss2))
    return madd(x, -(along + before + (MARGIN - 1.0) * lights.radius), d)


@inlined
def area_origin(lights, l, u0, u1):
    """Point uniform on an area lamp."""
    if lights.flags[l] & ELLIPSE:
        x, y = square_to_disk(u0, u1)
    else:
        x = 2.0 * u0 - 1.0
        y = 2.0 * u1 - 1.0
    return area_point(lights, l, x * lights.size[l, 0], y * lights.size[l, 1])


@inlined
def _emit_area(lights, l, u0, u1, u2, u3):
    """Uniform on the lamp, cosine-weighted within the spread."""
    o = area_origin(lights, l, u0, u1)
    normal = load3(lights.normal, l)
    area = lights.size[l, 2]
    if lights.flags[l] & DELTA:
        return o, normal, scale(radiance_along(lights, l, normal), area)
    sine2 = lights.cone[l, 2] if lights.flags[l] & FOCUSED else 1.0
    d = area_direction(lights, l, u2, u3)
    gain = math.pi * sine2 * area * area_gain(lights, l, dot(normal, d))
    return o, d, scale(radiance_along(lights, l, d), gain)


@inlined
def area_direction(lights, l, u0, u1):
    """Direction from an area lamp, cosine-weighted within its spread."""
    sine2 = lights.cone[l, 2] if lights.flags[l] & FOCUSED else 1.0
    x, y = square_to_disk(u0, u1)
    s = math.sqrt(sine2)
    cosine = math.sqrt(max(0.0, 1.0 - sine2 * (x * x + y * y)))
    return to_world((s * x, s * y, cosine), load3(lights.normal, l))


@inlined
def _emit_mesh(lights, u0, u1, u2, u3):
    """By flux over triangles, cosine-weighted, on either side."""
    m, o, normal, density = mesh_origin(lights, u0, u1)
    back = u2 >= 0.5
    local = square_to_cosine_hemisphere(2.0 * u2 - (1.0 if back else 0.0), u3)
    d = to_world(local, scale(normal, -1.0) if back else normal)
    o = leave_mesh(lights, m, o, normal, d)
    return o, d, scale(triangle_radiance(lights, m), 2.0 * math.pi / density), m
