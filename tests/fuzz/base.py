"""The scene whose file is broken: small, with one of each thing."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from photon_engine.scene.data import Graph, Image, Light, Material, Node, Socket, World
from photon_engine.scene.io import save_scene
from tests.brute import scenes as s


def save_base(folder: Path) -> Path:
    """The file of the scene."""
    path = folder / "base.npz"
    save_scene(base_scene(), path)
    return path


def base_scene():
    """Four lamps and a world over a floor with a picture on it, a glass ball and a mirror ball."""
    floor = s.quad((0, 0, -1), (1, 0, 0), (0, 1, 0), "floor")
    floor.uvs = {"UV": (0.5 * floor.positions[floor.triangles][:, :, :2] + 0.5).astype(np.float32)}
    floor.active_uv = "UV"
    floor.attributes = {"Col": np.full((2, 3, 4), 0.5, np.float32)}
    floor.tangents = {"UV": np.full((2, 3, 4), 0.5, np.float32)}
    floor.generated = floor.positions.copy()
    floor.material_index = np.zeros(2, np.int32)
    floor.island_random = np.full(2, 0.5, np.float32)
    parts = [
        (floor, painted()), (s.sphere((0.4, 0, -0.6), 0.4, 8), s.glass(1.5)),
        (s.sphere((-0.4, 0.3, -0.6), 0.4, 8), s.mirror(0.9)), (s.quad((0, 1, 0), (1, 0, 0), (0, 0, 1)), s.diffuse(0.5)),
    ]  # fmt: skip
    down = s.look_at((0.2, 0.1, 0.9), (0, 0, 0))
    lights = [
        s.area_lamp((0, 0, 0.95), (0, 0, 0), 0.5, 2.0), s.point_lamp((0.5, 0, 0.5), 0.1, 2.0),
        s.sun_lamp((0.3, 1, -0.7), 0.1, 1.0), Light("Spot", "SPOT", down, (3.0, 2.0, 1.0), 0.05, spot_size=0.7),
    ]  # fmt: skip
    scene = s.build(parts, lights, s.camera((0, -4, 0), (0, 0, 0), 0.34), picture=s.frame(8))
    inputs = {"Color": Socket((0.1, 0.2, 0.3, 1.0), kind="RGBA"), "Strength": Socket(1.0)}
    sky = Node("ShaderNodeBackground", "Sky", {}, inputs, {"Background": "SHADER"})
    scene.world = World("World", Graph([sky], Socket(node=0, output="Background", kind="SHADER")), (0.1, 0.2, 0.3))
    scene.images = [Image("Paint", np.full((4, 4, 4), 0.5, np.float32)), Image("Tile", tiles={1001: 0})]
    scene.camera.aperture_radius, scene.camera.focus_distance, scene.camera.blades = 0.05, 4.0, 5
    scene.instances[0].attributes = {"OBJECT:x": (1.0, 0.0, 0.0, 1.0)}
    return scene


def painted() -> Material:
    """An image on a Lambert, mixed by noise with another one, bumped and displaced."""
    color = {"Color": "RGBA", "Alpha": "VALUE"}
    nodes = [
        Node("ShaderNodeTexImage", "Paint", {"image": 0, "interpolation": "Linear", "extension": "REPEAT"}, {}, color),
        Node(
            "ShaderNodeTexNoise", "Noise", {"noise_dimensions": "3D", "noise_type": "FBM"},
            {"Vector": Socket(None, kind="VECTOR"), "Scale": Socket(5.0), "Detail": Socket(2.0),
             "Roughness": Socket(0.5), "Lacunarity": Socket(2.0), "Offset": Socket(0.0), "Gain": Socket(1.0),
             "Distortion": Socket(0.0), "W": Socket(0.0)}, {"Fac": "VALUE", "Color": "RGBA"},
        ),
        s.closure("BsdfDiffuse", {"Color": Socket(node=0, output="Color", kind="RGBA"), "Roughness": Socket(0.0)}),
        s.closure("BsdfAnisotropic", {"Color": Socket((0.5, 0.6, 0.7, 1.0), kind="RGBA"), "Roughness": Socket(0.3)}),
        s.closure("MixShader", {"Fac": Socket(node=1, output="Fac"), "Shader": shader(2), "Shader_001": shader(3)}),
    ]  # fmt: skip
    return Material("Painted", Graph(nodes, Socket(node=4, output="Shader", kind="SHADER")))


def shader(node: int) -> Socket:
    """A link to a closure."""
    return Socket(node=node, output="BSDF", kind="SHADER")
