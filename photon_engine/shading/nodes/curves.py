"""Nodes that look values up in a table: Color Ramp, curves. Tables have Cycles' 256 entries and its rounding."""

from __future__ import annotations

import numpy as np

from ...jit import kernel
from ..registry import f32, node


@kernel
def lookup_rows(table, t, interpolate, extrapolate, out):
    """Entries (C, n) of a table (m, C) at t (n,): the one below, linear between two, or on along the end's slope."""
    last = len(table) - 1
    for i in range(len(t)):
        s = float(t[i]) * last
        inside = min(max(s, 0.0), float(last)) if s == s else 0.0
        low = int(inside)
        high = min(low + 1, last)
        frac = inside - low if interpolate else 0.0
        beyond = s - inside if extrapolate and s == s else 0.0
        first = 0 if beyond < 0.0 else last - 1
        for k in range(table.shape[1]):
            value = (1.0 - frac) * table[low, k] + frac * table[high, k]
            if beyond != 0.0:
                value += (table[first + 1, k] - table[first, k]) * beyond
            out[k, i] = value


def lookup(table, t, interpolate=True, extrapolate=False):
    """Values of a table (m, C) at t (n,), (C, n) f32; see lookup_rows."""
    out = np.empty((table.shape[1], len(t)), f32)
    lookup_rows(table, np.ascontiguousarray(t, f32), interpolate, extrapolate, out)
    return out


@node("ShaderNodeValToRGB")
def color_ramp(x, props, points):
    """A colour and alpha by a ramp sampled at 256 places."""
    ramp = props["color_ramp"]
    rgba = lookup(ramp["table"], x["Fac"], ramp["interpolation"] != "CONSTANT")
    return {"Color": rgba[:3], "Alpha": rgba[3]}


@node("ShaderNodeFloatCurve")
def float_curve(x, props, points):
    """A number through a curve, mixed by the factor."""
    curve, t, value = props["mapping"], x["Factor"], x["Value"]
    place = (value - f32(curve["min_x"])) / f32(curve["max_x"] - curve["min_x"])
    out = lookup(curve["tables"][0][:, None], place, True, curve["extrapolate"])[0]
    return {"Value": (f32(1.0) - t) * value + t * out}


def _triple(value, curve):
    """Each channel through its own curve."""
    place = (value - f32(curve["min_x"])) / f32(curve["max_x"] - curve["min_x"])
    parts = [lookup(curve["tables"][k][:, None], place[k], True, curve["extrapolate"]) for k in range(3)]
    return np.concatenate(parts)


@node("ShaderNodeRGBCurve")
def rgb_curves(x, props, points):
    """A colour through curves for all and for each channel, mixed by the factor."""
    t = x["Fac"]
    return {"Color": (f32(1.0) - t) * x["Color"] + t * _triple(x["Color"], props["mapping"])}


@node("ShaderNodeVectorCurve")
def vector_curves(x, props, points):
    """A vector through a curve for each component, mixed by the factor."""
    t = x["Fac"]
    return {"Vector": (f32(1.0) - t) * x["Vector"] + t * _triple(x["Vector"], props["mapping"])}
