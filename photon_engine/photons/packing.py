"""Unit vectors and facets in 32 bits, by the octahedral map [Cigolle et al. 2014, JCGT 3(2)].

Directions: 16 bits an axis, error below 7e-5 radians. Facets: 13 bits an axis, error below 6e-4 radians, then a bit for
the side of the mesh and 5 of the object's number.
"""

from __future__ import annotations

import math

import numpy as np

from ..jit import inlined, kernel
from ..vec import normalize

_SCALE = 32767.0
_FACET_SCALE = 4095.0
_TAG = 31
_FRONT = 32


@inlined
def _octahedral(v):
    """A unit vector's place in the square [-1, 1]^2."""
    s = 1.0 / (abs(v[0]) + abs(v[1]) + abs(v[2]))
    x, y = v[0] * s, v[1] * s
    # without branches: half of them would be mispredicted
    fold = 1.0 if v[2] < 0.0 else 0.0
    fold_x = math.copysign(1.0 - abs(y), x)
    fold_y = math.copysign(1.0 - abs(x), y)
    return x + fold * (fold_x - x), y + fold * (fold_y - y)


@kernel
def pack_direction(v):
    """A unit vector as an integer of 32 bits."""
    x, y = _octahedral(v)
    return np.uint32((np.int64(x * _SCALE + 32768.5) << 16) | np.int64(y * _SCALE + 32768.5))


@kernel
def pack_facet(n, front, instance):
    """A facet where a photon fell: unit normal on the side of arrival, whether that is the mesh's front, object."""
    x, y = _octahedral(n)
    a, b = np.int64(x * _FACET_SCALE + 4096.5), np.int64(y * _FACET_SCALE + 4096.5)
    return np.uint32((a << 19) | (b << 6) | body(front, instance))


@inlined
def body(front, instance):
    """The side and the object as a facet's last bits hold them."""
    return (_FRONT if front else 0) | (np.int64(instance) & _TAG)


@inlined
def touches(code, own):
    """Whether a facet belongs to another object that turns the other way: what lies on this one, not a part of it.

    Under a ball the floor's photons are within reach of the ball's, and their facets are parallel; but the floor looks
    up and the ball looks down. Parts of one surface that is made of several objects look the same way.
    own : `body` of the surface point, front being the side of the mesh that the facet's normal would be on here.
    """
    differs = (np.int64(code) ^ own) & (_FRONT | _TAG)
    return differs > _FRONT


@inlined
def unpack_direction(code):
    """The unit vector of pack_direction's integer."""
    return normalize(unpack_octahedral(code))


@inlined
def unpack_octahedral(code):
    """The vector of pack_direction's integer before it is normalised: on the octahedron |x| + |y| + |z| = 1."""
    return _unfold(float(np.int64(code >> 16) - 32768) / _SCALE, float(np.int64(code & 0xFFFF) - 32768) / _SCALE)


@inlined
def unpack_facet(code):
    """The normal of pack_facet's integer before it is normalised, as `unpack_octahedral`."""
    x = float(np.int64(code >> 19) - 4096) / _FACET_SCALE
    return _unfold(x, float(np.int64((code >> 6) & 0x1FFF) - 4096) / _FACET_SCALE)


@inlined
def _unfold(x, y):
    """The point of the octahedron at a place in the square."""
    z = 1.0 - abs(x) - abs(y)
    fold = max(-z, 0.0)
    return (x - math.copysign(fold, x), y - math.copysign(fold, y), z)
