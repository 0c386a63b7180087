"""A glass of red wine on a table: three interfaces that share their edges, and the light they gather."""

from __future__ import annotations

import math

import numpy as np

from . import common, materials

SEGMENTS = 128
GLASS_IOR = 1.5
WINE_IOR = 1.345
LEVEL = 0.178  # of the wine [m]
RED = (0.50, 0.018, 0.035)


def curve(points, steps: int) -> np.ndarray:
    """A Catmull-Rom curve through (radius, z), `steps` pieces for each span, ends included."""
    points = np.asarray(points, float)
    padded = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
    t = np.linspace(0.0, 1.0, steps, endpoint=False)[:, None]
    pieces = []
    for a, b, c, d in zip(padded, padded[1:], padded[2:], padded[3:], strict=False):
        pieces.append(
            0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
        )
    out = np.concatenate([*pieces, points[-1:]])
    out[:, 0] = np.maximum(out[:, 0], 0.0)
    return out


def bowl(z0: float, z1: float, widest: float, count: int) -> np.ndarray:
    """Half-section of the bowl's inside from its bottom (0, z0) to the rim at z1: an egg cut off near the top."""
    t = np.linspace(0.0, 1.0, count)
    angle = t * math.radians(128.0)  # past the widest point (90 degrees) the wall leans in
    drop = 1.0 - math.cos(math.radians(128.0))
    return np.stack([widest * np.sin(angle), z0 + (z1 - z0) * (1.0 - np.cos(angle)) / drop], axis=1)


def glass_mesh():
    """Foot, stem and bowl as one closed surface; the part of its inside that the wine touches has its own material."""
    inside = bowl(0.108, 0.236, 0.0425, 57)
    # a vertex ring exactly at the wine's level, so that wine and glass share it
    wet = int(np.argmin(np.abs(inside[:, 1] - LEVEL)))
    inside[wet] = (np.interp(LEVEL, inside[:, 1], inside[:, 0]), LEVEL)
    outside = bowl(0.106, 0.236, 0.0438, 57)
    stem = curve([(0.0, 0.001), (0.018, 0.001), (0.036, 0.001), (0.0372, 0.0022), (0.0355, 0.0035),
                  (0.016, 0.0065), (0.0055, 0.013), (0.0038, 0.030), (0.0036, 0.060), (0.0042, 0.090),
                  (0.0075, 0.1015), (0.0148, 0.1098)], 6)
    start = int(np.argmax((outside[:, 0] > stem[-1, 0] + 0.001) & (outside[:, 1] > stem[-1, 1])))
    rim = [((inside[-1, 0] + outside[-1, 0]) / 2, inside[-1, 1] + 0.0005)]
    profile = np.concatenate([stem, outside[start:], rim, inside[::-1]])
    positions, faces, owner = common.lathe(profile, SEGMENTS)
    mesh = common.mesh_data("Glass", positions, faces, smooth=True)
    first_wet = len(profile) - 1 - wet  # the profile ends with the inside from the rim down
    slots = [1 if k >= first_wet else 0 for k in owner]
    mesh.polygons.foreach_set("material_index", slots)
    return mesh, float(inside[wet, 0])


def wine_surface(radius: float):
    """The wine's top: rings of a disk that ends on the glass, facing up."""
    profile = [(radius * (1.0 - k / 8.0), LEVEL) for k in range(9)]
    positions, faces, _ = common.lathe(profile, SEGMENTS)
    return common.mesh_data("Wine", positions, faces, smooth=True)


def add_set(scene) -> None:
    """Table and backdrop in one sheet, bent up behind."""
    bend = [(0.35 + 0.25 * math.sin(a), 0.25 - 0.25 * math.cos(a)) for a in np.linspace(0, math.pi / 2, 25)]
    section = [(-1.2, 0.0), *bend, (0.60, 1.4)]
    positions = [(x, y, z) for y, z in section for x in (-1.6, 1.6)]
    faces = [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(len(section) - 1)]
    mesh = common.mesh_data("Backdrop", positions, faces, smooth=True)
    mesh.materials.append(materials.diffuse("Linen", (0.66, 0.60, 0.52)))
    common.link(scene, "Backdrop", mesh)


def build(lamp_size: float = 0.03):
    """The glass between camera and a small lamp (diameter in m) behind it, so that its caustic falls toward the eye.

    Air to glass: IOR 1.5. Glass to wine, normals pointing from the glass into the wine: 1.5 / 1.345 inside over
    outside. Wine to air: 1.345. The wine's colour is that of the surfaces of the wine (no absorption by length).
    """
    scene = common.new_scene("wine_glass")
    common.set_world(scene, (0.8, 0.88, 1.0), 0.06)
    add_set(scene)
    mesh, radius = glass_mesh()
    mesh.materials.append(materials.glass("Glass", ior=GLASS_IOR))
    mesh.materials.append(materials.glass("Glass to Wine", RED, ior=GLASS_IOR / WINE_IOR))
    common.link(scene, "Glass", mesh)
    wine = wine_surface(radius)
    wine.materials.append(materials.glass("Wine", (1.0, 0.55, 0.55), ior=WINE_IOR))
    common.link(scene, "Wine", wine)
    common.add_light(
        scene, "AREA", "Lamp", (0.30, 0.26, 0.42), (0.0, 0.0, 0.10), 4.5, shape="DISK", size=lamp_size,
        color=(1.0, 0.94, 0.84),
    )
    common.add_light(
        scene, "AREA", "Fill", (-0.9, -0.5, 0.9), (0.0, 0.0, 0.1), 2.5, shape="SQUARE", size=0.5,
        color=(0.85, 0.92, 1.0),
    )
    common.add_camera(scene, (-0.10, -0.62, 0.30), (-0.022, -0.03, 0.108), 26.5)
    return scene
