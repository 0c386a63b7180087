"""Scenes moved, scaled and lit otherwise; each returns a new SceneData."""

from __future__ import annotations

import copy

import numpy as np

from tests.brute import scenes as s

from .lab import SIZE


def plain(variant: str = "lamp"):
    """The room with a glass and a mirror ball that all cases start from."""
    return s.cornell(variant, SIZE)


def scaled(scene, k: float):
    """Everything k times as large; lamps keep their radiance, so their power goes by the square."""
    out = copy.deepcopy(scene)
    for item in out.instances:
        item.matrix[:3] *= k
    camera = out.camera
    camera.matrix[:3, 3] *= k
    camera.clip_start, camera.clip_end = camera.clip_start * k, camera.clip_end * k
    camera.focus_distance, camera.aperture_radius = camera.focus_distance * k, camera.aperture_radius * k
    if camera.kind == "ORTHO":
        camera.window = tuple(k * side for side in camera.window)
    for light in out.lights:
        light.matrix = light.matrix.copy()
        light.matrix[:3, 3] *= k
        light.radius *= k
        light.size = (light.size[0] * k, light.size[1] * k)
        if light.kind != "SUN":
            light.strength = tuple(k * k * c for c in light.strength)
    return out


def moved(scene, offset):
    """Everything moved, in double."""
    out = copy.deepcopy(scene)
    for item in (*out.instances, out.camera, *out.lights):
        item.matrix = item.matrix.copy()
        item.matrix[:3, 3] += np.asarray(offset, float)
    return out


def brighter(scene, k: float):
    """Every light k times as strong."""
    out = copy.deepcopy(scene)
    for light in out.lights:
        light.strength = tuple(k * c for c in light.strength)
    out.world.color = tuple(k * c for c in out.world.color)
    return out


def with_mesh(scene, mesh, material=None, name="Odd", matrix=None):
    """One object more."""
    out = copy.deepcopy(scene)
    out.materials.append(material or s.diffuse(0.5))
    out.meshes.append(mesh)
    place = np.eye(4) if matrix is None else np.asarray(matrix, float)
    out.instances.append(s.Instance(len(out.meshes) - 1, place, [len(out.materials) - 1], name=name))
    return out


def lit_floor(*lights, size: int = 16, half_width: float = 0.05, albedo: float = 0.5, at=(0.0, 0.0, 0.0)):
    """A wide floor of Lambert at z = 0, seen straight down at one spot by a parallel camera from below the lamps."""
    floor = s.quad((0.0, 0.0, 0.0), (50.0, 0.0, 0.0), (0.0, 50.0, 0.0), "floor")
    eye = np.add(at, (0.2, 0.0, 0.15))
    view = s.camera(eye, at, half_width, kind="ORTHO")
    return s.build([(floor, s.diffuse(albedo))], lights, view, picture=s.frame(size))


def furnace(parts, size: int = 16, half_width: float = 0.2, **changes):
    """Objects of about 1 m around the origin in a world of radiance 1, seen at a slant from 3.6 m."""
    view = s.camera((1.7, -3.0, 1.2), (0.0, 0.0, 0.0), half_width, **changes)
    return s.build(parts, (), view, (1.0, 1.0, 1.0), s.frame(size))
