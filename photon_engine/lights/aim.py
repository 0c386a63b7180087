"""Photons aimed at spheres: how a light's photon toward one sphere is drawn, and with what density.

Densities are those of whole photon lines: per m^2 across the line and sr (area lamps, meshes: per m^2 of the emitter
and sr; points: per sr; suns: per m^2 and, for their direction, per sr of the disk), so that the densities of several
overlapping spheres add up to a mixture [Veach and Guibas 1995; physics of projection maps: Jensen 1996].

A lamp whose own beam (a spot's cone, an area lamp's spread, a bundle of parallel rays) is narrower than what a sphere
fills is drawn from by that beam, and what passes the sphere by is dropped: of a laser's photons toward a large mirror
none would start on the laser otherwise.
"""

from __future__ import annotations

import math

from ..jit import inlined
from ..sampling.warps import INV_4PI, one_minus_cos, square_to_cone, square_to_disk, square_to_sphere
from ..vec import add, dot, load3, madd, scale, sub, to_world
from .area import area_gain
from .emit import area_direction, disk_point, distant_direction, round_direction, round_direction_pdf_w, round_disk
from .table import DELTA, FOCUSED, SPOT

FAR = 1.5  # lamp and sphere must be this much farther apart than their radii touch, to aim from a disk between


@inlined
def toward(o, center, radius, u0, u1):
    """Direction from o uniform in the cone that a sphere fills; over the whole sphere from inside it."""
    r = sub(center, o)
    d2 = dot(r, r)
    if d2 <= radius * radius:
        return square_to_sphere(u0, u1)
    local = square_to_cone(u0, u1, one_minus_cos(radius * radius / d2))
    return to_world(local, scale(r, 1.0 / math.sqrt(d2)))


@inlined
def toward_pdf_w(o, center, radius, d):
    """Density of `toward` in solid angle."""
    r = sub(center, o)
    d2 = dot(r, r)
    if d2 <= radius * radius:
        return INV_4PI
    h = one_minus_cos(radius * radius / d2)
    # 1 - cos of the angle to the axis, from the chord between the unit vectors
    chord = sub(d, scale(r, 1.0 / math.sqrt(d2)))
    return 1.0 / (2.0 * math.pi * h) if 0.5 * dot(chord, chord) <= h else 0.0


@inlined
def filled(o, center, radius):
    """1 - cos of the half angle that a sphere fills seen from o; 2 from inside."""
    r = sub(center, o)
    d2 = dot(r, r)
    return 2.0 if d2 <= radius * radius else one_minus_cos(radius * radius / d2)


@inlined
def spot_is_narrower(lights, l, center, radius):
    """Whether l is a spot whose cone is narrower than what the sphere fills."""
    return lights.kind[l] == SPOT and 1.0 - lights.cone[l, 0] < filled(load3(lights.position, l), center, radius)


@inlined
def spread_is_narrower(lights, l, o, center, radius):
    """Whether l is an area lamp whose spread is narrower than what the sphere fills seen from its point o."""
    if not lights.flags[l] & FOCUSED:
        return False
    return 1.0 - math.sqrt(max(0.0, 1.0 - lights.cone[l, 2])) < filled(o, center, radius)


@inlined
def area_toward(lights, l, o, center, radius, u0, u1):
    """Direction from the point o of an area lamp with a width, toward a sphere or within the lamp's spread."""
    if spread_is_narrower(lights, l, o, center, radius):
        return area_direction(lights, l, u0, u1)
    return toward(o, center, radius, u0, u1)


@inlined
def area_toward_pdf_w(lights, l, o, center, radius, d):
    """Density of `area_toward` in solid angle, of directions that meet the sphere; 0 of others."""
    cone = toward_pdf_w(o, center, radius, d)
    if cone == 0.0 or not spread_is_narrower(lights, l, o, center, radius):
        return cone
    cosine = dot(d, load3(lights.normal, l))
    return cosine / (math.pi * lights.cone[l, 2]) if area_gain(lights, l, cosine) > 0.0 else 0.0


