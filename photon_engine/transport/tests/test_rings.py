"""A wall on a wide ground under sun and sky: its diffuse light is the same with and without disks, far less noisy."""

import dataclasses
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ...issues import IssueLog
from ...lights.rings import no_rings
from ...scene.data import Camera, Instance, Light, Material, World
from ...settings import Settings
from ..photon_pass import PhotonRun, trace_photons
from ..photon_rules import DIFFUSE
from ..pilot import run_pilot
from ..render_scene import RenderScene
from .test_shadowless import MATTE, plates
from .test_subsurface import flesh

HALF, RUNS = 20.0, 12
PHOTONS, EVEN_PHOTONS = 60_000, 1_000_000  # so many of those spread evenly bring 100 to the wall


def wall_on_ground():
    """A wall of 1 m, seen from 2 m, on a ground of 40 m."""
    scene = plates(True, (MATTE,) * 3)
    upright = np.array([[0.5, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 0.5, 0.0, 0.5], [0.0, 0.0, 0.0, 1.0]])
    eye = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, -2.0], [0.0, 1.0, 0.0, 0.6], [0.0, 0.0, 0.0, 1.0]])
    ground = np.diag([HALF, HALF, 1.0, 1.0])
    tilt = np.eye(4)
    tilt[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.8, -0.6], [0.0, 0.6, 0.8]]
    return dataclasses.replace(
        scene, instances=[Instance(0, ground, [0], "Ground"), Instance(0, upright, [1], "Wall")],
        lights=[Light("Sun", "SUN", tilt, (3.0, 3.0, 3.0))], world=World(color=(0.5, 0.5, 0.5)),
        camera=Camera(matrix=eye),
    )  # fmt: skip


def wall_light(scene, pool, photons: int) -> np.ndarray:
    """Diffuse flux on the wall [W], red, run by run."""
    found = []
    for i in range(RUNS):
        deposits, _, _ = trace_photons(scene, pool, PhotonRun(DIFFUSE, photons, np.uint64(100 + i), 8), lambda: False)
        p = deposits.position + scene.flat.origin
        on_wall = (np.abs(p[:, 1]) < 1e-3) & (np.abs(p[:, 0]) < 0.5) & (p[:, 2] > 1e-3)
        found.append(float(deposits.flux[on_wall, 0].sum()))
    return np.array(found)


def test_disks_change_the_noise_of_diffuse_light_and_not_its_mean():
    settings = Settings()
    scene = RenderScene(wall_on_ground(), settings, IssueLog(), lambda _text: None)
    with ThreadPoolExecutor(2) as pool:
        run_pilot(scene, pool, settings, [DIFFUSE], lambda: False)
        assert len(scene.rings.radius) >= 3, "the pilot has seen that the camera looks at little of the scene"
        aimed = wall_light(scene, pool, PHOTONS)
        scene.rings = no_rings(scene.lights)
        even = wall_light(scene, pool, EVEN_PHOTONS)
    error = np.hypot(aimed.std(ddof=1), even.std(ddof=1)) / RUNS**0.5
    assert abs(aimed.mean() - even.mean()) < 4.0 * error
    assert error < 0.1 * even.mean(), "measured 0.06"
    # measured 0.08; the ratio of two variances of 12 values each is known to a factor of 3
    assert aimed.var() * PHOTONS < 0.3 * even.var() * EVEN_PHOTONS


def test_what_scatters_below_the_surface_alone_is_seen_too():
    wall = wall_on_ground()
    flayed = dataclasses.replace(wall, materials=[Material(m.name, flesh().graph) for m in wall.materials])
    settings = Settings(diffuse_photons=1000)
    scene = RenderScene(flayed, settings, IssueLog(), lambda _text: None)
    with ThreadPoolExecutor(2) as pool:
        run_pilot(scene, pool, settings, [DIFFUSE], lambda: False)
    assert len(scene.rings.radius) >= 3
