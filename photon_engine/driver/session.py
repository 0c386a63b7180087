"""One progressive render: passes until the budget is spent, kept whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from ..film.accumulate import Film
from ..film.darkroom import Darkroom
from ..film.error import MOST_MEASURED
from ..film.halves import Halves
from ..film.passes import ALL_NAMES, ERROR_MAPS
from ..issues import IssueLog, RenderError, StopReason
from ..scene.data import SceneData
from ..settings import Settings
from .checks import check_picture, check_scene
from .listener import Listener, Progress, memory, seconds_left
from .overflow import overflow_error
from .watch import ErrorWatch
from .worker import Abandoned, Worker

# settings that say how long and how fast, not what: films that differ in these can be merged
NOT_PICTURE = ("passes", "seconds", "error", "error_share", "error_pass", "seed", "threads", "plan", "denoise")
MEASURING = "Measuring the error"
DENOISED_SHARE = 0.1  # of the time spent on passes that estimates of the denoised picture's error may take


def default_renderer(scene: SceneData, settings: Settings, issues: IssueLog, outputs: frozenset[str], kept: Any) -> Any:
    """The photon mapper; imported when first needed, since it compiles kernels."""
    from ..transport.renderer import Renderer

    return Renderer(scene, settings, issues, outputs, kept)


class _CancelledEarly(Exception):
    """Raised from a stage callback, to leave the preparation."""


class Session:
    """Renders a scene into a film.

    After `render`: `film`, `stop`, `durations` (seconds of each pass), `stages` (seconds by name), `statistics`,
    `plan`, `watch` (the curve of the error). An exception leaves `film` with all passes that were finished.
    """

    def __init__(
        self,
        scene: SceneData,
        settings: Settings,
        issues: IssueLog,
        renderer_factory: Callable[[SceneData, Settings, IssueLog, frozenset[str], Any], Any] | None = None,
        outputs: frozenset[str] = ALL_NAMES,
        kept: Any = None,
    ) -> None:
        """Ready to render.

        outputs : names of film.passes; the others are not computed, and stay black;  kept : what another session left
        in its `kept`, to spare what the scenes share
        """
        self.scene = scene
        self.settings = settings.resolved()  # so that the film and the log say what was used
        self.issues = issues
        self.outputs = outputs
        self.kept = kept
        self.renderer_factory = renderer_factory or default_renderer
        self.film: Film | None = None
        self.darkroom: Darkroom | None = None
        self.denoised_errors: list[dict[str, float]] = []  # of the denoised Combined, at 4, 8, 16, ... passes
        self.stop: StopReason | None = None
        self.durations: list[float] = []
        self.cpu_seconds = 0.0  # of all threads, spent with passes
        self.stages: dict[str, float] = {}
        self.statistics: dict[str, Any] = {}
        self.watch = ErrorWatch(settings)
        self.plan: Any = None  # the renderer's plan.Plan

    def new_film(self) -> Film:
        """An empty film of this scene and these settings; with each pixel's variance if a map of it is asked for."""
        frame = self.scene.frame
        from ..plan import every_variance  # here: it loads numba, and Blender only enables the extension

        most = None if every_variance(self.settings, self.outputs) else MOST_MEASURED
        film = Film(frame.y1 - frame.y0, frame.x1 - frame.x0, self.settings.seed, frame.exposure, most)
        picture_settings = {k: v for k, v in self.settings.to_dict().items() if k not in NOT_PICTURE}
        film.meta = {
            "scene": f"{self.scene.name}, frame {self.scene.frame_number}, {self.scene.camera.name}",
            "settings": picture_settings,
            "outputs": sorted(self.outputs),
            "seconds": 0.0,
        }
        return film

    def render(
        self, listener: Listener | None = None, film: Film | None = None, first: int = 0, endless: bool = False
    ) -> StopReason:
        """Add passes to the film until a budget is spent or the listener cancels.

        film : to go on with, or None for a new one;  first : lowest pass to render (those in the film are not repeated)
        endless : whether a budget without limits is allowed (someone watches and can cancel)
        The time budget counts passes only, not preparation; at least one pass is rendered.
        """
        if not (self.settings.passes or self.settings.seconds or self.settings.error or endless):
            unlimited = "neither passes nor seconds nor an error limit the render"
            raise RenderError("Budget", unlimited, "set one of them above 0")
        check_scene(self.scene, self.issues)
        listener = listener or Listener()
        fresh = self.new_film() if film is None else film
        if film is not None:
            fresh._check_meta(self.new_film())
            if self.outputs & ERROR_MAPS and film.rows is not None:
                raise RenderError("Noise, Bias", "the saved film lacks most of the variance", "start with --maps")
        self.film = fresh
        self._halves = Halves(fresh.height, fresh.width, fresh.exposure) if self.settings.denoise != "OFF" else None
        self.darkroom = Darkroom(
            fresh, self.settings.denoise, self.settings.threads, self.issues, listener.cancelled, self._halves
        )
        self._render(Worker(listener), max(first, self.film.next_pass))
        if self.film.count:
            if "Combined" in self.outputs:
                check_picture(self.scene, self.film.picture("Combined"), self.issues)
            self._measure(last=True)
            self._measure_denoised(last=True)
            self.finish(listener)
        return self.stop

    def _render(self, worker: Worker, first: int) -> None:
        """Make the renderer, let it prepare and render, let it go."""
        renderer = None
        try:
            renderer = worker.call(
                lambda: self.renderer_factory(self.scene, self.settings, self.issues, self.outputs, self.kept)
            )
            worker.on_late_end = renderer.close
            self._prepare(renderer, worker)
            self.stop = self._run(renderer, worker, first)
        except (Abandoned, _CancelledEarly):
            self.stop = StopReason.CANCELLED
        finally:
            if renderer is not None:
                self.statistics = dict(renderer.statistics)
                self.plan = getattr(renderer, "plan", None)
                # abandoned work may still be changing it
                self.kept = None if worker.abandoned else getattr(renderer, "kept", None)
                if not worker.abandoned:
                    renderer.close()

    def _run(self, renderer: Any, worker: Worker, first: int) -> StopReason:
        """Pass after pass."""
        listener = worker.listener
        stop = None
        while stop is None:
            index = first + len(self.durations)
            listener.stage(f"Pass {index + 1}")
            begin, busy = time.perf_counter(), time.process_time()
            try:
                image = worker.call(lambda index=index: renderer.render_pass(index, worker.stop.is_set))
                if image is None:
                    stop = StopReason.CANCELLED
                    break
                self.film.add(index, image)
                if self._halves is not None:
                    self._halves.add(image)
            except Abandoned:
                raise
            except FloatingPointError as error:
                error.add_note(f"while rendering pass {index} of seed {self.settings.seed}")
                raise overflow_error(self.scene, error) or error from error
            except Exception as error:
                error.add_note(f"while rendering pass {index} of seed {self.settings.seed}")
                raise
            self.durations.append(time.perf_counter() - begin)
            self.cpu_seconds += time.process_time() - busy
            self.film.meta["seconds"] += self.durations[-1]
            self._measure(last=False)
            stop = StopReason.CANCELLED if listener.cancelled() else self._spent()
            self._measure_denoised(last=False)
            listener.progress(self.progress())
            if stop is None:
                listener.picture(self.darkroom, final=False)
        return stop

    def _measure_denoised(self, last: bool) -> None:
        """Estimate the denoised picture's error at 4, 8, 16, ... passes, while that is cheap, and at the end."""
        passes = len(self.durations)
        if self._halves is None or passes < 4 or passes in [item["passes"] for item in self.denoised_errors]:
            return
        dear = self.darkroom.error_seconds > DENOISED_SHARE * sum(self.durations)
        if not last and (dear or passes & (passes - 1)):
            return
        begin = time.perf_counter()
        error = self.darkroom.error()
        self._add_stage(MEASURING, time.perf_counter() - begin)
        if error is not None:
            self.denoised_errors.append({"passes": passes, "seconds": sum(self.durations), **error._asdict()})

    def finish(self, listener: Listener) -> None:
        """Hand over the last picture of what the film holds."""
        listener.picture(self.darkroom, final=True)
        if self.darkroom.seconds:
            self.stages["Denoising"] = self.darkroom.seconds

    def _measure(self, last: bool) -> None:
        """Measure the error, if it is time to."""
        begin = time.perf_counter()
        look = self.watch.measure_all if last else self.watch.measure
        look(self.film, self.film.meta["seconds"])
        self._add_stage(MEASURING, time.perf_counter() - begin)

    def _add_stage(self, name: str, seconds: float) -> None:
        """Count the time of a stage."""
        self.stages[name] = self.stages.get(name, 0.0) + seconds

    def _prepare(self, renderer: Any, worker: Worker) -> None:
        """Let the renderer build what it needs, timing each stage it names."""
        names = ["Preparing"]
        since = [time.perf_counter()]

        def end_stage() -> None:
            now = time.perf_counter()
            self._add_stage(names[-1], now - since[-1])
            since.append(now)

        def stage(text: str) -> None:
            end_stage()
            names.append(text)
            worker.stage(text)
            if worker.stop.is_set():
                raise _CancelledEarly

        stage("Preparing")
        worker.call(lambda: renderer.prepare(stage, worker.stop.is_set))
        end_stage()

    def _spent(self) -> StopReason | None:
        """Which budget is used up, if any."""
        if self.settings.passes and len(self.durations) >= self.settings.passes:
            return StopReason.PASSES
        if self.settings.seconds and sum(self.durations) >= self.settings.seconds:
            return StopReason.SECONDS
        if self.watch.met():
            return StopReason.ERROR
        return None

    def progress(self) -> Progress:
        """Where the render is now."""
        total, limit = self.settings.passes, self.settings.seconds
        done, elapsed = len(self.durations), sum(self.durations)
        spent = self.film.meta["seconds"]
        lefts = [seconds_left(self.durations, total, limit), self.watch.seconds_left(spent)]
        left = min((left for left in lefts if left is not None), default=None)
        fractions = [done / total] if total else []
        fractions += [elapsed / limit] if limit else []
        fractions += [self.watch.fraction(spent) or 0.0]
        fraction = 1.0 if self.watch.met() else min(max(fractions), 1.0)
        return Progress(done, total, elapsed, left, fraction, *memory(), self.watch.error, self.settings.error)
