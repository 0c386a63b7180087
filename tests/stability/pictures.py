"""Textures of odd sizes and values: a message, and the energy kept."""

from __future__ import annotations

import time

import numpy as np

from photon_engine.driver.session import Session
from photon_engine.issues import IssueLog, RenderError
from photon_engine.scene.data import Graph, Image, Material, Node, Socket, World
from photon_engine.settings import Settings
from tests.brute import scenes as s

from .lab import SMALL, Finding, case, same_randoms, shoot, told, within
from .transforms import lit_floor, plain

FLAT = 0.7


def textured(pixels, **options):
    """The plain room whose back wall is painted with an image."""
    scene = plain()
    index = [item.name.startswith("back") for item in scene.instances].index(True)
    if pixels is not None:
        scene.images.append(Image("Paint", np.asarray(pixels, np.float32), **options))
    props = {"image": 0 if pixels is not None else None, "interpolation": "Linear", "extension": "REPEAT"}
    image = Node("ShaderNodeTexImage", "Paint", props, {}, {"Color": "RGBA", "Alpha": "VALUE"})
    closure = s.closure("BsdfDiffuse", {"Color": Socket(node=0, output="Color", kind="RGBA"), "Roughness": Socket(0.0)})
    scene.materials[index] = Material("Painted", Graph([image, closure], Socket(node=1, output="BSDF", kind="SHADER")))
    mesh = scene.meshes[index]
    corners = mesh.positions[mesh.triangles][:, :, [0, 2]]
    mesh.uvs, mesh.active_uv = {"UV": (0.5 * corners + 0.5).astype(np.float32)}, "UV"
    return scene


def flat(height: int, width: int) -> np.ndarray:
    """An image of one colour, that of the plain wall."""
    out = np.full((height, width, 4), FLAT, np.float32)
    out[..., 3] = 1.0
    return out


def _size(height: int, width: int, short: bool = False) -> None:
    @case("images", f"{width} x {height} texels of one colour", "as the plain wall", short)
    def check() -> Finding:
        return same_randoms(shoot(plain()), shoot(textured(flat(height, width))))


for height, width in ((1, 1), (1, 16384), (16384, 1)):
    _size(height, width, short=height == width)


def _bad(name: str, value: float, message: str = "", short: bool = False) -> None:
    law = "as the plain wall but for one texel of 4096" + (", and a message" if message else "")

    @case("images", f"a texel of {name}", law, short)
    def check() -> Finding:
        pixels = flat(64, 64)
        pixels[30, 40, :3] = value
        shot = shoot(textured(pixels), 4)
        found = same_randoms(shoot(plain()), shot, allowed=0.05)
        heard = not message or told(shot, "Paint", message)
        return Finding(found.good and heard, found.figure + (", told" if message and heard else ""), shot.seconds)


NOT_FINITE = "not finite"
for name, value, message in (
    ("NaN", np.nan, NOT_FINITE), ("infinity", np.inf, NOT_FINITE), ("-1", -1.0, ""),
):  # fmt: skip
    _bad(name, value, message, short=name == "NaN")


@case("images", "no image in the node", "finite; magenta, as in Cycles")
def missing() -> Finding:
    shot = shoot(textured(None), 2)
    r, g, b = shot.mean("Direct")[8:16, 8:16].mean(axis=(0, 1))
    return Finding(g < 0.1 * r and r > 0.0, f"colour of the wall {r:.2g} {g:.2g} {b:.2g}", shot.seconds)


@case("images", "texels of 1e30", "the render ends with a message that names the image", short=True)
def beyond_single_precision() -> Finding:
    """Light that is reflected by it twice is no number any more: no picture is right, and it is no bug."""
    pixels = flat(64, 64)
    pixels[20:44, 20:44, :3] = 1e30
    start = time.process_time()
    try:
        Session(textured(pixels), Settings(**SMALL, passes=8), IssueLog()).render()
    except RenderError as error:
        said = str(error)
        return Finding("Paint" in said and "single precision" in said, said[:60], time.process_time() - start)
    return Finding(False, "no message", time.process_time() - start)


@case("images", "an HDR sun: one texel of 1e6 in a black sky", "irradiance by the texel's solid angle", short=True)
def hdr_sun() -> Finding:
    """Closest texel of 64 x 32 at 60 degrees over a floor that only it lights."""
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[26, 10, :3] = 1e6
    scene = lit_floor()
    scene.images.append(Image("Sky", pixels, colorspace="Non-Color"))
    props = {"image": 0, "interpolation": "Closest", "projection": "EQUIRECTANGULAR"}
    image = Node("ShaderNodeTexEnvironment", "Sky", props, {}, {"Color": "RGBA"})
    inputs = {"Color": Socket(node=0, output="Color", kind="RGBA"), "Strength": Socket(1.0)}
    back = Node("ShaderNodeBackground", "Background", {}, inputs, {"Background": "SHADER"})
    scene.world = World("World", Graph([image, back], Socket(node=1, output="Background", kind="SHADER")))
    low, high = (26 / 32 - 0.5) * np.pi, (27 / 32 - 0.5) * np.pi
    irradiance = 1e6 * 2.0 * np.pi / 64 * 0.5 * (np.sin(high) ** 2 - np.sin(low) ** 2)
    shot = shoot(scene, 8, light_samples=16)
    return within(float(shot.mean("Direct")[..., 0].mean()), irradiance * 0.5 / np.pi, 0.02, shot.seconds, "radiance")
