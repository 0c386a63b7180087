"""SHEEN and VELVET lobes: cloth. Values are for a lobe of unit weight.

SHEEN is a layer of fibres, as a cosine stretched by a matrix that depends on the view [Zeltner, Burley and Chiang 2022,
Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines]; sheen.npy holds the authors' fit (Apache
License 2.0, github.com/tizian/ltc-sheen): the matrix's a and b and the albedo, over roughness and cosine, (3, 32, 32).
"""

from __future__ import annotations

import hashlib
import math
from pathlib import Path

import numpy as np

from ..jit import kernel
from ..vec import add, dot, normalize
from .diffuse import INV_PI
from .layout import ROUGHNESS, SHEEN
from .microfacet import frame_along
from .tables import read_2d

SHA256 = "cb91fe9d73112315c54cd6099bf3836b653314b53b778b874af7c0c24006f6bf"
LEAST = 1e-5  # of a and the albedo: below it the fit means nothing, and the layer is left out


def load_table() -> np.ndarray:
    """The fit; an error when the file is not the one this source was written for."""
    path = Path(__file__).with_name("sheen.npy")
    if hashlib.sha256(path.read_bytes()).hexdigest() != SHA256:
        raise ValueError(f"{path.name} is not the table that this version was made for")
    return np.ascontiguousarray(np.load(path))


TABLE = load_table()


@kernel
def sheen_albedo(rough, mu):
    """Directional albedo of a layer of fibres seen at the cosine mu; 0 where the fit means nothing."""
    rough = min(max(rough, 1e-3), 1.0)
    albedo = read_2d(TABLE, 2, rough, mu)
    if albedo < LEAST or mu <= 0.0 or abs(read_2d(TABLE, 0, rough, mu)) < LEAST:
        return 0.0
    return albedo


@kernel
def sheen_matrix(rough, mu):
    """(a, b) of the stretched cosine seen at the cosine mu."""
    rough = min(max(rough, 1e-3), 1.0)
    return read_2d(TABLE, 0, rough, mu), read_2d(TABLE, 1, rough, mu)


@kernel
def sheen_density(rough, n, view, light):
    """Stretched cosine toward `light` [1/sr] over the cosine of `light`, which is f for unit albedo."""
    z = dot(n, light)
    mu = dot(n, view)
    if z <= 0.0 or mu <= 0.0:
        return 0.0
    a, b = sheen_matrix(rough, mu)
    s, t = frame_along(n, view)
    x, y = a * dot(light, s) + b * z, a * dot(light, t)
    ratio = a / (x * x + y * y + z * z)
    return INV_PI * ratio * ratio


@kernel
def sheen_direction(rough, n, view, u1, u2):
    """Direction with density cos `sheen_density`."""
    a, b = sheen_matrix(rough, dot(n, view))
    s, t = frame_along(n, view)
    r, phi = math.sqrt(u1), 2.0 * math.pi * u2
    x, y, z = r * math.cos(phi), r * math.sin(phi), math.sqrt(1.0 - u1)
    x, z = x - z * b, z * a
    return normalize(
        (
            x * s[0] + y * t[0] + z * n[0],
            x * s[1] + y * t[1] + z * n[1],
            x * s[2] + y * t[2] + z * n[2],
        )
    )


@kernel
def velvet_value(sigma, n, view, light):
    """Ashikhmin's velvet, f without cosine [Ashikhmin, Premoze and Shirley 2000, section 3.3]."""
    cos_o, cos_i = dot(n, view), dot(n, light)
    h = normalize(add(view, light))
    cos_h, cos_d = dot(n, h), abs(dot(view, h))
    if cos_o <= 0.0 or cos_i <= 0.0 or abs(cos_h) >= 1.0 - 1e-5 or cos_d <= 1e-5:
        return 0.0
    inverse = 1.0 / max(sigma, 0.01) ** 2
    q = 2.0 * max(cos_h / cos_d, 1e-5)
    sine2 = 1.0 - cos_h * cos_h
    d = math.exp(-cos_h * cos_h / sine2 * inverse) * inverse * INV_PI / (sine2 * sine2)
    return 0.25 * d * min(1.0, min(q * cos_o, q * cos_i)) / (cos_o * cos_i)


@kernel
def cloth_value(rows, row, k, n, view, light):
    """f without cosine of a SHEEN or VELVET lobe; what SHEEN returns is for unit albedo."""
    rough = float(rows.params[row, k, ROUGHNESS])
    if rows.kind[row, k] == SHEEN:
        return sheen_density(rough, n, view, light)
    return velvet_value(rough, n, view, light)
