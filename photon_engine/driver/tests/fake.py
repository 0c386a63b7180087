"""A renderer without physics: values fixed by (seed, pass), to test what is around it."""

import os
import time

import numpy as np

from ...film.passes import BIASES, RAW
from ...scene.data import Frame, Instance, Light, Mesh, SceneData


class FakeRenderer:
    """Has the interface of transport.renderer.Renderer; a pass takes PHOTON_MAP_FAKE_SECONDS (default 0)."""

    def __init__(self, scene, settings, issues, outputs=frozenset(), kept=None):
        self.scene, self.settings, self.issues = scene, settings, issues
        self.statistics = {"photons": np.int64(0)}
        self.closed = False
        self.fail_at = int(os.environ.get("PHOTON_MAP_FAKE_FAIL", -1))
        self.seconds = float(os.environ.get("PHOTON_MAP_FAKE_SECONDS", 0.0))

    def prepare(self, stage, cancelled):
        stage("Building the tree")

    def render_pass(self, i, cancelled):
        if i == self.fail_at:
            raise ValueError("a bug on purpose")
        until = time.monotonic() + self.seconds
        while True:
            if cancelled():
                return None
            if time.monotonic() >= until:
                break
            time.sleep(0.01)
        self.statistics["photons"] += 10
        rng = np.random.default_rng([self.settings.seed, i])
        frame = self.scene.frame
        size = (frame.y1 - frame.y0, frame.x1 - frame.x0)
        image = {name: rng.random((*size, c)).astype(np.float32) for name, c in RAW.items()}
        image["Alpha"][:] = 1.0
        for name in BIASES.values():
            image[name][:] = 0.0
        return image

    def close(self):
        self.closed = True


def triangle_scene(width=8, height=6):
    """One lit triangle."""
    mesh = Mesh("Mesh", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32), None, None)
    return SceneData(
        name="Test",
        meshes=[mesh],
        instances=[Instance(0, np.eye(4), [-1], "Triangle")],
        lights=[Light("Lamp", "POINT", np.eye(4), (1.0, 1.0, 1.0))],
        frame=Frame(width, height, 0, 0, width, height),
    )
