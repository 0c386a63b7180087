"""Camera rays: pixel filter, thin lens, clipping, and how wide a pixel is along its ray."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..issues import RenderError
from ..jit import kernel
from ..scene.data import Camera, Frame
from ..vec import dot, normalize
from .aperture import sample_aperture
from .filters import filter_table, sample_filter


class CameraTable(NamedTuple):
    """A camera and frame as the kernels read them; positions relative to the origin given to ``build_camera``."""

    ortho: bool
    matrix: np.ndarray  # (3, 4) f64: columns right, up, back (unit), position
    left: float  # window, at distance 1 or in metres for ortho
    bottom: float
    pixel_x: float  # window units a pixel
    pixel_y: float
    clip_start: float  # along the view axis [m]
    clip_end: float
    aperture_radius: float  # [m]
    focus_distance: float  # along the view axis [m]
    blades: int
    blade_rotation: float  # [rad]
    inv_ratio: float
    filter: np.ndarray  # (K,) f64, inverse CDF, see filters.py


def build_camera(camera: Camera, frame: Frame, origin: np.ndarray | tuple = (0.0, 0.0, 0.0)) -> CameraTable:
    """The camera for kernels; ``origin`` (3,) f64 [m] is subtracted from positions, so that far scenes keep digits."""
    left, right, bottom, top = camera.window
    if not (right > left and top > bottom and camera.clip_end > camera.clip_start):
        raise RenderError(camera.name, "its window or clipping range is empty", "check lens, sensor and clipping")
    if camera.aperture_radius > 0.0 and not (camera.focus_distance > 0.0 and camera.aperture_ratio > 0.0):
        raise RenderError(camera.name, "depth of field needs a focus distance and ratio above 0", "move the focus away")
    matrix = np.array(camera.matrix[:3, :4], np.float64)
    matrix[:, 3] -= np.asarray(origin, np.float64)
    return CameraTable(
        ortho=camera.kind == "ORTHO",
        matrix=matrix,
        left=float(left),
        bottom=float(bottom),
        pixel_x=(right - left) / frame.width,
        pixel_y=(top - bottom) / frame.height,
        clip_start=float(camera.clip_start),
        clip_end=float(camera.clip_end),
        aperture_radius=float(camera.aperture_radius),
        focus_distance=float(camera.focus_distance),
        blades=int(camera.blades),
        blade_rotation=float(camera.blade_rotation),
        inv_ratio=1.0 / camera.aperture_ratio,
        filter=filter_table(frame.filter, frame.filter_width),
    )


@kernel
def turn(matrix, v):
    """A camera-space direction in world space."""
    return (
        matrix[0, 0] * v[0] + matrix[0, 1] * v[1] + matrix[0, 2] * v[2],
        matrix[1, 0] * v[0] + matrix[1, 1] * v[1] + matrix[1, 2] * v[2],
        matrix[2, 0] * v[0] + matrix[2, 1] * v[1] + matrix[2, 2] * v[2],
    )


@kernel
def generate_ray(camera, px, py, u_filter0, u_filter1, u_lens0, u_lens1):
    """A ray through pixel (px, py) of the full frame, (0, 0) at bottom left: (o, d, t_near, t_max, spread, radius0).

    o [m, relative to the table's origin] lies on the lens, d is unit; the ray is valid for t in [t_near, t_max]
    (clipping planes across the view axis). ``radius0 + spread * t`` [m] is half the side of the square that has the
    pixel's solid angle at distance t (PERSP, radius0 = 0) or its area (ORTHO, spread = 0).
    """
    x = camera.left + (px + 0.5 + sample_filter(camera.filter, u_filter0)) * camera.pixel_x
    y = camera.bottom + (py + 0.5 + sample_filter(camera.filter, u_filter1)) * camera.pixel_y
    lens_x = 0.0
    lens_y = 0.0
    if camera.aperture_radius > 0.0:
        lens_x, lens_y = sample_aperture(camera.blades, camera.blade_rotation, camera.inv_ratio, u_lens0, u_lens1)
        lens_x *= camera.aperture_radius
        lens_y *= camera.aperture_radius
    half = 0.5 * math.sqrt(camera.pixel_x * camera.pixel_y)
    focus = camera.focus_distance if camera.aperture_radius > 0.0 else 1.0
    if camera.ortho:
        local = (x + lens_x, y + lens_y, 0.0)
        toward = (-lens_x, -lens_y, -focus)
        radius0 = half
        spread = 0.0
    else:
        local = (lens_x, lens_y, 0.0)
        # all lens points look at the point of the focal plane that the pinhole sees
        toward = (x * focus - lens_x, y * focus - lens_y, -focus)
        radius0 = 0.0
        spread = half * (1.0 + x * x + y * y) ** -0.75
    d = normalize(turn(camera.matrix, toward))
    shift = turn(camera.matrix, local)
    o = (shift[0] + camera.matrix[0, 3], shift[1] + camera.matrix[1, 3], shift[2] + camera.matrix[2, 3])
    axis = (-camera.matrix[0, 2], -camera.matrix[1, 2], -camera.matrix[2, 2])
    inv_cos = 1.0 / dot(d, axis)
    return o, d, camera.clip_start * inv_cos, camera.clip_end * inv_cos, spread, radius0
