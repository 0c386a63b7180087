"""Which lamps reach nothing: all that they light lies beside every receiver and the camera.

A spot, and an area lamp, shine into a convex cone from each of their points; a box is out of reach for certain when a
plane through the cone's tip parts the cone from all differences between points of box and lamp.
"""

from __future__ import annotations

import math
from collections.abc import Container
from itertools import product

import numpy as np

from .data import Camera, Light, SceneData

PLANES = 32  # round the cone, on each of RINGS from those that touch it to the one across its axis
RINGS = 4
PAD = 1e-4  # of the size of what is seen together: rays start a little off the surfaces
MOST = 1 << 14  # pairs of lamp and object; beyond it the boxes of all objects are taken as one
SIGNS = np.array(list(product((-0.5, 0.5), repeat=2)))


def out_of_reach(scene: SceneData, receivers: Container[int] | None = None) -> tuple[int, ...]:
    """Indices of the lamps whose light neither a receiver nor the camera can meet.

    receivers : indices of the materials that scatter light, -1 the default one; None: all do
    A lamp that is walled in, and a sun, count as in reach: that would take rays.
    """
    shaped = [i for i, light in enumerate(scene.lights) if light.kind in ("SPOT", "AREA")]
    if not shaped:
        return ()
    boxes = np.array([*_object_boxes(scene, receivers), camera_box(scene.camera)])
    if len(boxes) * len(shaped) > MOST:
        boxes = np.array([[boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]])
    return tuple(i for i in shaped if misses(scene.lights[i], boxes))


def _object_boxes(scene: SceneData, receivers: Container[int] | None) -> list[np.ndarray]:
    """Corners (2, 3) of a box in the world round each instance that has triangles and wears a receiver."""
    local: dict[int, np.ndarray] = {}
    out = []
    for item in scene.instances:
        mesh = scene.meshes[item.mesh]
        scatters = receivers is None or any(max(m, -1) in receivers for m in item.materials or [-1])
        if not len(mesh.triangles) or not scatters:
            continue
        if item.mesh not in local:
            local[item.mesh] = np.array([mesh.positions.min(axis=0), mesh.positions.max(axis=0)], np.float64)
        corners = _corners(local[item.mesh][None])[0] @ item.matrix[:3, :3].T + item.matrix[:3, 3]
        out.append(np.array([corners.min(axis=0), corners.max(axis=0)]))
    return out


def camera_box(camera: Camera) -> np.ndarray:
    """Corners (2, 3) of a box round all points at which rays leave a camera."""
    left, right, bottom, top = camera.window
    if camera.kind == "ORTHO":
        points = np.array([[x, y, 0.0] for x in (left, right) for y in (bottom, top)])
    else:
        ratio = max(camera.aperture_ratio, 1.0 / max(camera.aperture_ratio, 1e-6))
        points = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
        points *= camera.aperture_radius * ratio
    points = points @ camera.matrix[:3, :3].T + camera.matrix[:3, 3]
    return np.array([points.min(axis=0), points.max(axis=0)])


def _corners(boxes: np.ndarray) -> np.ndarray:
    """The eight corners (n, 8, 3) of boxes (n, 2, 3)."""
    pick = np.array(list(product((0, 1), repeat=3)))
    return np.stack([boxes[:, pick[:, axis], axis] for axis in range(3)], axis=2)


def misses(light: Light, boxes: np.ndarray) -> bool:
    """Whether a spot or area lamp for certain lights no point of boxes (n, 2, 3) in the world [m]."""
    matrix = np.asarray(light.matrix, np.float64)
    linear, position = matrix[:3, :3], matrix[:3, 3]
    pad = PAD * float(np.abs(boxes - position).max())
    if light.kind == "SPOT":
        # within its sphere a lamp shines all ways: the sphere, and what is lit from each of its points
        nearest = np.clip(position, boxes[:, 0], boxes[:, 1])
        if abs(np.linalg.det(linear)) < 1e-18 or np.linalg.norm(nearest - position, axis=1).min() <= light.radius + pad:
            return False
        offsets = np.zeros((1, 3))
        pad += light.radius
        to_local, half = np.linalg.inv(linear), 0.5 * min(light.spot_size, math.pi)
    else:
        frame = _area_frame(light, matrix)
        if frame is None:
            return False
        to_local, offsets = frame
        half = min(0.5 * max(light.spread, 0.0), 0.5 * math.pi)
    padded = boxes + np.array([[-pad], [pad]])
    points = (_corners(padded)[:, :, None, :] - position - offsets).reshape(len(boxes), -1, 3) @ to_local.T
    return bool((points @ _outward(half)).min(axis=1).max(axis=1).min() > 0.0)


def _outward(half: float) -> np.ndarray:
    """Normals (3, n) of planes through the tip of the cone of this half angle about -Z, the cone behind them."""
    around, rise = np.meshgrid(np.arange(PLANES) * (2.0 * math.pi / PLANES), np.linspace(half, 0.5 * math.pi, RINGS))
    flat = np.cos(rise)
    return np.stack([np.cos(around) * flat, np.sin(around) * flat, np.sin(rise)]).reshape(3, -1)


def _area_frame(light: Light, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """World to an area lamp's axes, of which the last is against where it shines, and its corners (4, 3) [m]."""
    size_v = light.size[1] if light.shape in ("RECTANGLE", "ELLIPSE") else light.size[0]
    u, v = matrix[:3, 0] * light.size[0], matrix[:3, 1] * size_v
    normal = np.cross(u, v)
    length = np.linalg.norm(normal)
    if not length > 1e-12 * np.linalg.norm(u) * np.linalg.norm(v) > 0.0:
        return None
    up = normal / length * (1.0 if normal @ matrix[:3, 2] > 0.0 else -1.0)
    first = u / np.linalg.norm(u)
    return np.stack([first, np.cross(up, first), up]), SIGNS @ np.stack([u, v])
