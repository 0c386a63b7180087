"""Radial Tiling: the plane in segments round the origin, along the sides of a polygon with rounded corners.

The number of sides need not be whole: the last segment is narrower then, and its corners are rounder. All angles are
counted from a segment's first edge, lengths in those of the polygon's inradius; formulas as in Blender's node.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..registry import f32, node

TURN = 2.0 * np.pi


class Wedge(NamedTuple):
    """What one segment's formulas take, each (n,): half its angle, the corner's angle, its roundness, its scale."""

    half: np.ndarray
    corner: np.ndarray
    rounded: np.ndarray
    scale: np.ndarray

    def straight(self) -> np.ndarray:
        """Angle by which the corner's spline is late."""
        return (1.0 - self.rounded) * self.corner

    def width(self, length) -> np.ndarray:
        """Half the segment's width where it is this far out along its middle."""
        s = self.straight()
        across = length * np.tan(self.half - self.corner) + s * (0.5 * length + 0.5) + self.rounded * self.corner
        return self.scale * across

    def on_side(self, length, angle) -> tuple[np.ndarray, np.ndarray]:
        """(distance along the middle, distance from it) in front of a straight side."""
        along = length * np.cos(self.half - angle)
        return self.scale * along, self.scale * along * np.tan(np.abs(self.half - angle))

    def on_corner(self, length, inside) -> np.ndarray:
        """Distance from the middle, `inside` the corner by this angle."""
        s, out = self.straight(), length * np.cos(self.half - self.corner)
        bent = out * inside + 0.5 * (1.0 - out) * inside * inside / s
        beyond = np.where(inside < s, bent, s * (0.5 * out - 0.5) + inside)
        return self.scale * (length * np.sin(self.half - self.corner) + beyond)

    def corner_width(self, length, along, inside) -> np.ndarray:
        """`width` within the corner: between that of the side and that of the arc."""
        s, turned = self.straight(), self.half - self.corner
        arc = length * np.sin(turned) + s * (0.5 * length * np.cos(turned) + 0.5) + self.rounded * self.corner
        t = inside / self.corner
        return self.width(along) * (1.0 - t) + self.scale * arc * t


class Corner(NamedTuple):
    """The circle of a rounded corner: centre, radius, and the angle at which it ends."""

    x: np.ndarray
    y: np.ndarray
    radius: np.ndarray

    def reach(self, angle) -> np.ndarray:
        """Distance of the arc in a direction."""
        toward = np.cos(angle) * self.x + np.sin(angle) * self.y
        return toward + np.sqrt(toward * toward + self.radius**2 - self.x**2 - self.y**2)


class Place(NamedTuple):
    """Where points lie, each (n,): distance, angle from the x axis, and that in its segment; the signed angle."""

    length: np.ndarray
    around: np.ndarray
    angle: np.ndarray
    signed: np.ndarray


def tile(x, y, sides, roundness) -> tuple[np.ndarray, ...]:
    """(distance along the middle, signed distance from it, half width there, half width at 1, middle's angle), (n,)."""
    half = np.pi / sides
    signed = np.arctan2(y, x)
    around = signed + TURN * (y < 0.0)
    number = np.floor(around / (2.0 * half))
    at = Place(np.hypot(x, y), around, around - number * 2.0 * half, signed)
    one = np.ones_like(half)
    plain = Wedge(half, half - np.arctan((1.0 - roundness) * np.tan(half)), roundness, one)
    whole = sides == np.floor(sides)
    with np.errstate(all="ignore"):  # of branches that are not taken
        even = segments(at, plain)
        uneven = with_last(at, plain, np.pi - np.floor(sides) * half)
    *found, middle = (np.where(whole, a, b) for a, b in zip(even, uneven, strict=True))
    return (*found, number * 2.0 * half + middle)


def segments(at: Place, wedge: Wedge) -> tuple[np.ndarray, ...]:
    """All segments alike: as `tile`, the middle's angle in the segment."""
    near = np.where(at.angle > wedge.half, at.angle - 2.0 * wedge.half, at.angle)
    center = (1.0 - wedge.rounded) / np.cos(wedge.half)
    arc = Corner(center, np.zeros_like(center), wedge.rounded)
    along, across, width = corner_part(at, wedge, at.length / arc.reach(near), np.abs(near))
    side, from_side = wedge.on_side(at.length, at.angle)
    cut = np.abs(near) < wedge.corner
    sign = np.where(at.angle < wedge.half, -1.0, 1.0)
    most = np.tan(wedge.half - wedge.corner) + wedge.straight() + wedge.rounded * wedge.corner
    return (np.where(cut, along, side), sign * np.where(cut, across, from_side),
            np.where(cut, width, wedge.width(side)), most, wedge.half)  # fmt: skip


