"""Random numbers spread evenly over neighbouring pixels: each pixel's are uniform, those of a square of pixels fill it.

Pixels in Morton's order take the points of Sobol's two-dimensional sequence in turn, so that each square of 2^k x 2^k
pixels has one point in each of its 4^k equal parts, whatever their shape [Ahmed and Wonka 2020, ACM TOG 39(6),
Screen-space blue-noise diffusion of Monte Carlo sampling error]. A key scrambles the sequence and its order by Owen's
nested permutations, made by hashes [Burley 2020, JCGT 9(4)]: points of different keys are independent, and the mean
over passes is as unbiased as with random numbers and has the same error bars. The errors of neighbours differ in
sign, which leaves less of them to a denoiser, or to an eye that looks from afar.
"""

from __future__ import annotations

import numpy as np

from ..jit import inlined, kernel
from .rng import mix

_LOW = np.uint64(0xFFFFFFFF)
_SET = np.uint64(0x9FB21C651E98DF25)
_S1, _S2, _S4, _S8, _S16, _S32 = (np.uint64(n) for n in (1, 2, 4, 8, 16, 32))
_M1, _M2, _M4, _M8, _M16 = (np.uint64(n) for n in (0x55555555, 0x33333333, 0x0F0F0F0F, 0x00FF00FF, 0x0000FFFF))
_A, _B, _C, _D = (np.uint64(n) for n in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6))
_TO_UNIT = 2.0**-32


@inlined
def interleaved(x):
    """The lower 16 bits of x, u64, with a zero above each."""
    x = (x | (x << _S8)) & _M8
    x = (x | (x << _S4)) & _M4
    x = (x | (x << _S2)) & _M2
    return (x | (x << _S1)) & _M1


@kernel
def morton(x, y):
    """Place of pixel (x, y) in Morton's order, i64: it fills squares one after another; repeats after 65536."""
    lower = np.uint64(x) & _M16
    upper = np.uint64(y) & _M16
    return np.int64(interleaved(lower) | (interleaved(upper) << _S1))


@inlined
def mirrored(x):
    """The lower 32 bits of x, u64, in reverse."""
    x = ((x >> _S1) & _M1) | ((x & _M1) << _S1)
    x = ((x >> _S2) & _M2) | ((x & _M2) << _S2)
    x = ((x >> _S4) & _M4) | ((x & _M4) << _S4)
    x = ((x >> _S8) & _M8) | ((x & _M8) << _S8)
    return ((x >> _S16) & _M16) | ((x & _M16) << _S16)


@inlined
def permuted(x, seed):
    """A permutation of 32 bits, u64, in which each bit depends on those below it alone [Laine and Karras 2011]."""
    x = (x + seed) & _LOW
    x = x ^ ((x * _A) & _LOW)
    x = x ^ ((x * _B) & _LOW)
    x = x ^ ((x * _C) & _LOW)
    return x ^ ((x * _D) & _LOW)


@kernel
def even_pair(key, place, which):
    """Two numbers in [0, 1) of the pixel at a place in Morton's order.

    which : 0, 1, ...: sets of numbers, independent of each other
    """
    one = mix(key + np.uint64(which + 1) * _SET)
    two = mix(one + _SET)
    index = mirrored(permuted(mirrored(np.uint64(place)), one & _LOW))
    # second dimension: Pascal's triangle modulo 2 times the bits of the index; both are wanted in reverse
    pascal = index ^ ((index >> _S1) & _M1)
    pascal = pascal ^ ((pascal >> _S2) & _M2)
    pascal = pascal ^ ((pascal >> _S4) & _M4)
    pascal = pascal ^ ((pascal >> _S8) & _M8)
    pascal = pascal ^ ((pascal >> _S16) & _M16)
    u = mirrored(permuted(index, one >> _S32))
    v = mirrored(permuted(pascal, two & _LOW))
    return float(u) * _TO_UNIT, float(v) * _TO_UNIT
