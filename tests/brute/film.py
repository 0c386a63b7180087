"""Camera and pixel filter of the reference tracer."""

import math
from typing import NamedTuple

import numpy as np

from photon_engine.issues import RenderError

from .jit import kernel
from .maths import dot, scale, unit

BOX, GAUSSIAN, BLACKMAN_HARRIS = range(3)
REACH = (1.0, 3.0, 2.0)  # the filter's whole extent over the width that users set, as in Cycles


class View(NamedTuple):
    """A pinhole or parallel camera and its pixels."""

    x: tuple  # unit axes of the camera in the world: right,
    y: tuple  # up,
    z: tuple  # backward
    p: tuple  # position
    window: tuple  # left, right, bottom, top
    parallel: bool
    near: float
    far: float
    size: tuple  # of the full frame [px]: width, height
    border: tuple  # x0, y0, x1, y1 [px]
    filter: int
    filter_width: float
    filter_norm: float  # integral of the filter's shape
    icdf: np.ndarray  # (1025,) f64 quantiles of the filter in one dimension [px]


def filter_shape(kind, x, width):
    """Unnormalised filter value at offset x [px]; width: its whole extent."""
    if kind == BOX:
        return np.ones_like(x)
    if kind == GAUSSIAN:
        return np.exp(-2.0 * (6.0 * x / width) ** 2)
    v = 2.0 * np.pi * (x / width + 0.5)
    return 0.35875 - 0.48829 * np.cos(v) + 0.14128 * np.cos(2 * v) - 0.01168 * np.cos(3 * v)


def make_view(scene):
    """The View of a scene's camera and frame."""
    camera, frame = scene.camera, scene.frame
    if camera.aperture_radius > 0.0:
        raise RenderError(camera.name, "depth of field", "the reference tracer has a pinhole")
    if camera.kind not in ("PERSP", "ORTHO"):
        raise RenderError(camera.name, f"{camera.kind} camera", "use a perspective or orthographic one")
    kind = {"BOX": BOX, "GAUSSIAN": GAUSSIAN, "BLACKMAN_HARRIS": BLACKMAN_HARRIS}[frame.filter]
    width = REACH[kind] * frame.filter_width
    x = np.linspace(-width / 2, width / 2, 20001)
    cdf = np.concatenate([[0.0], np.cumsum((lambda f: (f[1:] + f[:-1]) / 2)(filter_shape(kind, x, width)))])
    norm = cdf[-1] * (x[1] - x[0])
    icdf = np.interp(np.linspace(0, 1, 1025), cdf / cdf[-1], x)
    m = np.asarray(camera.matrix, float)
    axes = [tuple(float(v) for v in m[:3, k]) for k in range(4)]
    return View(
        *axes, tuple(float(v) for v in camera.window), camera.kind == "ORTHO", float(camera.clip_start),
        float(camera.clip_end), (int(frame.width), int(frame.height)),
        (int(frame.x0), int(frame.y0), int(frame.x1), int(frame.y1)), kind, float(width), float(norm), icdf,
    )


@kernel
def filter_offset(view, u):
    """An offset from the pixel's centre, distributed as the filter [px]."""
    at = u * 1024.0
    i = min(int(at), 1023)
    return view.icdf[i] + (at - i) * (view.icdf[i + 1] - view.icdf[i])


@kernel
def filter_value(view, x):
    """Density of the filter at offset x, in one dimension [1/px]."""
    if abs(x) > 0.5 * view.filter_width:
        return 0.0
    if view.filter == BOX:
        return 1.0
    if view.filter == GAUSSIAN:
        return math.exp(-2.0 * (6.0 * x / view.filter_width) ** 2) / view.filter_norm
    v = 2.0 * math.pi * (x / view.filter_width + 0.5)
    shape = 0.35875 - 0.48829 * math.cos(v) + 0.14128 * math.cos(2.0 * v) - 0.01168 * math.cos(3.0 * v)
    return shape / view.filter_norm


@kernel
def eye_ray(view, px, py):
    """Ray (o, d, t_max) through the film at (px, py), in pixels of the full frame; clipping applied."""
    left, right, bottom, top = view.window
    x = left + (right - left) * px / view.size[0]
    y = bottom + (top - bottom) * py / view.size[1]
    if view.parallel:
        o = (
            view.p[0] + x * view.x[0] + y * view.y[0] - view.near * view.z[0],
            view.p[1] + x * view.x[1] + y * view.y[1] - view.near * view.z[1],
            view.p[2] + x * view.x[2] + y * view.y[2] - view.near * view.z[2],
        )
        return o, scale(view.z, -1.0), view.far - view.near
    v = (
        x * view.x[0] + y * view.y[0] - view.z[0],
        x * view.x[1] + y * view.y[1] - view.z[1],
        x * view.x[2] + y * view.y[2] - view.z[2],
    )
    long = math.sqrt(dot(v, v))
    d = unit(v)
    near = view.near * long
    return (view.p[0] + near * d[0], view.p[1] + near * d[1], view.p[2] + near * d[2]), d, (view.far - view.near) * long


@kernel
def project(view, p):
    """(seen, px, py, wo, distance, density) of a point: density is film area [px^2] per projected area [m^2].

    distance is to the near plane along the ray; wo points to the eye.
    """
    to = (p[0] - view.p[0], p[1] - view.p[1], p[2] - view.p[2])
    x, y, depth = dot(to, view.x), dot(to, view.y), -dot(to, view.z)
    left, right, bottom, top = view.window
    pixels = view.size[0] / (right - left) * view.size[1] / (top - bottom)
    if depth <= view.near or depth >= view.far:
        return False, 0.0, 0.0, view.z, 0.0, 0.0
    if view.parallel:
        wo, distance = view.z, depth - view.near
    else:
        long = math.sqrt(dot(to, to))
        wo, distance = scale(to, -1.0 / long), long * (1.0 - view.near / depth)
        x, y = x / depth, y / depth
        # a solid angle cos / long^2 covers 1 / cos(view axis)^3 of the plane at distance 1
        pixels *= long / depth**3
    px, py = view.size[0] * (x - left) / (right - left), view.size[1] * (y - bottom) / (top - bottom)
    return True, px, py, wo, distance, pixels
