"""Image lookups: closest, bilinear and bicubic, with Cycles' conventions at the borders."""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel

CLOSEST, LINEAR, CUBIC = 0, 1, 2
INTERPOLATIONS = {"Closest": CLOSEST, "Linear": LINEAR, "Cubic": CUBIC, "Smart": CUBIC}
REPEAT, EXTEND, CLIP, MIRROR = 0, 1, 2, 3
EXTENSIONS = {"REPEAT": REPEAT, "EXTEND": EXTEND, "CLIP": CLIP, "MIRROR": MIRROR}
DECODE, UNPREMULTIPLY = 1, 2  # flags


def srgb_to_linear(x: np.ndarray) -> np.ndarray:
    """The sRGB transfer curve, decoding [IEC 61966-2-1]."""
    x = np.asarray(x, np.float64)
    return np.where(x <= 0.04045, x / 12.92, ((np.maximum(x, 0.0) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(x: np.ndarray) -> np.ndarray:
    """The sRGB transfer curve, encoding [IEC 61966-2-1]."""
    x = np.asarray(x, np.float64)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0) ** (1.0 / 2.4) - 0.055)


# linear interpolation of 4097 knots errs by at most h^2/8 max|f''| = 2.4e-8 in [0, 1], below float32
DECODE_TABLE = srgb_to_linear(np.linspace(0.0, 1.0, 4097)).astype(np.float32)


@kernel
def decode(x, table):
    """The sRGB curve at one value, by the table inside [0, 1]."""
    if 0.0 <= x < 1.0:
        s = x * 4096.0
        i = int(s)
        t = s - i
        return (1.0 - t) * table[i] + t * table[i + 1]
    if x < 0.0:
        return x / 12.92
    return ((x + 0.055) / 1.055) ** 2.4


@kernel
def wrap(i, n, extension):
    """Index of a texel outside [0, n) by the extension mode; -1: outside of a clipped image."""
    if 0 <= i < n:
        return i
    if extension == REPEAT:
        return i - n if n <= i < 2 * n else i % n
    if extension == EXTEND:
        return 0 if i < 0 else n - 1
    if extension == MIRROR:
        m = (i if i >= 0 else -1 - i) % (2 * n)
        return 2 * n - 1 - m if m >= n else m
    return -1


@kernel
def reduce(i, n, extension):
    """A whole float index moved into one period, exactly, without the slow integer division of `wrap`."""
    if extension == REPEAT:
        return i - n * math.floor(i / n)
    if extension == MIRROR:
        return i - 2 * n * math.floor(i / (2 * n))
    return i


@kernel
def cubic_weights(t):
    """Weights of the four knots around t of a uniform cubic B-spline."""
    return (
        (((-1.0 / 6.0) * t + 0.5) * t - 0.5) * t + 1.0 / 6.0,
        ((0.5 * t - 1.0) * t) * t + 2.0 / 3.0,
        ((-0.5 * t + 0.5) * t + 0.5) * t + 1.0 / 6.0,
        (1.0 / 6.0) * t * t * t,
    )


@kernel
def sample_linear(pixels, x, y, extension):
    """Bilinear mean of four texels around (x, y) in texels, rgba; texel centres lie at halves."""
    height, width = pixels.shape[0], pixels.shape[1]
    fx, fy = math.floor(x - 0.5), math.floor(y - 0.5)
    tx, ty = x - 0.5 - fx, y - 0.5 - fy
    fx, fy = reduce(fx, width, extension), reduce(fy, height, extension)
    x0, x1 = wrap(int(fx), width, extension), wrap(int(fx) + 1, width, extension)
    r = g = b = a = 0.0
    for row in range(2):
        yy = wrap(int(fy) + row, height, extension)
        wy = ty if row else 1.0 - ty
        if yy < 0:
            continue
        if x0 >= 0:
            w = wy * (1.0 - tx)
            r += w * pixels[yy, x0, 0]
            g += w * pixels[yy, x0, 1]
            b += w * pixels[yy, x0, 2]
            a += w * pixels[yy, x0, 3]
        if x1 >= 0:
            w = wy * tx
            r += w * pixels[yy, x1, 0]
            g += w * pixels[yy, x1, 1]
            b += w * pixels[yy, x1, 2]
            a += w * pixels[yy, x1, 3]
    return r, g, b, a


@kernel
def sample_cubic(pixels, x, y, extension):
    """Cubic B-spline over sixteen texels around (x, y) in texels, rgba."""
    height, width = pixels.shape[0], pixels.shape[1]
    fx, fy = math.floor(x - 0.5), math.floor(y - 0.5)
    wx, wy = cubic_weights(x - 0.5 - fx), cubic_weights(y - 0.5 - fy)
    fx, fy = reduce(fx, width, extension), reduce(fy, height, extension)
    r = g = b = a = 0.0
    for row in range(4):
        yy = wrap(int(fy) - 1 + row, height, extension)
        if yy < 0:
            continue
        for col in range(4):
            xx = wrap(int(fx) - 1 + col, width, extension)
            if xx < 0:
                continue
            w = wy[row] * wx[col]
            r += w * pixels[yy, xx, 0]
            g += w * pixels[yy, xx, 1]
            b += w * pixels[yy, xx, 2]
            a += w * pixels[yy, xx, 3]
    return r, g, b, a


@kernel
def sample_closest(pixels, x, y, extension):
    """The texel that holds (x, y) in texels, rgba."""
    yy = wrap(math.floor(y), pixels.shape[0], extension)
    xx = wrap(math.floor(x), pixels.shape[1], extension)
    if xx < 0 or yy < 0:
        return 0.0, 0.0, 0.0, 0.0
    return float(pixels[yy, xx, 0]), float(pixels[yy, xx, 1]), float(pixels[yy, xx, 2]), float(pixels[yy, xx, 3])


@kernel
def sample_image_rows(pixels, scale, uv, mode, extension, flags, table, out):
    """Image lookups of a batch.

    pixels : (H, W, 4) f32 or u8, bottom row first, premultiplied;  scale : 1, or 1/255 for bytes
    uv : (2 or 3, n) f32, (0, 0) the lower left corner
    flags : UNPREMULTIPLY divides colour by alpha, DECODE then applies the sRGB curve;  out : (4, n) f32
    Coordinates beyond 2^30 texels or not finite give the pixel of the origin.
    """
    height, width = pixels.shape[0], pixels.shape[1]
    for i in range(uv.shape[1]):
        x, y = float(uv[0, i]) * width, float(uv[1, i]) * height
        if not (abs(x) < 1073741824.0 and abs(y) < 1073741824.0):
            x, y = 0.5, 0.5
        if mode == LINEAR:
            r, g, b, a = sample_linear(pixels, x, y, extension)
        elif mode == CUBIC:
            r, g, b, a = sample_cubic(pixels, x, y, extension)
        else:
            r, g, b, a = sample_closest(pixels, x, y, extension)
        r, g, b, a = r * scale, g * scale, b * scale, a * scale
        if flags & UNPREMULTIPLY and a != 0.0 and a != 1.0:
            r, g, b = r / a, g / a, b / a
        if flags & DECODE:
            r, g, b = decode(r, table), decode(g, table), decode(b, table)
        out[0, i] = r
        out[1, i] = g
        out[2, i] = b
        out[3, i] = a


def sample_image(pixels, uv, mode, extension, flags):
    """Image lookups of a batch, (4, n) f32; see sample_image_rows."""
    out = np.empty((4, uv.shape[1]), np.float32)
    scale = 1.0 / 255.0 if pixels.dtype == np.uint8 else 1.0
    uv = np.ascontiguousarray(uv, np.float32)
    sample_image_rows(pixels, scale, uv, mode, extension, flags, DECODE_TABLE, out)
    return out
