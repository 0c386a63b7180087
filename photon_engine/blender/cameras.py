"""Blender's camera and frame settings as ``Camera`` and ``Frame``."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..issues import IssueLog, RenderError
from ..scene.data import Camera, Frame
from .places import Places

MILLIMETRE = 1e-3
SMALLEST_FSTOP = 1e-5  # as Cycles


def extract_camera(scene: Any, depsgraph: Any, places: Places, issues: IssueLog, override: Any = None) -> Camera:
    """The scene's camera (or another object) as evaluated; RenderError when there is none that can be used."""
    ob = override if override is not None else scene.camera
    if ob is None:
        raise RenderError(scene.name, "the scene has no camera", "add one, or set it under Scene > Camera")
    ob = ob.evaluated_get(depsgraph)
    if ob.type != "CAMERA":
        raise RenderError(ob.name, f"a {ob.type.lower()} is used as the camera", "use a camera object")
    data = ob.data
    if data.type not in ("PERSP", "ORTHO"):
        raise RenderError(
            ob.name, f"{data.type.lower()} cameras are not supported", "set Lens > Type to Perspective or Orthographic"
        )
    matrix = camera_matrix(ob, places)
    camera = Camera(
        name=ob.name,
        kind=data.type,
        matrix=matrix,
        window=camera_window(data, scene.render),
        clip_start=data.clip_start,
        clip_end=data.clip_end,
    )
    if data.dof.use_dof:
        _set_lens(camera, data)
        camera.focus_distance = focus_distance(ob, places, matrix)
    _report_unsupported(ob, scene, issues)
    return camera


def camera_matrix(ob: Any, places: Places) -> np.ndarray:
    """Camera to world without scale, (4, 4) f64."""
    matrix = places.of(ob).copy()
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not (np.isfinite(matrix).all() and (lengths > 0.0).all()):
        raise RenderError(ob.name, "the camera's transform is undefined or has a scale of 0", "clear its scale")
    matrix[:3, :3] /= lengths
    return matrix


def frame_size(render: Any) -> tuple[int, int]:
    """Width and height after resolution percentage [px]."""
    percentage = render.resolution_percentage
    return max(1, render.resolution_x * percentage // 100), max(1, render.resolution_y * percentage // 100)


def camera_window(data: Any, render: Any) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of the full frame: at distance 1 (perspective) or in metres (orthographic)."""
    width, height = frame_size(render)
    x, y = width * render.pixel_aspect_x, height * render.pixel_aspect_y
    horizontal = x > y if data.sensor_fit == "AUTO" else data.sensor_fit == "HORIZONTAL"
    fitted = x if horizontal else y
    # half extents when the fitted side is 1
    half_x, half_y = x / fitted, y / fitted
    if data.type == "ORTHO":
        scale = data.ortho_scale / 2.0
    else:
        # Blender's automatic fit measures both sides by the sensor's width
        sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
        scale = sensor / (2.0 * data.lens)
    # a shift of 1 moves the window by the whole fitted side, on both axes
    dx, dy = 2.0 * data.shift_x, 2.0 * data.shift_y
    return (
        scale * (-half_x + dx), scale * (half_x + dx), scale * (-half_y + dy), scale * (half_y + dy)
    )  # fmt: skip


def focus_distance(ob: Any, places: Places, matrix: np.ndarray) -> float:
    """Distance of the focal plane along the view axis [m]."""
    dof = ob.data.dof
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    focus = places.of(target)
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose and dof.focus_subtarget else None
    if bone is not None:
        focus = focus @ np.array(bone.matrix, np.float64)
    return abs(float(np.dot(matrix[:3, 2], matrix[:3, 3] - focus[:3, 3])))


def _set_lens(camera: Camera, data: Any) -> None:
    """Aperture and focus as Cycles has them."""
    dof = data.dof
    fstop = max(dof.aperture_fstop, SMALLEST_FSTOP)
    # an orthographic camera has no focal length: its aperture is 1 m / f-stop
    diameter = 1.0 / fstop if data.type == "ORTHO" else data.lens * MILLIMETRE / fstop
    camera.aperture_radius = diameter / 2.0
    camera.blades = dof.aperture_blades if dof.aperture_blades >= 3 else 0
    camera.blade_rotation = dof.aperture_rotation
    camera.aperture_ratio = dof.aperture_ratio


def _report_unsupported(ob: Any, scene: Any, issues: IssueLog) -> None:
    """Settings of the camera and frame that have no effect."""
    if scene.render.use_motion_blur:
        issues.warn(scene.name, "motion blur is not supported yet: the frame is rendered sharp")


def extract_frame(scene: Any) -> Frame:
    """Size, border, pixel filter and film of the picture."""
    render = scene.render
    width, height = frame_size(render)
    frame = Frame(width=width, height=height, x1=width, y1=height, transparent=render.film_transparent)
    if render.use_border:
        _set_border(frame, render)
    cycles = getattr(scene, "cycles", None)
    if cycles is not None and hasattr(cycles, "pixel_filter_type"):
        frame.filter = cycles.pixel_filter_type
        # Cycles ignores the width for a box
        frame.filter_width = 1.0 if frame.filter == "BOX" else cycles.filter_width
        frame.exposure = cycles.film_exposure
        frame.transparent_glass = cycles.film_transparent_glass
    return frame


def _set_border(frame: Frame, render: Any) -> None:
    """Pixels of the render border, rounded as Blender does: single precision, towards zero."""
    xs = [int(np.float32(v) * np.float32(frame.width)) for v in (render.border_min_x, render.border_max_x)]
    ys = [int(np.float32(v) * np.float32(frame.height)) for v in (render.border_min_y, render.border_max_y)]
    if xs[0] >= xs[1] or ys[0] >= ys[1]:
        raise RenderError("Render Region", "is less than one pixel wide or high", "draw a larger region")
    frame.x0, frame.x1 = xs
    frame.y0, frame.y1 = ys
    frame.crop = render.use_crop_to_border
