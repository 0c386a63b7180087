"""The pilot hears that it is to stop."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ...issues import IssueLog
from ...settings import Settings
from ..photon_rules import DIFFUSE
from ..pilot import run_pilot
from ..render_scene import RenderScene
from .test_shadowless import MATTE, plates


@pytest.mark.parametrize("stop", [False, True])
def test_pilot_stops_after_the_rays_under_way(stop):
    settings = Settings(plan=False)
    scene = RenderScene(plates(True, (MATTE, MATTE, MATTE)), settings, IssueLog(), lambda _text: None)
    closest, rays = scene.intersector.closest, []

    def counted(o: np.ndarray, d: np.ndarray, t_max=None):
        rays.append(len(o))
        return closest(o, d, t_max)

    scene.intersector.closest = counted
    with ThreadPoolExecutor(1) as pool:
        pilot = run_pilot(scene, pool, settings, [DIFFUSE], lambda: stop)
    assert (len(rays) == 1) if stop else (sum(rays) > 16384 and pilot.diffuse.bound > 0.0)
