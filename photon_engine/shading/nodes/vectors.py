"""Nodes on vectors: Vector Math, Mapping, Combine and Separate XYZ, Vector Rotate, Normal, Checker, Gradient."""

from __future__ import annotations

import numpy as np

from ..registry import f32, node
from .scalars import divide, floored_modulo, power, truncated_modulo

ONE = f32(1.0)


def dot(a, b):
    """Inner product, (n,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def normalize(v):
    """Vectors of length 1; zero vectors stay zero."""
    size = np.sqrt(dot(v, v))
    return v * (ONE / np.where(size > 0.0, size, ONE))


def cross(a, b):
    """Outer product."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def refract(a, n, eta):
    """Direction a refracted at the unit normal n; zero when totally reflected."""
    c = dot(n, a)
    k = ONE - eta * eta * (ONE - c * c)
    bent = eta * a - (eta * c + np.sqrt(np.maximum(k, 0.0))) * n
    return np.where(k < 0.0, f32(0.0), bent)


def reflect(a, n):
    """A mirrored by the plane with unit normal n."""
    return a - 2.0 * dot(a, n) * n


VECTOR_MATH = {
    "ADD": lambda a, b, c, s: a + b,
    "SUBTRACT": lambda a, b, c, s: a - b,
    "MULTIPLY": lambda a, b, c, s: a * b,
    "DIVIDE": lambda a, b, c, s: divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c, s: a * b + c,
    "CROSS_PRODUCT": lambda a, b, c, s: cross(a, b),
    "PROJECT": lambda a, b, c, s: divide(dot(a, b), dot(b, b)) * b,
    "REFLECT": lambda a, b, c, s: reflect(a, normalize(b)),
    "REFRACT": lambda a, b, c, s: refract(a, normalize(b), s),
    "FACEFORWARD": lambda a, b, c, s: np.where(dot(c, b) < 0.0, a, -a),
    "SCALE": lambda a, b, c, s: a * s,
    "NORMALIZE": lambda a, b, c, s: normalize(a),
    "ABSOLUTE": lambda a, b, c, s: np.abs(a),
    "POWER": lambda a, b, c, s: power(a, b),
    "SIGN": lambda a, b, c, s: np.sign(a),
    "MINIMUM": lambda a, b, c, s: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c, s: np.maximum(a, b),
    "ROUND": lambda a, b, c, s: np.floor(a + f32(0.5)),
    "FLOOR": lambda a, b, c, s: np.floor(a),
    "CEIL": lambda a, b, c, s: np.ceil(a),
    "FRACTION": lambda a, b, c, s: a - np.floor(a),
    "MODULO": lambda a, b, c, s: truncated_modulo(a, b),
    "WRAP": lambda a, b, c, s: floored_modulo(a - c, b - c) + c,
    "SNAP": lambda a, b, c, s: np.floor(divide(a, b)) * b,
    "SINE": lambda a, b, c, s: np.sin(a),
    "COSINE": lambda a, b, c, s: np.cos(a),
    "TANGENT": lambda a, b, c, s: np.tan(a),
}
VECTOR_TO_VALUE = {
    "DOT_PRODUCT": dot,
    "DISTANCE": lambda a, b: np.sqrt(dot(a - b, a - b)),
    "LENGTH": lambda a, b: np.sqrt(dot(a, a)),
}


@node("ShaderNodeVectorMath")
def vector_math(x, props, points):
    """One of Blender's vector operations; undefined results are 0."""
    operation, a, b = props["operation"], x["Vector"], x.get("Vector_001")
    if operation in VECTOR_TO_VALUE:
        return {"Value": VECTOR_TO_VALUE[operation](a, b)}
    return {"Vector": VECTOR_MATH[operation](a, b, x.get("Vector_002"), x.get("Scale"))}


def euler_matrix(rotation):
    """Matrices (3, 3, n | 1) of XYZ Euler angles (3, n | 1): about X first."""
    cx, cy, cz = np.cos(rotation)
    sx, sy, sz = np.sin(rotation)
    return np.array([
        [cy * cz, sy * sx * cz - cx * sz, sy * cx * cz + sx * sz],
        [cy * sz, sy * sx * sz + cx * cz, sy * cx * sz - sx * cz],
        [-sy, cy * sx, cy * cx],
    ])


def rotate(matrix, v):
    """M v with M (3, 3, n | 1) and v (3, n | 1)."""
    if matrix.shape[2] == 1:
        return matrix[:, :, 0] @ v
    return np.stack([dot(row, v) for row in matrix])


@node("ShaderNodeMapping")
def mapping(x, props, points):
    """Move, turn and scale a point, a texture (the inverse), a vector or a normal."""
    v, kind = x["Vector"], props.get("vector_type", "POINT")
    matrix, scale = euler_matrix(x["Rotation"]), x["Scale"]
    if kind == "POINT":
        return {"Vector": rotate(matrix, v * scale) + x["Location"]}
    if kind == "TEXTURE":
        return {"Vector": divide(rotate(matrix.transpose(1, 0, 2), v - x["Location"]), scale)}
    if kind == "VECTOR":
        return {"Vector": rotate(matrix, v * scale)}
    return {"Vector": normalize(rotate(matrix, divide(v, scale)))}


@node("ShaderNodeVectorRotate")
def vector_rotate(x, props, points):
    """Turn a vector about a centre, by an axis and angle or by Euler angles."""
    kind, center = props.get("rotation_type", "AXIS_ANGLE"), x["Center"]
    v = x["Vector"] - center
    sign = f32(-1.0 if props.get("invert") else 1.0)
    if kind == "EULER_XYZ":
        matrix = euler_matrix(x["Rotation"])
        return {"Vector": rotate(matrix.transpose(1, 0, 2) if props.get("invert") else matrix, v) + center}
    fixed = {"X_AXIS": [1.0, 0.0, 0.0], "Y_AXIS": [0.0, 1.0, 0.0], "Z_AXIS": [0.0, 0.0, 1.0]}
    axis = np.array(fixed[kind], f32)[:, None] if kind in fixed else normalize(x["Axis"])
    c, s = np.cos(x["Angle"]), np.sin(x["Angle"]) * sign
    turned = v * c + cross(axis, v) * s + axis * dot(axis, v) * (ONE - c)
    return {"Vector": np.where(dot(axis, axis) > 0.0, turned, v) + center}


@node("ShaderNodeSeparateXYZ")
def separate_xyz(x, props, points):
    """Components of a vector."""
    return dict(zip("XYZ", x["Vector"], strict=True))


@node("ShaderNodeCombineXYZ")
def combine_xyz(x, props, points):
    """A vector from components."""
    return {"Vector": np.stack(np.broadcast_arrays(x["X"], x["Y"], x["Z"]))}


@node("ShaderNodeNormal")
def normal(x, props, points):
    """A fixed direction, and its cosine with the input."""
    direction = normalize(np.asarray(props.get("value", (0.0, 0.0, 1.0)), f32)[:3, None])
    return {"Normal": direction, "Dot": dot(direction, normalize(x["Normal"]))}


@node("PhotonConvert")
def convert_only(x, props, points):
    """A value that passed a socket of another type, which the input has already converted."""
    return {"Value": x["Value"]}
