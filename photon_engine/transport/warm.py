"""Compiles every kernel into the cache, by two passes of a tiny scene: with everything switched on, and as planned."""

from __future__ import annotations

import numpy as np

from ..issues import IssueLog
from ..scene.data import Camera, Frame, Graph, Instance, Light, Material, Mesh, Node, SceneData, Socket, World
from ..settings import Settings
from .renderer import Renderer


def warm_up() -> None:
    """Compile, or load, all that a render can need; a minute of work the first time, a second afterwards."""
    for plan in (False, True):  # what leaves out work has kernels too
        settings = Settings(plan=plan, caustic_photons=64, diffuse_photons=64, light_samples=1, threads=1)
        renderer = Renderer(warm_scene(), settings, IssueLog())
        try:
            renderer.prepare(lambda _text: None)
            renderer.render_pass(0, lambda: False)
        finally:
            renderer.close()


def warm_scene() -> SceneData:
    """A glass between two glossy squares under a lamp and a sky, with smooth normals and a texture; 8 x 8 pixels."""
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    normals = np.tile(np.float32([0.0, 0.6, 0.8]), (2, 3, 1))
    mesh = Mesh("Square", square, triangles, normals, None, uvs={"UV": np.zeros((2, 3, 2), np.float32)}, active_uv="UV")
    above, lamp, eye, ground, ceiling = (np.eye(4) for _ in range(5))
    seen = np.diag([1.0, -1.0, -1.0, 1.0])  # it shines up, into the camera
    seen[2, 3] = 2.0
    above[2, 3], lamp[2, 3], eye[2, 3], ceiling[2, 3] = 1.0, 3.0, 4.0, 5.0
    ground[:3, :3] *= 9.0  # so that rays from one large square do land on the other
    ceiling[:3, :3] *= 9.0
    return SceneData(
        name="Warm",
        meshes=[mesh],
        instances=[
            Instance(0, ground, [0], "Ground"),
            Instance(0, above, [1], "Pane"),
            Instance(0, ceiling, [0], "Ceiling"),
        ],
        materials=[Material("Glossy", _glossy()), Material("Glass", _glass())],
        lights=[
            Light("Lamp", "AREA", lamp, (10.0, 10.0, 10.0)),
            Light("Fill", "POINT", lamp, (1.0, 1.0, 1.0), cast_shadow=False),
            Light("Seen", "AREA", seen, (1.0, 1.0, 1.0), size=(0.5, 0.5), graph=_falling()),
        ],
        world=World(color=(0.1, 0.1, 0.1)),
        camera=Camera(matrix=eye),
        frame=Frame(8, 8, 0, 0, 8, 8),
    )


def _glass() -> Graph:
    """Clear glass."""
    inputs = {"Color": Socket([1.0, 1.0, 1.0, 1.0], kind="RGBA"), "Roughness": Socket(0.0), "IOR": Socket(1.5)}
    shader = Node("ShaderNodeBsdfGlass", "Glass", {}, inputs, {"BSDF": "SHADER"})
    return Graph([shader], Socket(None, 0, "BSDF", "SHADER"))


def _falling() -> Graph:
    """A lamp's nodes that follow the distance."""
    inputs = {"Strength": Socket(1.0), "Smooth": Socket(0.0)}
    falloff = Node("ShaderNodeLightFalloff", "Falloff", {}, inputs, {"Linear": "VALUE"})
    inputs = {"Color": Socket([1.0, 1.0, 1.0, 1.0], kind="RGBA"), "Strength": Socket(None, 0, "Linear")}
    shader = Node("ShaderNodeEmission", "Emission", {}, inputs, {"Emission": "SHADER"})
    return Graph([falloff, shader], Socket(None, 1, "Emission", "SHADER"))


def _glossy() -> Graph:
    """A Principled BSDF whose colour follows the UVs."""
    uv = Node("ShaderNodeTexCoord", "UV", {}, {}, {"UV": "VECTOR"})
    inputs = {"Base Color": Socket(None, 0, "UV", "RGBA"), "Roughness": Socket(0.3)}
    shader = Node("ShaderNodeBsdfPrincipled", "Principled", {}, inputs, {"BSDF": "SHADER"})
    return Graph([uv, shader], Socket(None, 1, "BSDF", "SHADER"))
