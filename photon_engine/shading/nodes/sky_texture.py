"""The Sky Texture: all models of Blender 4.5 and 5.x."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..registry import f32, node, unlinked
from ..sky import analytic, multiple, single
from ..textures import EXTEND, LINEAR, sample_image
from .coordinates import columns, mapped
from .spectra import XYZ_TO_RGB

SIZE, OLD_SIZE = (512, 256), (512, 128)  # of the sky's picture, as in Cycles
LEAST_SUN = 0.0005  # [rad]
LIMB = 0.6  # darkening at the edge of the sun
TWO_PI = 2.0 * math.pi


@lru_cache(maxsize=8)
def sky_picture(kind, elevation, altitude, amounts):
    """XYZ and alpha (H, W, 4) f32 of a scattering sky."""
    if kind == "MULTIPLE_SCATTERING":
        xyz = multiple.picture(elevation, altitude, np.array(amounts), SIZE)
    elif kind == "NISHITA":
        xyz = single.old_picture(elevation, altitude, np.array(amounts), OLD_SIZE)
    else:
        xyz = single.picture(elevation, altitude, np.array(amounts), SIZE)
    return np.concatenate([xyz, np.ones((*xyz.shape[:2], 1))], axis=2).astype(f32)


@lru_cache(maxsize=8)
def sun_colors(kind, elevation, diameter, altitude, amounts):
    """XYZ (2, 3) of the ends of the sun's disc."""
    model = multiple if kind == "MULTIPLE_SCATTERING" else single
    return model.sun_ends(elevation, diameter, altitude, np.array(amounts))


def place_of_sun(elevation, rotation):
    """Elevation in [-pi / 2, pi / 2], and the rotation as the model counts it, in [0, 2 pi]."""
    elevation = math.fmod(elevation, TWO_PI)
    if abs(elevation) >= math.pi:
        elevation -= math.copysign(TWO_PI, elevation)
    if abs(elevation) >= 0.5 * math.pi:
        elevation = math.copysign(math.pi, elevation) - elevation
        rotation += math.pi
    return elevation, TWO_PI - rotation % TWO_PI


def disc(d, above, sun, ends):
    """XYZ (3, n) of the sun's disc, 0 outside, and where it is; sun: elevation, rotation, diameter;  ends (2, 3).

    Only directions (n,) `above` the ground see it.
    """
    elevation, rotation, diameter = sun
    c = math.cos(elevation)
    center = np.array([-c * math.sin(rotation), c * math.cos(rotation), math.sin(elevation)])
    to = np.linalg.norm(d - center[:, None], axis=0), np.linalg.norm(d + center[:, None], axis=0)
    angle = 2.0 * np.arctan2(*to)
    half = 0.5 * diameter
    inside = (angle < half) & above
    up = 0.5 * math.pi - np.arccos(np.clip(d[2], -1.0, 1.0))
    t = (up - elevation) / diameter + 0.5
    if elevation - half <= 0.0 and elevation + half > 0.0 and ends[2]:  # Blender 4.5 stretches what is above
        t = up / (elevation + half)
    edge = 1.0 - LIMB * (1.0 - np.sqrt(np.maximum(1.0 - (angle / half) ** 2, 0.0)))
    low, high = ends[0], ends[1]
    return np.where(inside, ((1.0 - t) * low[:, None] + t * high[:, None]) * edge, 0.0), inside


def scattering_sky(d, kind, props):
    """XYZ (3, n) of a sky with air, aerosols and ozone."""
    old = kind == "NISHITA"
    elevation, rotation = place_of_sun(props["sun_elevation"], props["sun_rotation"])
    diameter, altitude = max(props["sun_size"], LEAST_SUN), props["altitude"]
    aerosols = props["dust_density"] if old else props["aerosol_density"]
    amounts = (props["air_density"], aerosols, props["ozone_density"])
    up = 0.5 * math.pi - np.arccos(np.clip(d[2], -1.0, 1.0))
    u = (-np.arctan2(d[1], d[0]) - 0.5 * math.pi + rotation) / TWO_PI
    u = u - np.floor(u)
    picture = sky_picture(kind, elevation, altitude, amounts)
    if old:
        v = np.where(d[2] >= 0.0, np.sqrt(np.maximum(up, 0.0) / (0.5 * math.pi)), -0.5)
    else:
        v = 0.5 * np.copysign(np.sqrt(np.abs(up) * 2.0 / math.pi), up) + 0.5
    xyz = sample_image(picture, np.stack([u, v]), LINEAR, EXTEND, 0)[:3].astype(np.float64)
    if old:
        xyz *= np.where(d[2] >= 0.0, 1.0, np.maximum(1.0 + 2.5 * d[2], 0.0) ** 3)
    if props.get("sun_disc", True):
        above = d[2] >= 0.0 if old else up > -multiple.horizon_angle(altitude)
        low, high = sun_colors(kind, elevation, diameter, altitude, amounts)
        glow, inside = disc(d, above, (elevation, rotation, diameter), (low, high, old))
        glow *= props.get("sun_intensity", 1.0)
        xyz = np.where(inside & old, glow, xyz + glow)
    return xyz


def sky_needs(item, used):
    """Generated coordinates where no vector can be linked, as with the sun's disc, or none is."""
    return {"generated"} if unlinked("Vector")(item, used) else set()


@node("ShaderNodeTexSky", varies=unlinked("Vector"), needs=sky_needs)
def sky_texture(x, props, points):
    """Radiance of a clear sky in a unit direction, which without a vector is the generated coordinate."""
    vector = x.get("Vector")
    d = mapped(columns(points.generated) if vector is None else vector, props).astype(np.float64)
    kind = props.get("sky_type", "MULTIPLE_SCATTERING")
    if kind == "PREETHAM":
        xyz = analytic.preetham(d, tuple(props["sun_direction"]), props["turbidity"])
    elif kind == "HOSEK_WILKIE":
        xyz = analytic.hosek(d, tuple(props["sun_direction"]), props["turbidity"], props["ground_albedo"])
    else:
        xyz = scattering_sky(d, kind, props)
    return {"Color": np.maximum(XYZ_TO_RGB @ xyz, 0.0).astype(f32)}