def corner_part(at: Place, wedge: Wedge, along, near) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(distance along the middle, distance from it, half width) in a corner; along: before the wedge's scale."""
    inside = wedge.corner - near
    return wedge.scale * along, wedge.on_corner(at.length, inside), wedge.corner_width(at.length, along, inside)


def with_last(at: Place, plain: Wedge, last_half) -> tuple[np.ndarray, ...]:
    """As `segments` where the last segment is narrower."""
    half, rho = plain.half, plain.rounded
    inner = last_half - np.arctan((1.0 - rho) * np.tan(last_half))
    radius = rho * np.tan(last_half) / np.tan(0.5 * (half + last_half))
    tip = 1.0 / np.cos(last_half - inner)
    arc = Corner(
        np.cos(inner) * tip - radius * np.cos(last_half), radius * np.sin(last_half) - np.sin(inner) * tip, radius
    )
    outer = np.arctan((arc.y + radius * np.sin(half)) / (arc.x + radius * np.cos(half)))
    scale = np.cos(half) / np.cos(last_half)
    beside = Wedge(half, outer, 1.0 - np.tan(half - outer) / np.tan(half), np.ones_like(half))
    last = Wedge(last_half, inner, rho, scale)
    end = TURN - 2.0 * last_half  # where the last segment begins
    side, from_side, side_width, most, _ = segments(at, plain)
    # next to the last segment's corners a plain one is as wide as these leave it
    first_half = (at.around < half) | (at.around >= end - half)
    flat, from_flat = plain.on_side(at.length, at.angle)
    is_flat = (at.around < plain.corner) | (at.around >= end - plain.corner)
    side, from_side = (
        np.where(is_flat, flat, side),
        np.where(is_flat, np.where(at.angle < half, -1.0, 1.0) * from_flat, from_side),
    )
    near_divider = np.minimum(at.angle, 2.0 * half - at.angle) < plain.corner
    side_width = np.where(is_flat | (first_half & ~near_divider), beside.width(flat), side_width)
    results = [(side, from_side, side_width, most, half)]
    sign = np.where(at.angle < last_half, -1.0, 1.0)
    along, across = last.on_side(at.length, at.angle)
    narrow = np.tan(last_half - inner) + scale * (last.straight() * (0.5 / scale + 0.5) + rho * inner)
    results.append((along, sign * across, last.width(along / scale), narrow, last_half))
    turned = np.where(
        (at.around >= end - outer) & (at.around < TURN - last_half), -(at.signed + 2.0 * last_half), at.signed
    )
    reached = at.length / arc.reach(turned)
    along, across, width = corner_part(at, last, reached, np.abs(turned))
    results.append((along, sign * across, width, narrow, last_half))
    along, across, width = corner_part(at, beside, scale * reached, np.abs(turned))
    results.append((along, np.where(at.angle < half, -1.0, 1.0) * across, width, most, half))
    regular = (at.around >= outer) & (at.around < end - outer)
    within = (at.around >= end + inner) & (at.around < TURN - inner)
    which = [regular, within, turned < 0.0]
    return tuple(np.select(which, [r[k] for r in results[:3]], results[3][k]) for k in range(5))


@node("ShaderNodeRadialTiling")
def radial_tiling(x, props, points):
    """Coordinates in a segment, its number, its width and its direction."""
    u, v = np.asarray(x["Vector"][:2], np.float64)
    sides = np.maximum(np.asarray(x["Sides"], np.float64), 2.0)
    roundness = np.clip(np.asarray(x["Roundness"], np.float64), 0.0, 1.0)
    u, v, sides, roundness = np.broadcast_arrays(u, v, sides, roundness)
    along, across, width, most, middle = tile(u, v, sides, roundness)
    digon = (sides == 2.0) & (roundness == 0.0)  # its sides never end
    across = np.where((u == 0.0) & (v == 0.0), 0.0, across)
    if props.get("normalize"):
        across = np.where(digon, across, across / np.where(width != 0.0, width, 1.0)) * 0.5 + 0.5
    else:
        along = along - 1.0
    number = np.floor(sides * (np.arctan2(v, u) / TURN + (v < 0.0)))
    return {
        "Segment Coordinates": np.stack([across, along, np.zeros_like(along)]).astype(f32),
        "Segment ID": number.astype(f32), "Segment Width": np.where(digon, 0.0, most).astype(f32),
        "Segment Rotation": middle.astype(f32),
    }  # fmt: skip
