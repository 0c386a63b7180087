"""Our own pictures for comparisons: passes until their block means are known well enough."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from photon_engine.driver.listener import Listener
from photon_engine.driver.session import Session
from photon_engine.issues import Issue, IssueLog
from photon_engine.settings import Settings

from .compare import MAX_NOISE, batch_block_errors, block_means, compare_blocks

# Averages over blocks gain nothing from wide gather radii but their bias: about a pixel each. Of the photons,
# those of the diffuse map decide the noise of a block's mean here; four shadow rays halve it for little time.
SETTINGS = Settings(
    passes=1, caustic_photons=20_000, diffuse_photons=100_000, caustic_radius=0.5, diffuse_radius=0.5, light_samples=4
)
MIN_PASSES = 12  # below, Student's tail is so wide that nothing is learnt
MARGIN = 0.7  # of the noise allowed may be ours, the rest is the reference's


class Picture(NamedTuple):
    """What we rendered."""

    mean: np.ndarray  # (h, w, 3) f32
    block_se: np.ndarray  # (rows, columns, 3), of the block means
    passes: int
    seconds: float
    issues: list[Issue]
    film: object


class UntilSure(Listener):
    """Stops the session when every lit block's mean is known to a part of the tolerance, or after `max_passes`.

    Never by the clock: the same machine must give the same verdict whatever else it does.
    """

    def __init__(self, tolerance: float, max_passes: int) -> None:
        self.tolerance = tolerance
        self.max_passes = max_passes
        self.means: list[np.ndarray] = []
        self.before: np.ndarray | None = None
        self.done = False

    def cancelled(self) -> bool:
        """Whether enough is known."""
        return self.done

    def picture(self, darkroom, final: bool) -> None:
        """Take the block means of the latest pass out of the film's sum."""
        film = darkroom.film
        if film.count == len(self.means):
            return  # the last pass is shown twice when the session ends
        total = film.picture("Combined")[:, :, :3].astype(np.float64) * film.count
        latest = total if self.before is None else total - self.before
        self.before = total
        self.means.append(block_means(latest))
        if len(self.means) >= MIN_PASSES and len(self.means) % 4 == 0:
            self.done = self.sure() or len(self.means) >= self.max_passes

    def sure(self) -> bool:
        """Whether the standard error of every lit block is inside the margin."""
        means = np.array(self.means)
        mean, se = means.mean(axis=0), batch_block_errors(means)
        lit = mean > 1e-3 * mean.mean()
        return bool((se[lit] < MARGIN * MAX_NOISE * self.tolerance * mean[lit]).all())


def render_current(settings: Settings = SETTINGS, tolerance: float = 0.01, max_passes: int = 96) -> Picture:
    """Extract Blender's current scene and render it until its block means are known."""
    import bpy

    from photon_engine.blender.extract import extract_scene
    from photon_engine.blender.load import read_render

    issues = IssueLog()
    scene = read_render(bpy.context.scene, bpy.context.view_layer, lambda depsgraph: extract_scene(depsgraph, issues))
    listener = UntilSure(tolerance, max_passes)
    session = Session(scene, settings.replace(passes=max_passes), issues)
    session.render(listener)
    mean = session.film.picture("Combined")[:, :, :3]
    errors = batch_block_errors(np.array(listener.means))
    return Picture(mean, errors, session.film.count, sum(session.durations), list(issues), session.film)


def judge(picture: Picture, reference, tolerance: float = 0.01):
    """The BlockReport of our picture against a Reference."""
    return compare_blocks(picture.mean, reference.mean, reference.se, tolerance, picture.block_se)
