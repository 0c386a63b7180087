"""Bump, the displacement nodes and Tangent."""

from __future__ import annotations

import numpy as np

from ..registry import f32, node
from .geometry_inputs import columns, facing, matrices, surface_normal, to_object, to_world
from .vectors import cross, dot, normalize, rotate

ONE = f32(1.0)


@node("ShaderNodeBump", varies=True)
def bump(x, props, points):
    """The normal of a surface raised by a height along its normal N [Mikkelsen 2010, as Cycles does it].

        N' ~ |det| N - distance sign(det) sum_i (h_i - h) R_i / width

    R_x = dP_y x N, R_y = N x dP_x, det = dP_x . R_x; h_x, h_y: the height at p + width dP_x, p + width dP_y.
    """
    n, around = surface_normal(x, points), points.around
    if around is None or "Height dx" not in x:
        return {"Normal": n}
    dp_x, dp_y = (columns(v) for v in around.dp)
    r_x, r_y = cross(dp_y, n), cross(n, dp_x)
    det, h = dot(dp_x, r_x), x["Height"]
    gradient = (x["Height dx"] - h) * r_x + (x["Height dy"] - h) * r_y
    sign = np.sign(det) * (-ONE if props.get("invert") else ONE)
    bent = normalize(f32(props["width"]) * np.abs(det) * n - x["Distance"] * sign * gradient)
    strength = np.maximum(x["Strength"], 0.0)
    mixed = normalize(strength * bent + (ONE - strength) * n)
    return {"Normal": np.where(dot(bent, bent) > 0.0, mixed, n)}


@node("PhotonHeight", varies=True)
def height_of(x, props, points):
    """A displacement vector's height along the normal."""
    return {"Height": dot(x["Displacement"], facing(points))}


@node("ShaderNodeDisplacement", varies=True, needs={"objects"})
def displacement(x, props, points):
    """Along the normal by (height - midlevel) scale, in the object's units or in metres."""
    n, amount = surface_normal(x, points), (x["Height"] - x["Midlevel"]) * x["Scale"]
    if props.get("space", "OBJECT") == "WORLD":
        return {"Displacement": n * amount}
    return {"Displacement": direction(points, to_object(points, n) * amount)}


def vector_displacement_needs(item, used):
    """Tangents, in tangent space."""
    return {"objects", "normal_local", "tangent"} if item.props.get("space", "TANGENT") == "TANGENT" else {"objects"}


@node("ShaderNodeVectorDisplacement", varies=True, needs=vector_displacement_needs)
def vector_displacement(x, props, points):
    """By a vector in tangent, object or world space."""
    space = props.get("space", "TANGENT")
    offset = np.broadcast_to((x["Vector"] - x["Midlevel"]) * x["Scale"], points.ns.T.shape)
    if space == "WORLD":
        return {"Displacement": offset}
    if space == "TANGENT":
        tangent = columns(points.tangents[""])
        t, n = tangent[:3], to_object(points, facing(points))
        b = normalize(cross(n, t)) * tangent[3]
        offset = t * offset[0] + n * offset[1] + b * offset[2]
    return {"Displacement": direction(points, offset)}


def direction(points, v):
    """Vectors of the object's space in the world."""
    return rotate(matrices(points.objects.matrix, points), v)


def tangent_needs(item, used):
    """Tangents of a UV layer, or Generated coordinates."""
    if item.props.get("direction_type", "RADIAL") != "UV_MAP":
        return {"generated", "objects"}
    name = item.props.get("uv_map", "")
    return {"objects", f"tangent:{name}" if name else "tangent"}


@node("ShaderNodeTangent", varies=True, needs=tangent_needs)
def tangent(x, props, points):
    """Unit direction in the surface: along a UV layer's u, or round an axis of the object."""
    if props.get("direction_type", "RADIAL") == "UV_MAP":
        return {"Tangent": in_surface(points, columns(points.tangents[props.get("uv_map", "")][:, :3]))}
    return {"Tangent": in_surface(points, radial(points, props.get("axis", "Z")))}


def radial(points, axis: str = "Z"):
    """Direction round an axis through the middle of Generated space, object space (3, n), not normalised."""
    x, y, z = points.generated.T - f32(0.5)
    zero = np.zeros(len(x), f32)
    return np.stack({"X": [zero, -z, y], "Y": [-z, zero, x], "Z": [-y, x, zero]}[axis])


def in_surface(points, t):
    """An object-space direction in the world, turned into the plane of the shading normal, unit."""
    n = facing(points)
    return cross(n, normalize(cross(to_world(points, t), n)))
