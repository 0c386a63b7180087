"""Light Path: what kind of ray looks at a surface, and what it did before."""

from __future__ import annotations

import numpy as np

from .. import trail as tr
from ..registry import f32, node

LIGHT_PATH_FLAGS = {
    "Is Camera Ray": tr.CAMERA, "Is Diffuse Ray": tr.DIFFUSE, "Is Glossy Ray": tr.GLOSSY,
    "Is Singular Ray": tr.SINGULAR, "Is Reflection Ray": tr.REFLECTION, "Is Transmission Ray": tr.TRANSMISSION,
}  # fmt: skip
LIGHT_PATH_COUNTS = {
    "Ray Depth": tr.DEPTH, "Diffuse Depth": tr.DIFFUSE_DEPTH, "Glossy Depth": tr.GLOSSY_DEPTH,
    "Transparent Depth": tr.TRANSPARENT_DEPTH, "Transmission Depth": tr.TRANSMISSION_DEPTH,
}  # fmt: skip


def trails(points) -> np.ndarray:
    """Trails (n,) of the points' rays."""
    if points.trail is not None:
        return points.trail
    return np.full(len(points), tr.PHOTON if points.is_photon else tr.FROM_LIGHT, np.int64)


@node("ShaderNodeLightPath", varies=True, needs=lambda item, used: {"trail"} if used - {"Is Shadow Ray"} else set())
def light_path(x, props, points):
    """Flags and counts of the ray that looks. Scattering in volumes and portals do not occur: their outputs are 0.

    A photon answers as the diffuse ray of depth 1 that would bring its light the other way, with a length of 0.
    """
    n, out, known = len(points), {}, trails(points)
    for name in props["used"]:
        if name in LIGHT_PATH_FLAGS:
            out[name] = (known & LIGHT_PATH_FLAGS[name] != 0).astype(f32)
        elif name in LIGHT_PATH_COUNTS:
            out[name] = (known >> LIGHT_PATH_COUNTS[name] & tr.MOST).astype(f32)
        elif name == "Ray Length" and points.ray_length is not None and not points.is_photon:
            out[name] = points.ray_length
        else:
            out[name] = np.full(n, name == "Is Shadow Ray" and points.is_shadow, f32)
    return out
