"""The hashes behind Blender's procedural textures: 32-bit words from lattice cells or from the bits of floats."""

from __future__ import annotations

import numpy as np

from ...jit import kernel

START = 0xDEADBEEF + 13
TO_UNIT = 1.0 / 4294967295.0
PCG_TO_UNIT = 1.0 / 2147483647.0
SIGN_BIT = 0x80000000
LOW_BITS = np.uint32(0x7FFFFFFF)
PCG_FACTOR = np.uint32(1664525)
PCG_ADD = np.uint32(1013904223)


@kernel
def bits(x):
    """The bits of x as a float32."""
    return np.float32(x).view(np.uint32)


@kernel
def word(i):
    """An integer's low 32 bits."""
    return np.uint32(i)


@kernel
def rotate(x, k):
    """A word rotated left by k bits."""
    return np.uint32((x << k) | (x >> (32 - k)))


@kernel
def final_mix(a, b, c):
    """Bob Jenkins' final mix of three words, its third result [http://burtleburtle.net/bob/c/lookup3.c]."""
    c = np.uint32((c ^ b) - rotate(b, 14))
    a = np.uint32((a ^ c) - rotate(c, 11))
    b = np.uint32((b ^ a) - rotate(a, 25))
    c = np.uint32((c ^ b) - rotate(b, 16))
    a = np.uint32((a ^ c) - rotate(c, 4))
    b = np.uint32((b ^ a) - rotate(a, 14))
    return np.uint32((c ^ b) - rotate(b, 24))


@kernel
def hash1(x):
    """Hash of a word."""
    s = np.uint32(START + 4)
    return final_mix(np.uint32(s + x), s, s)


@kernel
def hash2(x, y):
    """Hash of two words."""
    s = np.uint32(START + 8)
    return final_mix(np.uint32(s + x), np.uint32(s + y), s)


@kernel
def hash3(x, y, z):
    """Hash of three words."""
    s = np.uint32(START + 12)
    return final_mix(np.uint32(s + x), np.uint32(s + y), np.uint32(s + z))


@kernel
def hash4(x, y, z, w):
    """Hash of four words: the mix of three before the final one [http://burtleburtle.net/bob/c/lookup3.c]."""
    s = np.uint32(START + 16)
    a, b, c = np.uint32(s + x), np.uint32(s + y), np.uint32(s + z)
    a = np.uint32(np.uint32(a - c) ^ rotate(c, 4))
    c = np.uint32(c + b)
    b = np.uint32(np.uint32(b - a) ^ rotate(a, 6))
    a = np.uint32(a + c)
    c = np.uint32(np.uint32(c - b) ^ rotate(b, 8))
    b = np.uint32(b + a)
    a = np.uint32(np.uint32(a - c) ^ rotate(c, 16))
    c = np.uint32(c + b)
    b = np.uint32(np.uint32(b - a) ^ rotate(a, 19))
    a = np.uint32(a + c)
    c = np.uint32(np.uint32(c - b) ^ rotate(b, 4))
    b = np.uint32(b + a)
    return final_mix(np.uint32(a + w), b, c)


@kernel
def random1(x):
    """A number in [0, 1] from a float."""
    return hash1(bits(x)) * TO_UNIT


@kernel
def random2(x, y):
    """A number in [0, 1] from two floats."""
    return hash2(bits(x), bits(y)) * TO_UNIT


@kernel
def random3(x, y, z):
    """A number in [0, 1] from three floats."""
    return hash3(bits(x), bits(y), bits(z)) * TO_UNIT


@kernel
def random4(x, y, z, w):
    """A number in [0, 1] from four floats."""
    return hash4(bits(x), bits(y), bits(z), bits(w)) * TO_UNIT


@kernel
def color_of(dims, p):
    """Three numbers in [0, 1] from the first `dims` floats of p (for one: the last)."""
    x, y, z, w = p
    if dims == 1:
        return (random1(w), random2(w, 1.0), random2(w, 2.0))
    if dims == 2:
        return (random2(x, y), random3(x, y, 1.0), random3(x, y, 2.0))
    if dims == 3:
        return (random3(x, y, z), random4(x, y, z, 1.0), random4(x, y, z, 2.0))
    return (random4(x, y, z, w), random4(z, x, w, y), random4(w, z, y, x))


@kernel
def arithmetic_shift(v):
    """A word shifted right by 16 with its sign."""
    return np.uint32((v >> 16) | (0xFFFF0000 if v & SIGN_BIT else 0))


@kernel
def pcg2(x, y):
    """Two 31-bit words [Jarzynski and Olano 2020, JCGT 9(3)], with signed shifts."""
    x, y = np.uint32(x * PCG_FACTOR + PCG_ADD), np.uint32(y * PCG_FACTOR + PCG_ADD)
    x = np.uint32(x + y * PCG_FACTOR)
    y = np.uint32(y + x * PCG_FACTOR)
    x, y = np.uint32(x ^ arithmetic_shift(x)), np.uint32(y ^ arithmetic_shift(y))
    x = np.uint32(x + y * PCG_FACTOR)
    y = np.uint32(y + x * PCG_FACTOR)
    return np.uint32(x & LOW_BITS), np.uint32(y & LOW_BITS)


@kernel
def pcg3(x, y, z):
    """Three 31-bit words [Jarzynski and Olano 2020, JCGT 9(3)], with signed shifts."""
    x, y = np.uint32(x * PCG_FACTOR + PCG_ADD), np.uint32(y * PCG_FACTOR + PCG_ADD)
    z = np.uint32(z * PCG_FACTOR + PCG_ADD)
    x = np.uint32(x + y * z)
    y = np.uint32(y + z * x)
    z = np.uint32(z + x * y)
    x, y = np.uint32(x ^ arithmetic_shift(x)), np.uint32(y ^ arithmetic_shift(y))
    z = np.uint32(z ^ arithmetic_shift(z))
    x = np.uint32(x + y * z)
    y = np.uint32(y + z * x)
    z = np.uint32(z + x * y)
    return np.uint32(x & LOW_BITS), np.uint32(y & LOW_BITS), np.uint32(z & LOW_BITS)


@kernel
def pcg4(x, y, z, w):
    """Four 31-bit words [Jarzynski and Olano 2020, JCGT 9(3)], with signed shifts."""
    x, y = np.uint32(x * PCG_FACTOR + PCG_ADD), np.uint32(y * PCG_FACTOR + PCG_ADD)
    z, w = np.uint32(z * PCG_FACTOR + PCG_ADD), np.uint32(w * PCG_FACTOR + PCG_ADD)
    x = np.uint32(x + y * w)
    y = np.uint32(y + z * x)
    z = np.uint32(z + x * y)
    w = np.uint32(w + y * z)
    x, y = np.uint32(x ^ arithmetic_shift(x)), np.uint32(y ^ arithmetic_shift(y))
    z, w = np.uint32(z ^ arithmetic_shift(z)), np.uint32(w ^ arithmetic_shift(w))
    x = np.uint32(x + y * w)
    y = np.uint32(y + z * x)
    z = np.uint32(z + x * y)
    w = np.uint32(w + y * z)
    return np.uint32(x & LOW_BITS), np.uint32(y & LOW_BITS), np.uint32(z & LOW_BITS), np.uint32(w & LOW_BITS)
