"""Pictures into Blender's render result, and what a render told while it ran."""

from __future__ import annotations

import time
from typing import Any

import bpy
import numpy as np

from ..driver.listener import Listener, Progress
from ..film.darkroom import Darkroom
from ..film.passes import BY_NAME
from ..issues import Issue, IssueLog, RenderError, Severity
from .cameras import extract_frame, frame_size

FIRST_INTERVAL = 0.5  # [s] between pictures shown while rendering
INTERVAL_SHARE = 0.1  # of the time spent so far, so that showing never costs much

_last_issues: list[Issue] = []  # of the last final render, for the panel
_last_plan: list[Any] = []  # its plan.Lines


def last_issues() -> list[Issue]:
    """What the last final render of this session told."""
    return list(_last_issues)


def last_plan() -> list[Any]:
    """What the last final render of this session did and left out, as plan.Lines."""
    return list(_last_plan)


def remember(issues: IssueLog, plan: Any = None) -> None:
    """Keep a render's issues and its plan.Plan for the panels."""
    _last_issues[:] = list(issues)
    _last_plan[:] = plan.lines() if plan is not None else []


def report(engine: bpy.types.RenderEngine, issues: IssueLog) -> None:
    """Show warnings and remarks to the user, each once."""
    levels = {Severity.INFO: {"INFO"}, Severity.WARNING: {"WARNING"}, Severity.ERROR: {"WARNING"}}
    for issue in issues:
        engine.report(levels[issue.severity], str(issue))


def picture_size(scene: bpy.types.Scene) -> tuple[int, int]:
    """Width and height of what Blender expects in a result: the frame, or its border [px]."""
    try:
        frame = extract_frame(scene)
    except RenderError:  # of no use; the render will say so
        return frame_size(scene.render)
    return frame.x1 - frame.x0, frame.y1 - frame.y0


def write_film(engine: bpy.types.RenderEngine, darkroom: Darkroom, layer: str, final: bool) -> None:
    """Put the film's pictures into the result of a view layer, and merge it."""
    film = darkroom.film
    result = engine.begin_result(0, 0, film.width, film.height, layer=layer)
    targets = {target.name: target for target in result.layers[0].passes if target.name in BY_NAME}
    for name, picture in darkroom.pictures(targets, final).items():
        targets[name].rect.foreach_set(picture.ravel())
    engine.end_result(result)


def write_black(engine: bpy.types.RenderEngine, size: tuple[int, int], layer: str) -> None:
    """A merged black result: without one, saving a multilayer EXR crashes Blender (4.5 to 5.2)."""
    result = engine.begin_result(0, 0, *size, layer=layer)
    for target in result.layers[0].passes:
        target.rect.foreach_set(np.zeros(size[0] * size[1] * target.channels, np.float32))
    engine.end_result(result)


class EngineListener(Listener):
    """Tells Blender how a render goes, and asks it whether to stop."""

    def __init__(self, engine: bpy.types.RenderEngine, layer: str, show: bool) -> None:
        self.engine = engine
        self.layer = layer
        self.show = show  # whether someone sees pictures before the last one
        self.begin = time.monotonic()
        self.shown = self.begin
        self.cost = 0.0  # of showing a picture [s]
        self.wrote = False

    def cancelled(self) -> bool:
        """Whether Esc was pressed."""
        return self.engine.test_break()

    def stage(self, text: str) -> None:
        """Show the stage in the header."""
        if self.show or not text.startswith("Pass "):  # in the background each is a printed line
            self.engine.update_stats("", text)

    def progress(self, progress: Progress) -> None:
        """Show progress and memory."""
        self.engine.update_progress(progress.fraction)
        self.engine.update_stats("", str(progress))
        self.engine.update_memory_stats(memory_used=progress.memory, memory_peak=progress.memory_peak)

    def picture(self, darkroom: Darkroom, final: bool) -> None:
        """Show the picture so far, not too often, and the final one always."""
        now = time.monotonic()
        interval = max(FIRST_INTERVAL, INTERVAL_SHARE * (now - self.begin), self.cost / INTERVAL_SHARE)
        if not final and not (self.show and now - self.shown >= interval):
            return
        if final and darkroom.denoise != "OFF":
            self.engine.update_stats("", "Denoising")
        write_film(self.engine, darkroom, self.layer, final)
        self.wrote = True
        self.shown = time.monotonic()
        self.cost = self.shown - now
