"""A lamp without shadows lights every surface on its lines, by photons too."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ...issues import IssueLog
from ...scene.data import Camera, Frame, Graph, Instance, Light, Material, Mesh, Node, SceneData, Socket, World
from ...settings import Settings
from ..photon_kernels import ABSORBED, EMITTED, ESCAPED
from ..photon_pass import PhotonRun, trace_photons
from ..photon_rules import GLOBAL
from ..render_scene import RenderScene

MATTE, GLASS = "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass"
HEIGHTS = (-1.0, -2.0, -3.0)  # of the plates, below the lamp; each of them fills the same solid angle
PHOTONS = 60_000


def shader(kind: str, color) -> Graph:
    """A tree of one shader."""
    inputs = {"Color": Socket([*color, 1.0], kind="RGBA"), "Roughness": Socket(0.0), "IOR": Socket(1.5)}
    return Graph([Node(kind, "Shader", {}, inputs, {"BSDF": "SHADER"})], Socket(None, 0, "BSDF", "SHADER"))


def plates(cast_shadow: bool, kinds) -> SceneData:
    """Plates under a point lamp, one shader each."""
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    mesh = Mesh("Square", square, np.array([[0, 1, 2], [0, 2, 3]], np.int32), None, None)
    instances, materials = [], []
    for i, (height, kind) in enumerate(zip(HEIGHTS, kinds, strict=True)):
        matrix = np.diag([-height, -height, 1.0, 1.0])
        matrix[2, 3] = height
        instances.append(Instance(0, matrix, [i], f"Plate {i}"))
        color = (0.5,) * 3 if kind == MATTE else (1.0,) * 3
        materials.append(Material(f"Material {i}", shader(kind, color)))
    eye = np.eye(4)
    eye[2, 3] = 4.0
    return SceneData(
        name="Plates", meshes=[mesh], instances=instances, materials=materials,
        lights=[Light("Lamp", "POINT", np.eye(4), (12.0, 6.0, 3.0), cast_shadow=cast_shadow)], world=World(),
        camera=Camera(matrix=eye), frame=Frame(8, 8, 0, 0, 8, 8),
    )  # fmt: skip


def landed(cast_shadow: bool, kinds, plan: bool = False):
    """Red flux [W] of photons without a vertex that fell on each plate, and the tally."""
    scene = RenderScene(plates(cast_shadow, kinds), Settings(plan=plan), IssueLog(), lambda _text: None)
    with ThreadPoolExecutor(1) as pool:
        run = PhotonRun(GLOBAL, PHOTONS, np.uint64(7), 8)
        deposits, tally, _ = trace_photons(scene, pool, run, lambda: False)
    first = deposits.seen == 0
    height = deposits.position[:, 2] + scene.flat.origin[2]
    return [float(deposits.flux[first & (abs(height - h) < 0.1), 0].sum()) for h in HEIGHTS], tally


# a square seen from a point at half its edge above it fills a sixth of all directions
SIXTH = 12.0 / 6.0


# one plate of three is chosen: 60000 / 18 photons each, hence 1.5% noise
@pytest.mark.parametrize("plan", [False, True])
@pytest.mark.parametrize("cast_shadow", [True, False])
def test_every_plate_is_lit(cast_shadow, plan):
    flux, tally = landed(cast_shadow, (MATTE, MATTE, MATTE), plan)
    expected = [SIXTH, 0.0, 0.0] if cast_shadow else [SIXTH] * 3
    np.testing.assert_allclose(flux, expected, rtol=0.06)
    np.testing.assert_allclose(tally[EMITTED], tally[ABSORBED] + tally[ESCAPED], rtol=1e-5)


def test_glass_is_met_first_or_not_at_all():
    """Behind glass the plates are lit as if it were not there; what it bends comes from the front alone."""
    flux, _ = landed(False, (GLASS, MATTE, MATTE))
    np.testing.assert_allclose(flux, [0.0, SIXTH, SIXTH], rtol=0.06, atol=0.0)
    behind, _ = landed(False, (MATTE, GLASS, MATTE))
    np.testing.assert_allclose(behind, [SIXTH, 0.0, SIXTH], rtol=0.06, atol=0.0)
