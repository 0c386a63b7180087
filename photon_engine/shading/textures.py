"""Image lookups: closest, bilinear and bicubic, with Cycles' conventions at the borders.

A batch goes through in steps: `place` finds along each axis which texels count and how much (vector instructions
do it), a loop of a few instructions fetches them, and colours are divided by alpha and decoded channel by channel.
So that the processor waits for the texels of many hits at once: with all in one loop a lookup took 2.5 times as long.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import kernel

CLOSEST, LINEAR, CUBIC = 0, 1, 2
INTERPOLATIONS = {"Closest": CLOSEST, "Linear": LINEAR, "Cubic": CUBIC, "Smart": CUBIC}
REPEAT, EXTEND, CLIP, MIRROR = 0, 1, 2, 3
EXTENSIONS = {"REPEAT": REPEAT, "EXTEND": EXTEND, "CLIP": CLIP, "MIRROR": MIRROR}
DECODE, UNPREMULTIPLY = 1, 2  # flags
TAPS = {CLOSEST: (0,), LINEAR: (0, 1), CUBIC: (-1, 0, 1, 2)}  # texels along an axis that count
FARTHEST = 1073741824.0  # texels from the origin


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
        i = np.uint32(s)
        t = s - i
        return (1.0 - t) * table[i] + t * table[i + np.uint32(1)]
    if x < 0.0:
        return x / 12.92
    return ((x + 0.055) / 1.055) ** 2.4


@kernel
def cubic_weight(t, k):
    """Weight of knot k in -1 ... 2 for a place t in [0, 1) between knots 0 and 1 of a uniform cubic B-spline."""
    if k == -1:
        return (((-1.0 / 6.0) * t + 0.5) * t - 0.5) * t + 1.0 / 6.0
    if k == 0:
        return ((0.5 * t - 1.0) * t) * t + 2.0 / 3.0
    if k == 1:
        return ((-0.5 * t + 0.5) * t + 0.5) * t + 1.0 / 6.0
    return (1.0 / 6.0) * t * t * t


@kernel
def fold(i, n, extension):
    """A whole float index moved into [0, n) by the extension mode; clipped images are extended here."""
    if extension == REPEAT:
        return i - n * math.floor(i / n)
    if extension == MIRROR:
        m = i - 2.0 * n * math.floor(i / (2.0 * n))
        return min(m, 2.0 * n - 1.0 - m)
    return min(max(i, 0.0), n - 1.0)


@kernel
def place(coordinates, size, mode, tap, extension, index, weight):
    """Which texel of `size` (a float) along an axis lookups read, and its weight; index, weight: (m,) i32, f32.

    coordinates : (m,) f32, 1 for all texels; not finite or farther than FARTHEST texels: as the middle of texel 0
    tap : which of the texels that count, 0 the one at or below the place
    """
    half = 0.0 if mode == CLOSEST else 0.5
    for i in range(len(coordinates)):
        x = float(coordinates[i]) * size
        x = (x if abs(x) < FARTHEST else 0.5) - half
        low = math.floor(x)
        t = x - low
        w = 1.0 if mode == CLOSEST else cubic_weight(t, tap) if mode == CUBIC else t if tap else 1.0 - t
        at = fold(low + tap, size, extension)
        weight[i] = w if extension != CLIP or at == low + tap else 0.0
        index[i] = np.int32(at)


@kernel
def fetch_bytes(texels, column, row, wx, wy, out):
    """Weighted sums of texels (H, W) u32, four bytes each, red lowest; column, row, wx, wy: (taps, m); out: (4, m)."""
    byte, taps = np.uint32(255), len(column)
    if taps == 2:
        for i in range(out.shape[1]):
            a = texels[np.uint32(row[0, i]), np.uint32(column[0, i])]
            b = texels[np.uint32(row[0, i]), np.uint32(column[1, i])]
            c = texels[np.uint32(row[1, i]), np.uint32(column[0, i])]
            d = texels[np.uint32(row[1, i]), np.uint32(column[1, i])]
            wa, wb = wx[0, i] * wy[0, i], wx[1, i] * wy[0, i]
            wc, wd = wx[0, i] * wy[1, i], wx[1, i] * wy[1, i]
            for k in range(4):
                s = np.uint32(8 * k)
                out[k, i] = (
                    wa * ((a >> s) & byte) + wb * ((b >> s) & byte) + wc * ((c >> s) & byte) + wd * ((d >> s) & byte)
                )
        return
    for i in range(out.shape[1]):
        r = g = b = a = np.float32(0.0)
        for j in range(taps):
            for k in range(taps):
                texel = texels[np.uint32(row[j, i]), np.uint32(column[k, i])]
                w = wy[j, i] * wx[k, i]
                r += w * (texel & byte)
                g += w * ((texel >> np.uint32(8)) & byte)
                b += w * ((texel >> np.uint32(16)) & byte)
                a += w * (texel >> np.uint32(24))
        out[0, i], out[1, i], out[2, i], out[3, i] = r, g, b, a


@kernel
def fetch_floats(pixels, column, row, wx, wy, out):
    """Weighted sums of pixels (H, W, 4) f32; as fetch_bytes."""
    taps = len(column)
    for i in range(out.shape[1]):
        r = g = b = a = 0.0
        for j in range(taps):
            y = np.uint32(row[j, i])
            for k in range(taps):
                x = np.uint32(column[k, i])
                w = float(wy[j, i]) * wx[k, i]
                r += w * pixels[y, x, 0]
                g += w * pixels[y, x, 1]
                b += w * pixels[y, x, 2]
                a += w * pixels[y, x, 3]
        out[0, i], out[1, i], out[2, i], out[3, i] = r, g, b, a


@kernel
def finish(scale, flags, table, out):
    """Scale lookups (4, m) in place, then divide colour by alpha and apply the sRGB curve as the flags say."""
    for k in range(4):
        for i in range(out.shape[1]):
            out[k, i] *= scale
    if flags & UNPREMULTIPLY:
        for k in range(3):
            for i in range(out.shape[1]):
                a = out[3, i]
                out[k, i] = out[k, i] / (a if a != 0.0 else 1.0)
    if flags & DECODE:
        for k in range(3):
            for i in range(out.shape[1]):
                out[k, i] = decode(float(out[k, i]), table)


def sample_image(pixels, uv, mode, extension, flags):
    """Image lookups of a batch, (4, n) f32.

    pixels : (H, W, 4) f32 or u8, bottom row first, premultiplied
    uv : (2 or 3, n) f32, (0, 0) the lower left corner;  mode, extension : of INTERPOLATIONS and EXTENSIONS
    flags : UNPREMULTIPLY divides colour by alpha, DECODE then applies the sRGB curve
    A coordinate beyond 2^30 texels or not finite counts as that of the first texel.
    """
    uv = np.ascontiguousarray(uv, np.float32)
    n = uv.shape[1]
    height, width = pixels.shape[:2]
    taps = TAPS[mode]
    index = np.empty((2, len(taps), n), np.int32)
    weight = np.empty((2, len(taps), n), np.float32)
    for axis, size in enumerate((float(width), float(height))):
        for k, tap in enumerate(taps):
            place(uv[axis], size, mode, tap, extension, index[axis, k], weight[axis, k])
    out = np.empty((4, n), np.float32)
    if pixels.dtype == np.uint8:
        texels = np.ascontiguousarray(pixels).view("<u4")[:, :, 0]
        fetch_bytes(texels, index[0], index[1], weight[0], weight[1], out)
    else:
        fetch_floats(np.ascontiguousarray(pixels), index[0], index[1], weight[0], weight[1], out)
    finish(np.float32(1.0 / 255.0 if pixels.dtype == np.uint8 else 1.0), flags, DECODE_TABLE, out)
    return out


def texture_bytes(images) -> int:
    """Memory of the pixels of a scene's images [bytes]."""
    return sum(image.pixels.nbytes for image in images if image.pixels is not None)
