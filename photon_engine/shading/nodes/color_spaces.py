"""Between linear RGB and its HSV and HSL forms, components (3, n) [Smith 1978, Color Gamut Transform Pairs]."""

from __future__ import annotations

import math

import numpy as np

from ...jit import kernel
from ..registry import f32


@kernel
def hue_of(r, g, b, high, span):
    """Hue in [0, 1), 0 for grey; span: largest minus smallest channel."""
    if span == 0.0:
        return 0.0
    if r == high:
        h = (g - b) / span
    elif g == high:
        h = 2.0 + (b - r) / span
    else:
        h = 4.0 + (r - g) / span
    return h / 6.0 + 1.0 if h < 0.0 else h / 6.0


@kernel
def rgb_to_hsv_rows(rgb, out):
    """Hue, saturation, value of each row."""
    for i in range(rgb.shape[1]):
        r, g, b = float(rgb[0, i]), float(rgb[1, i]), float(rgb[2, i])
        high, low = max(r, max(g, b)), min(r, min(g, b))
        span = high - low if high != 0.0 else 0.0
        out[0, i] = hue_of(r, g, b, high, span)
        out[1, i] = span / high if high != 0.0 else 0.0
        out[2, i] = high


@kernel
def hsv_to_rgb_rows(hsv, out):
    """Inverse: channel k is v (1 - s clamp(min(m, 4 - m), 0, 1)) with m = (5, 3, 1)[k] + 6 h modulo 6."""
    for i in range(hsv.shape[1]):
        s, v = float(hsv[1, i]), float(hsv[2, i])
        for k in range(3):
            m = (5.0 - 2.0 * k) + 6.0 * float(hsv[0, i])
            m -= 6.0 * math.floor(m / 6.0)
            out[k, i] = v - v * s * max(0.0, min(1.0, min(m, 4.0 - m)))


@kernel
def rgb_to_hsl_rows(rgb, out):
    """Hue, saturation, lightness of each row."""
    for i in range(rgb.shape[1]):
        r, g, b = float(rgb[0, i]), float(rgb[1, i]), float(rgb[2, i])
        high, low = max(r, max(g, b)), min(r, min(g, b))
        span, light = high - low, min(1.0, 0.5 * (high + low))
        rest = 2.0 - high - low if light > 0.5 else high + low
        out[0, i] = hue_of(r, g, b, high, span)
        out[1, i] = span / rest if span != 0.0 and rest != 0.0 else 0.0
        out[2, i] = light


@kernel
def hsl_to_rgb_rows(hsl, out):
    """Inverse of rgb_to_hsl_rows."""
    for i in range(hsl.shape[1]):
        h6, light = 6.0 * float(hsl[0, i]), float(hsl[2, i])
        chroma = (1.0 - abs(2.0 * light - 1.0)) * float(hsl[1, i])
        out[0, i] = (min(1.0, max(0.0, abs(h6 - 3.0) - 1.0)) - 0.5) * chroma + light
        out[1, i] = (min(1.0, max(0.0, 2.0 - abs(h6 - 2.0))) - 0.5) * chroma + light
        out[2, i] = (min(1.0, max(0.0, 2.0 - abs(h6 - 4.0))) - 0.5) * chroma + light


def _rows(function):
    """The kernel as a function that allocates its result."""
    def convert(values):
        values = np.ascontiguousarray(values, f32)
        out = np.empty_like(values)
        function(values, out)
        return out

    convert.__doc__ = function.__doc__
    return convert


rgb_to_hsv = _rows(rgb_to_hsv_rows)
hsv_to_rgb = _rows(hsv_to_rgb_rows)
rgb_to_hsl = _rows(rgb_to_hsl_rows)
hsl_to_rgb = _rows(hsl_to_rgb_rows)
