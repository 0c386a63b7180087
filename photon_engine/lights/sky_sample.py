"""Looking up and sampling the table of a world that varies (sky.py)."""

from __future__ import annotations

import math

from ..jit import inlined
from ..vec import load3
from .select import pick


@inlined
def texel_of(sky, d):
    """(row, column) of a unit direction."""
    height = sky.rows.shape[0]
    width = sky.columns.shape[1]
    j = int(math.acos(min(max(d[2], -1.0), 1.0)) * (height / math.pi))
    i = int((math.atan2(d[1], d[0]) + math.pi) * (width / (2.0 * math.pi)))
    return min(j, height - 1), min(i, width - 1)


@inlined
def texel_pdf_w(sky, j, i, p):
    """Density [1/sr] of a direction in texel (j, i) that has the probability p."""
    height = sky.rows.shape[0]
    step = math.pi / height
    angle = 2.0 * math.sin((j + 0.5) * step) * math.sin(0.5 * step) * 2.0 * math.pi / sky.columns.shape[1]
    return p / angle


@inlined
def map_radiance(sky, d):
    """Radiance of the table in direction d."""
    j, i = texel_of(sky, d)
    return load3(sky.radiance[j], i)


@inlined
def map_pdf_w(sky, d):
    """Density [1/sr] of `map_sample` in direction d."""
    j, i = texel_of(sky, d)
    p = sky.rows[j] - (sky.rows[j - 1] if j > 0 else 0.0)
    q = sky.columns[j, i] - (sky.columns[j, i - 1] if i > 0 else 0.0)
    return texel_pdf_w(sky, j, i, p * q)


@inlined
def map_sample(sky, u0, u1):
    """A direction toward the sky by brightness: (d, radiance, pdf_w)."""
    j, p, s = pick(sky.rows, u0)
    i, q, t = pick(sky.columns[j], u1)
    step = math.pi / sky.rows.shape[0]
    top = math.cos(j * step)
    z = top + (math.cos((j + 1) * step) - top) * s
    phi = (i + t) * 2.0 * math.pi / sky.columns.shape[1] - math.pi
    r = math.sqrt(max(1.0 - z * z, 0.0))
    d = (r * math.cos(phi), r * math.sin(phi), z)
    return d, load3(sky.radiance[j], i), texel_pdf_w(sky, j, i, p * q)