@inlined
def beam_line_pdf(lights, l, center, radius, x, d):
    """Density of a line of parallel rays, drawn from the sphere's disk or the lamp, whichever is smaller, per m^2."""
    return max(disk_line_pdf(center, radius, x, d), 1.0 / lights.size[l, 2]) if crosses(x, d, center, radius) else 0.0


@inlined
def crosses(o, d, center, radius):
    """Whether the line (o, d) passes within radius of center."""
    r = sub(o, center)
    along = dot(r, d)
    across = madd(r, -along, d)
    return dot(across, across) <= radius * radius


@inlined
def gate(lights, l, center, radius):
    """The disk about a lamp, across the way to a sphere, through which all lines from one to the other pass.

    (gate radius, unit axis, distance); radius 0: too close for such a disk.
    """
    r = sub(center, load3(lights.position, l))
    distance = math.sqrt(dot(r, r))
    reach = lights.size[l, 0] + radius
    if distance <= FAR * reach:
        return 0.0, (0.0, 0.0, 1.0), distance
    sine = reach / distance
    return lights.size[l, 0] / math.sqrt(1.0 - sine * sine), scale(r, 1.0 / distance), distance


@inlined
def round_line(lights, l, center, radius, u0, u1, u2, u3):
    """A line from a point or spot lamp toward a sphere: (x, d), x any point of it; covers all lines between them."""
    position = load3(lights.position, l)
    if spot_is_narrower(lights, l, center, radius):
        d, _ = round_direction(lights, l, u2, u3)
        return disk_point(position, lights.size[l, 0], d, u0, u1), d
    if lights.flags[l] & DELTA:
        return position, toward(position, center, radius, u2, u3)
    opening, axis, _ = gate(lights, l, center, radius)
    if opening > 0.0:
        x, y = square_to_disk(u0, u1)
        o = add(position, to_world((opening * x, opening * y, 0.0), axis))
        return o, toward(o, center, radius, u2, u3)
    d = toward(position, center, radius + lights.size[l, 0], u2, u3)
    return disk_point(position, lights.size[l, 0], d, u0, u1), d


@inlined
def round_line_pdf(lights, l, center, radius, x, d):
    """Density of `round_line` for the line (x, d) that meets the sphere, per m^2 across it and sr; a point: per sr."""
    position = load3(lights.position, l)
    if spot_is_narrower(lights, l, center, radius):
        ahead = dot(sub(center, position), d) > -radius
        if not ahead or not crosses(x, d, center, radius):
            return 0.0
        return round_direction_pdf_w(lights, l, d) / round_disk(lights, l)
    if lights.flags[l] & DELTA:
        return toward_pdf_w(position, center, radius, d)
    opening, axis, _ = gate(lights, l, center, radius)
    if opening == 0.0:
        inverse_area = 1.0 / (math.pi * lights.size[l, 0] * lights.size[l, 0])
        return inverse_area * toward_pdf_w(position, center, radius + lights.size[l, 0], d)
    cosine = dot(axis, d)
    if cosine <= 0.0:
        return 0.0
    r = sub(position, x)
    o = madd(x, dot(r, axis) / cosine, d)
    off = sub(o, position)
    if dot(off, off) > opening * opening:
        return 0.0
    return toward_pdf_w(o, center, radius, d) / (math.pi * opening * opening * cosine)


@inlined
def distant_line(lights, l, center, radius, u0, u1, u2, u3):
    """A line of a sun or the world, of its photons' directions, through a sphere: (x, d, radiance over density)."""
    d, le = distant_direction(lights, l, u2, u3)
    return disk_point(center, radius, d, u0, u1), d, le


@inlined
def disk_line_pdf(center, radius, x, d):
    """Density of a line through a sphere's disk across it, per m^2."""
    return 1.0 / (math.pi * radius * radius) if crosses(x, d, center, radius) else 0.0
