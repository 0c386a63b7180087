"""Nodes that look values up in a table: Color Ramp, curves. Tables have Cycles' 256 entries and its rounding."""

from __future__ import annotations

import numpy as np

from ..registry import column, f32, node


def lookup(table, t, interpolate=True, extrapolate=False):
    """Value of a table (m,) or (m, C) at t (n,) in [0, 1]: the entry below, or linear between entries."""
    last = len(table) - 1
    s = np.clip(t, 0.0, 1.0) * f32(last)
    i = np.clip(s.astype(np.int32), 0, last)
    below = table[i]
    if not interpolate:
        return below
    frac = s - i
    if table.ndim == 2:
        frac = column(frac)
    value = (f32(1.0) - frac) * below + frac * table[np.minimum(i + 1, last)]
    if not extrapolate:
        return value
    under, over = np.minimum(t, 0.0) * f32(last), np.maximum(t - f32(1.0), 0.0) * f32(last)
    if table.ndim == 2:
        under, over = column(under), column(over)
    return value + (table[1] - table[0]) * under + (table[last] - table[last - 1]) * over


@node("ShaderNodeValToRGB")
def color_ramp(x, props, points):
    """A colour and alpha by a ramp sampled at 256 places."""
    ramp = props["color_ramp"]
    rgba = lookup(ramp["table"], x["Fac"], ramp["interpolation"] != "CONSTANT")
    return {"Color": rgba[:, :3], "Alpha": rgba[:, 3]}


@node("ShaderNodeFloatCurve")
def float_curve(x, props, points):
    """A number through a curve, mixed by the factor."""
    curve, t, value = props["mapping"], x["Factor"], x["Value"]
    place = (value - f32(curve["min_x"])) / f32(curve["max_x"] - curve["min_x"])
    out = lookup(curve["tables"][0], place, True, curve["extrapolate"])
    return {"Value": (f32(1.0) - t) * value + t * out}


def _triple(value, curve):
    """Each channel through its own curve."""
    place = (value - f32(curve["min_x"])) / f32(curve["max_x"] - curve["min_x"])
    parts = [lookup(curve["tables"][k], place[:, k], True, curve["extrapolate"]) for k in range(3)]
    return np.stack(parts, axis=1)


@node("ShaderNodeRGBCurve")
def rgb_curves(x, props, points):
    """A colour through curves for all and for each channel, mixed by the factor."""
    t = column(x["Fac"])
    return {"Color": (f32(1.0) - t) * x["Color"] + t * _triple(x["Color"], props["mapping"])}


@node("ShaderNodeVectorCurve")
def vector_curves(x, props, points):
    """A vector through a curve for each component, mixed by the factor."""
    t = column(x["Fac"])
    return {"Vector": (f32(1.0) - t) * x["Vector"] + t * _triple(x["Vector"], props["mapping"])}
