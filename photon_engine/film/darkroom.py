"""From a film to its pictures, without their noise where that is wanted.

Combined and each light pass are denoised by themselves: a denoised Combined is a little better than the sum of
denoised parts, so that sum does not hold exactly between denoised pictures. The raw ones are had as "Noisy ...".

Emission stays as rendered where its noise is small, in Combined too: the image of a lamp in a ball of glass is a pixel
or two a hundred times brighter than what is around them, which the denoiser takes for noise and spreads. On
cornell_caustics that made the denoised picture worse than the raw one, relMSE 0.051 instead of 0.014, raw 0.019.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

import numpy as np

from ..issues import IssueLog, RenderError
from .accumulate import Film
from .error import FEWEST_PASSES, brightness, error_picture, squared_bias, squared_noise
from .halves import FLOOR, DenoisedError, Halves, denoised_error, most, steady_share
from .oidn import BALANCED, HIGH, Guides, Oidn
from .passes import COMBINED, ERROR_MAPS, LIGHT_NAMES

EMISSION = "Emission"
DENOISED = (COMBINED.name, *LIGHT_NAMES)
PIXEL_SECONDS = 3e-6  # of a picture in balanced quality, by one core; a guess for the first time
PATIENCE = 0.5  # [s] that denoising may take after a cancel, when the last time tells that it will not take longer


def never() -> bool:
    """Nobody cancels."""
    return False


class Darkroom:
    """Makes the pictures of one film.

    denoise : OFF, FINAL or ALWAYS, as the setting;  threads : of the denoiser, 0: all
    cancelled : asked while it works;  halves : of the film's passes, where there are any
    """

    def __init__(
        self, film: Film, denoise: str, threads: int, issues: IssueLog, cancelled: Callable[[], bool] = never,
        halves: Halves | None = None,
    ) -> None:  # fmt: skip
        self.film = film
        self.denoise = denoise
        self.threads = threads
        self.issues = issues
        self.cancelled = cancelled
        self.halves = halves
        self.seconds = 0.0  # spent with denoising pictures
        self.cpu_seconds = 0.0  # of all threads
        self.version = ""  # of the denoiser, when it made the last pictures
        self.error_seconds = 4 * PIXEL_SECONDS * film.width * film.height  # that `error` takes, as known so far
        self._last = 0.0  # seconds that one picture took the last time; 0: not known
        self._guides: tuple[int, Guides] | None = None  # of a film of so many passes

    def pictures(self, names: Iterable[str], final: bool = True) -> dict[str, np.ndarray]:
        """Pictures by name, (h, w, c) f32, bottom row first; exposure applied.

        final : whether rendering is over. After a cancel they are denoised only when that is known to be quick.
        """
        film = self.film
        out = {name: error_picture(film, name) if name in ERROR_MAPS else film.picture(name) for name in names}
        wanted = [name for name in DENOISED if name in out and out[name][..., :3].any()]
        self.version = ""
        if not wanted or not self.film.count or self.denoise == "OFF" or not (final or self.denoise == "ALWAYS"):
            return out
        cancelled = self.cancelled
        if cancelled() and 0.0 < self._last * len(wanted) < PATIENCE:
            cancelled = never
        start, busy = time.perf_counter(), time.process_time()
        try:
            clean = self._clean({name: out[name] for name in wanted}, HIGH if final else BALANCED, cancelled)
        except RenderError as error:
            self.issues.warn(*error.issue[1:])
            self.denoise = "OFF"
            return out
        self.seconds += time.perf_counter() - start
        self.cpu_seconds += time.process_time() - busy
        if clean:
            self._last = (time.perf_counter() - start) / len(wanted)
        elif final:
            self.issues.info("Denoise", "cancelled: the picture keeps its noise")
        return out | clean

    def error(self) -> DenoisedError | None:
        """How wrong the denoised Combined still is; None when nothing is denoised, or not yet known, or cancelled.

        Of pictures in balanced quality, which have up to a fifth more error than the final ones.
        """
        halves = self.halves
        if self.denoise == "OFF" or halves is None or not halves.full or self.cancelled():
            return None
        start = time.perf_counter()
        raw = halves.pictures()
        emissions = halves.emissions() or (None, None)
        try:
            with Oidn(self.threads) as oidn:
                clean = [
                    self._denoised(oidn, {COMBINED.name: half}, emission, BALANCED, self.cancelled).get(COMBINED.name)
                    for half, emission in zip(raw, emissions, strict=True)
                ]
        except RenderError:
            return None  # pictures() tells of it
        self.error_seconds = time.perf_counter() - start
        if any(half is None for half in clean):
            return None
        return denoised_error(raw, tuple(clean), self._smeared())

    def _smeared(self) -> float:
        """Mean over the measured pixels of the relative squared bias of Combined; 0 where nothing is measured."""
        if self.film.count < FEWEST_PASSES or not self.film.measures:
            return 0.0
        film = self.film.measured()
        return most((squared_bias(film, COMBINED.name) / (brightness(film, COMBINED.name) ** 2 + FLOOR)).mean(axis=2))

    def _clean(
        self, raw: dict[str, np.ndarray], quality: int, cancelled: Callable[[], bool]
    ) -> dict[str, np.ndarray]:
        """The pictures denoised; empty when cancelled."""
        if cancelled():
            return {}
        with Oidn(self.threads) as oidn:
            clean = self._denoised(oidn, raw, self.film.picture("Emission"), quality, cancelled)
            self.version = oidn.version if clean else ""
        return clean

    def _denoised(
        self,
        oidn: Oidn,
        raw: dict[str, np.ndarray],
        emission: np.ndarray | None,
        quality: int,
        cancelled: Callable[[], bool],
    ) -> dict[str, np.ndarray]:
        """The pictures without noise, alpha kept; empty when cancelled. emission : what Combined has of it, or None."""
        guides = self.guides(oidn, cancelled)
        if guides is None:
            return {}

        def clean(picture: np.ndarray) -> np.ndarray | None:
            return oidn.color(np.ascontiguousarray(picture[..., :3]), guides, cancelled, quality)

        share = self._steady_share() if raw.keys() & {COMBINED.name, EMISSION} else None
        seen = None
        if share is not None and emission is not None:
            if (smooth := clean(emission)) is None:
                return {}
            seen = share * emission + (1.0 - share) * smooth
        out = {}
        for name, picture in raw.items():
            if seen is not None and name == EMISSION:
                out[name] = seen
                continue
            apart = seen is not None and name == COMBINED.name
            rest = clean(np.maximum(picture[..., :3] - emission, 0.0) if apart else picture)
            if rest is None:
                return {}
            out[name] = np.concatenate([rest + seen if apart else rest, picture[..., 3:]], axis=2)
        return out

    def _steady_share(self) -> np.ndarray | None:
        """How much of Emission is kept as rendered, (h, w, 1) f32; None where it is black or its noise not known."""
        film = self.film
        if not film.mean(EMISSION).any():
            return None
        if film.rows is None and film.count >= FEWEST_PASSES:
            mean, error = film.mean(EMISSION), np.sqrt(squared_noise(film, EMISSION))
            return steady_share(mean + error, mean - error)
        if self.halves is not None and min(self.halves.counts) and (pair := self.halves.emissions()) is not None:
            return steady_share(*pair)
        return None

    def guides(self, oidn: Oidn, cancelled: Callable[[], bool]) -> Guides | None:
        """The film's guides, without the noise that few passes, lenses and glass leave in them; cleaned once a pass."""
        if self._guides is not None and self._guides[0] == self.film.count:
            return self._guides[1]
        albedo = oidn.guide("albedo", np.clip(self.film.picture("Denoising Albedo"), 0.0, 1.0), cancelled)
        normal = None
        if albedo is not None:
            normal = oidn.guide("normal", np.clip(self.film.picture("Denoising Normal"), -1.0, 1.0), cancelled)
        if albedo is None or normal is None:
            return None
        self._guides = self.film.count, Guides(albedo, normal)
        return self._guides[1]
