"""Between linear RGB and its HSV and HSL forms, rows (n, 3)."""

from __future__ import annotations

import numpy as np

from ..registry import f32


def _hue(rgb, high, span):
    """Hue in [0, 1) and 0 for grey."""
    r, g, b = rgb[:, 0], rgb[:, 1], rgb[:, 2]
    safe = np.where(span != 0.0, span, f32(1.0))
    h = np.where(r == high, (g - b) / safe, np.where(g == high, 2.0 + (b - r) / safe, 4.0 + (r - g) / safe))
    h = h * f32(1.0 / 6.0)
    return np.where(span != 0.0, np.where(h < 0.0, h + f32(1.0), h), f32(0.0))


def rgb_to_hsv(rgb):
    """Hue, saturation, value [Smith 1978]."""
    high, low = rgb.max(axis=1), rgb.min(axis=1)
    span = np.where(high != 0.0, high - low, f32(0.0))
    s = span / np.where(high != 0.0, high, f32(1.0))
    return np.stack([_hue(rgb, high, span), s, high], axis=1)


def hsv_to_rgb(hsv):
    """Inverse of rgb_to_hsv; channel k is v (1 - s clamp(min(m, 4 - m), 0, 1)) with m = (5, 3, 1)[k] + 6 h mod 6."""
    h, s, v = hsv[:, 0:1], hsv[:, 1:2], hsv[:, 2:3]
    m = np.mod(np.array([5.0, 3.0, 1.0], f32) + 6.0 * h, f32(6.0))
    return v - v * s * np.clip(np.minimum(m, 4.0 - m), 0.0, 1.0)


def rgb_to_hsl(rgb):
    """Hue, saturation, lightness."""
    high, low = rgb.max(axis=1), rgb.min(axis=1)
    span, light = high - low, np.minimum(f32(1.0), (high + low) * f32(0.5))
    rest = np.where(light > 0.5, 2.0 - high - low, high + low)
    s = np.where(span != 0.0, span / np.where(rest != 0.0, rest, f32(1.0)), f32(0.0))
    return np.stack([_hue(rgb, high, span), s, light], axis=1)


def hsl_to_rgb(hsl):
    """Inverse of rgb_to_hsl."""
    h6, s, light = hsl[:, 0:1] * f32(6.0), hsl[:, 1:2], hsl[:, 2:3]
    wave = np.abs(h6 - np.array([3.0, 2.0, 4.0], f32)) * np.array([1.0, -1.0, -1.0], f32)
    pure = np.clip(wave + np.array([-1.0, 2.0, 2.0], f32), 0.0, 1.0)
    return (pure - f32(0.5)) * ((f32(1.0) - np.abs(2.0 * light - 1.0)) * s) + light
