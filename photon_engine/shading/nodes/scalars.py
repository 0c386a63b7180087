"""Nodes from numbers to numbers: Value, Math, Clamp, Map Range, Float mixing."""

from __future__ import annotations

import numpy as np

from ..registry import constant, f32, node

EPSILON = np.float32(1.1920929e-07)


def divide(a, b):
    """a / b, and 0 where b = 0."""
    good = b != 0.0
    if good.all():  # numpy's masked loops take seven times as long
        return a / b
    return np.where(good, a / np.where(good, b, f32(1.0)), f32(0.0))


def power(a, b):
    """a^b, and 0 for a negative base with a broken exponent."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        value = np.power(a, b)
    value = np.where((a == 0.0) & (b != 0.0), f32(0.0), value)
    return np.where((a < 0.0) & (b != np.trunc(b)), f32(0.0), value)


def logarithm(a, b):
    """Logarithm of a to base b, and 0 outside its domain."""
    good = (a > 0.0) & (b > 0.0)
    return np.where(good, divide(np.log(np.where(good, a, f32(1.0))), np.log(np.where(good, b, f32(2.0)))), f32(0.0))


def inverse_sqrt(a):
    """1 / sqrt(a), and 0 for a <= 0."""
    return divide(np.ones_like(a), np.sqrt(np.maximum(a, 0.0)))


def floored_modulo(a, b):
    """A modulo b with the sign of b, and 0 where b = 0."""
    return np.where(b != 0.0, a - np.floor(divide(a, b)) * b, f32(0.0))


def truncated_modulo(a, b):
    """A modulo b with the sign of a, and 0 where b = 0."""
    return np.where(b != 0.0, np.fmod(a, np.where(b != 0.0, b, f32(1.0))), f32(0.0))


def wrap(a, high, low):
    """A moved by whole ranges into [low, high)."""
    span = high - low
    return np.where(span != 0.0, a - span * np.floor(divide(a - low, span)), low)


def pingpong(a, b):
    """A triangle wave of height b."""
    t = divide(a - b, 2.0 * b)
    return np.where(b != 0.0, np.abs((t - np.floor(t)) * b * 2.0 - b), f32(0.0))


def smooth_minimum(a, b, k):
    """Minimum rounded within a distance k (cubic)."""
    h = divide(np.maximum(k - np.abs(a - b), 0.0), k)
    return np.minimum(a, b) - h * h * h * k * f32(1.0 / 6.0)


def as_float(test):
    """1.0 where true."""
    return test.astype(f32)


MATH = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: power(a, b),
    "LOGARITHM": lambda a, b, c: logarithm(a, b),
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0.0)),
    "INVERSE_SQRT": lambda a, b, c: inverse_sqrt(a),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: as_float(a < b),
    "GREATER_THAN": lambda a, b, c: as_float(a > b),
    "SIGN": lambda a, b, c: np.sign(a),
    "COMPARE": lambda a, b, c: as_float((a == b) | (np.abs(a - b) <= np.maximum(c, EPSILON))),
    "SMOOTH_MIN": smooth_minimum,
    "SMOOTH_MAX": lambda a, b, c: -smooth_minimum(-a, -b, c),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "TRUNC": lambda a, b, c: np.trunc(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: truncated_modulo(a, b),
    "FLOORED_MODULO": lambda a, b, c: floored_modulo(a, b),
    "WRAP": wrap,
    "SNAP": lambda a, b, c: np.floor(divide(a, b)) * b,
    "PINGPONG": lambda a, b, c: pingpong(a, b),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "ARCSINE": lambda a, b, c: np.arcsin(np.clip(a, -1.0, 1.0)),
    "ARCCOSINE": lambda a, b, c: np.arccos(np.clip(a, -1.0, 1.0)),
    "ARCTANGENT": lambda a, b, c: np.arctan(a),
    "ARCTAN2": lambda a, b, c: np.arctan2(a, b),
    "SINH": lambda a, b, c: np.sinh(a),
    "COSH": lambda a, b, c: np.cosh(a),
    "TANH": lambda a, b, c: np.tanh(a),
    "RADIANS": lambda a, b, c: a * f32(np.pi / 180.0),
    "DEGREES": lambda a, b, c: a * f32(180.0 / np.pi),
}


@node("ShaderNodeValue")
def value(x, props, points):
    """A number."""
    return {"Value": constant(props.get("value", 0.0), "VALUE")}


@node("ShaderNodeMath")
def math(x, props, points):
    """One of Blender's scalar operations; undefined results are 0, as in Cycles."""
    result = MATH[props["operation"]](x["Value"], x.get("Value_001"), x.get("Value_002"))
    return {"Value": np.clip(result, 0.0, 1.0) if props.get("use_clamp") else result}


@node("ShaderNodeClamp")
def clamp(x, props, points):
    """Limit to [min, max]; in RANGE mode the two may be exchanged."""
    low, high = x["Min"], x["Max"]
    if props.get("clamp_type") == "RANGE":
        low, high = np.minimum(low, high), np.maximum(low, high)
    return {"Result": np.minimum(np.maximum(x["Value"], low), high)}


def smoothstep(t):
    """3 t^2 - 2 t^3."""
    return (3.0 - 2.0 * t) * t * t


def smootherstep(t):
    """6 t^5 - 15 t^4 + 10 t^3."""
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


def remap(value, limits, mode, steps):
    """Where value lies between from_min and from_max, shaped by the mode; limits: (from_min, from_max)."""
    t = divide(value - limits[0], limits[1] - limits[0])
    if mode == "STEPPED":
        return np.where(steps > 0.0, divide(np.floor(t * (steps + 1.0)), steps), f32(0.0))
    if mode == "SMOOTHSTEP":
        return smoothstep(np.clip(t, 0.0, 1.0))
    if mode == "SMOOTHERSTEP":
        return smootherstep(np.clip(t, 0.0, 1.0))
    return t


@node("ShaderNodeMapRange")
def map_range(x, props, points):
    """Map one range onto another, numbers or vectors."""
    vector = props.get("data_type") == "FLOAT_VECTOR"
    names = ["Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3"]
    if not vector:
        names = ["Value", "From Min", "From Max", "To Min", "To Max", "Steps"]
    value, from_min, from_max, to_min, to_max, steps = (x.get(name) for name in names)
    mode = props.get("interpolation_type", "LINEAR")
    result = to_min + remap(value, (from_min, from_max), mode, steps) * (to_max - to_min)
    if not vector:  # Cycles' number version gives 0 for an empty range, its vector version to_min
        result = np.where(from_max != from_min, result, f32(0.0))
    if props.get("clamp") and (mode in ("LINEAR", "STEPPED")):
        result = np.clip(result, np.minimum(to_min, to_max), np.maximum(to_min, to_max))
    return {"Vector" if vector else "Result": result}
