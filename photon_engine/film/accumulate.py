"""The film: means over the passes of the progressive loop, their variance, and merging.

Values are kept as plain sums in double. A pass holds float32 values (24 bits), so a sum of N of them is exact in double
as long as their sizes differ by less than 2^29 / N: passes [0, 4) merged with [4, 8) give the bits of [0, 8).

Second moments are kept as sums of squared deviations from the mean (Welford's update, Chan's when merging), since
sum x^2 - (sum x)^2 / n loses all digits where a bright steady part hides a dim noisy one: after a million passes of
mean 1e6 it showed a deviation of 0.2 where there was 1e-3. Merged variances agree to rounding, not to the bit.

A picture that has been black so far has no sums, and one that did not vary no squares: what a render leaves out takes
no memory.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..issues import RenderError
from ..scene.archive import Archive, BadArchive
from .output import OutputError, check_writable
from .passes import BACKGROUND_DEPTH, BIASES, BY_NAME, LIGHT_NAMES, MEASURED, NOISY, RAW

FORMAT = 4
STRIP = 16  # [px] rows that are measured together: more than any neighbourhood in film/error.py


class Film:
    """Sums over passes of one picture, bottom row first.

    height, width : of the pictures [px];  seed : of the passes added;  exposure : multiplies light when read, not
    in the sums;  most_measured : keep what error bars need (estimates of the bias, sums of squares: more than the
    pictures themselves) of strips of rows with at most this many pixels in all. None: of all, 0: of none.
    """

    def __init__(
        self, height: int, width: int, seed: int = 0, exposure: float = 1.0, most_measured: int | None = None
    ) -> None:
        self.height = height
        self.width = width
        self.seed = seed
        self.exposure = exposure
        self.most_measured = most_measured
        self.rows = measured_rows(height, width, most_measured)  # None: all
        self.blocks: list[tuple[int, int, int]] = []  # (seed, first pass, end) of what is in, sorted, disjoint
        self.sums: dict[str, np.ndarray] = {}  # raw picture -> (h, w, c) f64, biases (rows, w, 3)
        # one of MEASURED -> (rows, w, 3) f64, the sum over passes of the squared deviation from the mean
        self.squares: dict[str, np.ndarray] = {}
        self.depth = np.full((height, width, 1), np.float32(BACKGROUND_DEPTH))
        self.depth_block = (2**63, 2**63)  # (pass, seed) that the depth is of: the lowest wins, whatever the order
        self.meta: dict = {}  # what rendered it (settings, scene name), saved along

    @property
    def count(self) -> int:
        """How many passes are in."""
        return sum(end - start for _, start, end in self.blocks)

    @property
    def measures(self) -> bool:
        """Whether it keeps what error bars need."""
        return self.rows is None or len(self.rows) > 0

    @property
    def next_pass(self) -> int:
        """The first pass of this seed that comes after all that are in."""
        return max((end for seed, _, end in self.blocks if seed == self.seed), default=0)

    def add(self, index: int, image: dict[str, np.ndarray]) -> None:
        """Add pass `index` of this film's seed.

        image : name -> (h, w, c) f32 for every name in passes.RAW
        A value that is not a number is a bug in the transport and raises FloatingPointError, naming pass and pixel; the
        film is then as before.
        """
        blocks = _united([*self.blocks, (self.seed, index, index + 1)])
        for name, channels in RAW.items():
            self._check(name, channels, image[name])
        rows = slice(None) if self.rows is None else self.rows
        lit = {name: image[name] for name in RAW if name != "Depth" and image[name].any()}
        if not self.measures:
            lit = {name: picture for name, picture in lit.items() if name not in BIASES.values()}
        if self.measures and self.count:  # the first pass does not deviate from itself
            self._add_deviations(lit, rows)
        for name, picture in lit.items():
            _add(self.sums, name, picture[rows] if name in BIASES.values() else picture)
        if (index, self.seed) < self.depth_block:
            self.depth_block = (index, self.seed)
            self.depth = np.minimum(image["Depth"], np.float32(BACKGROUND_DEPTH))
        self.blocks = blocks

    def _add_deviations(self, lit: dict[str, np.ndarray], rows) -> None:
        """Add a pass's squared deviations from the mean of those before; lit: its raw pictures that are not black."""
        n = self.count
        for name, parts in MEASURED.items():
            values = [lit[part][rows].astype(np.float64) for part in parts if part in lit]
            if not values and not any(part in self.sums for part in parts):
                continue
            gap = sum(values[1:], values[0] if values else 0.0) - self._measured_total(name) / n
            gap *= gap
            gap *= n / (n + 1.0)
            _add(self.squares, name, gap)

    def _check(self, name: str, channels: int, values: np.ndarray) -> None:
        """Raise when a pass has the wrong shape or holds a NaN or (but for Depth) an infinity."""
        expected = (self.height, self.width, channels)
        if values.shape != expected or values.dtype != np.float32:
            raise ValueError(f"{name} is {values.dtype} {values.shape}, expected float32 {expected}")
        bad = np.isnan(values) if name == "Depth" else ~np.isfinite(values)
        if bad.any():
            y, x, _ = np.argwhere(bad)[0]
            raise FloatingPointError(f"{name} has {int(bad.sum())} values that are not finite, first at x={x}, y={y}")

    def merge(self, other: Film) -> None:
        """Take in another film's passes, of the same picture; each pass may be in only one of them."""
        if (other.height, other.width, other.exposure) != (self.height, self.width, self.exposure):
            raise RenderError("merge", "the films differ in size or exposure", "render both with the same settings")
        self._check_meta(other)
        blocks = _united([*self.blocks, *other.blocks])
        if self.most_measured != other.most_measured:
            raise RenderError("merge", "error bars are kept of different pixels", "save both with the same --maps")
        if self.measures and self.count and other.count:
            weight = self.count * other.count / (self.count + other.count)
            for name in MEASURED:
                gap = self._measured_total(name) / self.count - other._measured_total(name) / other.count
                if np.any(gap):
                    _add(self.squares, name, np.asarray(gap * gap * weight))
        for mine, theirs in ((self.sums, other.sums), (self.squares, other.squares)):
            for name, total in theirs.items():
                _add(mine, name, total)
        if other.depth_block < self.depth_block:
            self.depth_block, self.depth = other.depth_block, other.depth.copy()
        self.meta["seconds"] = self.meta.get("seconds", 0.0) + other.meta.get("seconds", 0.0)
        self.blocks = blocks

    def _check_meta(self, other: Film) -> None:
        """Refuse films of different scenes or settings: their mean would be a picture of neither."""
        for key in ("scene", "settings", "outputs"):
            mine, theirs = self.meta.get(key), other.meta.get(key)
            if mine is not None and theirs is not None and mine != theirs:
                text = _difference(mine, theirs)
                raise RenderError("merge", f"the films differ in {key}: {text}", "merge passes of one render")

    def picture(self, name: str) -> np.ndarray:
        """The mean of one pass: (h, w, c) f32, exposure applied; zero before the first pass, with no depth.

        Combined is the sum of the five light passes, its alpha the mean of Alpha. "Noisy X" is X: see film/darkroom,
        which also makes the maps of the errors.
        """
        name = name.removeprefix(NOISY)
        if name == "Depth":
            return self.depth
        n = max(self.count, 1)
        if name == "Combined":
            rgb = self._added(LIGHT_NAMES) * (self.exposure / n)
            return np.concatenate([rgb, self._added(("Alpha",)) / n], axis=2).astype(np.float32)
        factor = self.exposure if name in BY_NAME and BY_NAME[name].is_light else 1.0
        return (self._added((name,)) * (factor / n)).astype(np.float32)

    def mean(self, name: str) -> np.ndarray:
        """The mean of one of passes.MEASURED: (h, w, 3) f64, exposure applied; zero before the first pass."""
        return self._total(name) * (self.exposure / max(self.count, 1))

    def variance(self, name: str) -> np.ndarray:
        """Variance of one pass of the loop, unbiased: (h, w, 3) f64, of one of passes.MEASURED, exposure applied.

        The squared standard error of the mean is this over `count`. NaN with fewer than two passes: not known.
        """
        n = self.count
        if self.rows is not None:
            raise ValueError("only some rows have a variance: ask film.measured()")
        if n < 2:
            return np.full((self.height, self.width, 3), np.nan)
        if name not in self.squares:  # every pass had the same
            return np.zeros((self.height, self.width, 3))
        return self.squares[name] / (n - 1) * self.exposure**2

    def _total(self, name: str) -> np.ndarray:
        """The sum over passes of one of passes.MEASURED."""
        return self._added(MEASURED[name])

    def _added(self, names: Iterable[str]) -> np.ndarray:
        """The sum of some raw pictures' sums, not to be written to; zeros where all are black."""
        parts = [self.sums[name] for name in names if name in self.sums]
        return sum(parts[1:], parts[0]) if parts else np.zeros((self.height, self.width, RAW[next(iter(names))]))

    def _measured_total(self, name: str) -> Any:
        """The sum over passes of one of passes.MEASURED in the rows that are measured; 0.0 where all is black."""
        rows = slice(None) if self.rows is None else self.rows
        kept = BIASES.values()
        parts = [self.sums[part][slice(None) if part in kept else rows] for part in MEASURED[name] if part in self.sums]
        return sum(parts[1:], parts[0]) if parts else 0.0

    def measured(self) -> Film:
        """The film's measured rows as a film of their own, for figures; this one where all are.

        Neighbours in the result are neighbours in the picture within strips of STRIP rows.
        """
        if self.rows is None:
            return self
        part = Film(0, self.width, self.seed, self.exposure)
        part.height, part.blocks, part.squares = len(self.rows), self.blocks, self.squares
        for name, total in self.sums.items():
            part.sums[name] = total if name in BIASES.values() else total[self.rows]
        return part

    def save(self, path: str | Path) -> None:
        """Write the sums, so that the render can go on or be merged."""
        head = {
            "format": FORMAT, "height": self.height, "width": self.width, "seed": self.seed, "exposure": self.exposure,
            "most_measured": self.most_measured, "blocks": self.blocks, "depth_block": self.depth_block,
            "meta": self.meta,
        }  # fmt: skip
        arrays = {f"sum.{name}": a for name, a in self.sums.items()}
        arrays |= {f"square.{name}": a for name, a in self.squares.items()}
        check_writable(path)
        partial = Path(f"{path}.partial")
        try:
            with partial.open("wb") as file:
                np.savez_compressed(file, head=json.dumps(head), depth=self.depth, **arrays)
            partial.replace(path)
        except OSError as error:
            partial.unlink(missing_ok=True)
            raise OutputError(str(path), f"cannot be written: {error.strerror}", "choose another place") from error

    @classmethod
    def load(cls, path: str | Path) -> Film:
        """Read what `save` wrote; a RenderError when the file is missing or something else."""
        try:
            with Archive(path, text=True) as file:
                return cls._read(file)
        except FileNotFoundError:
            raise RenderError(str(path), "no such file", "check the path") from None
        except (BadArchive, KeyError, TypeError, ValueError, RecursionError) as error:
            text = f" ({error})" if isinstance(error, BadArchive) else ""
            raise RenderError(
                str(path), f"is not a saved film{text}", "give a file written with --state by this version"
            ) from error
        except OSError as error:
            raise RenderError(str(path), f"cannot be read: {error.strerror}", "check the file") from error

    @classmethod
    def _read(cls, file: Archive) -> Film:
        """The film in an archive; a KeyError, TypeError or ValueError when it is none."""
        head = json.loads(str(file.read("head")))
        if head["format"] != FORMAT:
            raise BadArchive(f"format {head['format']}, this program reads {FORMAT}")
        height, width, most = head["height"], head["width"], head["most_measured"]
        shape = file.headers["depth"].shape
        if shape != (height, width, 1) or not (most is None or (type(most) is int and most >= 0)):
            raise BadArchive("its pictures do not fit together")
        film = cls(height, width, head["seed"], float(head["exposure"]), most)
        film.blocks = _united([_block(block) for block in head["blocks"]])
        pass_, seed = head["depth_block"]
        film.depth_block, film.meta = (int(pass_), int(seed)), dict(head["meta"])
        film.meta["seconds"] = float(film.meta.get("seconds", 0.0))
        rows = height if film.rows is None else len(film.rows)
        film.depth = _as_kept(file, "depth", (height, width, 1), np.float32)
        for key in set(file.headers) - {"head", "depth"}:
            kind, _, name = key.partition(".")
            if kind not in ("sum", "square") or name == "Depth" or name not in (RAW if kind == "sum" else MEASURED):
                raise BadArchive(f"'{key}' is unknown")
            measured = kind == "square" or name in BIASES.values()
            shape = (rows, width, 3) if measured else (height, width, RAW[name])
            (film.sums if kind == "sum" else film.squares)[name] = _as_kept(file, key, shape, np.float64)
        return film


def _add(totals: dict[str, np.ndarray], name: str, values: np.ndarray) -> None:
    """Add to the entry of that name, in double; the first makes it."""
    if name in totals:
        totals[name] += values
    else:
        totals[name] = values.astype(np.float64)


def _as_kept(file: Archive, name: str, shape: tuple, dtype: type) -> np.ndarray:
    """An array of a saved film, of the shape and type that the film has, and finite."""
    header = file.headers.get(name)
    if header is None or (header.shape, header.dtype) != (shape, dtype):
        raise BadArchive(f"'{name}' is not as it should be")
    array = file.read(name)
    if not np.isfinite(array).all():
        raise BadArchive(f"'{name}' is not finite")
    return array


def _block(block: list) -> tuple[int, int, int]:
    """Seed, first pass and end of a block of passes."""
    seed, start, end = block
    if not all(type(number) is int for number in block) or not 0 <= start < end:
        raise BadArchive("its passes are not numbers")
    return seed, start, end


def measured_rows(height: int, width: int, most: int | None) -> np.ndarray | None:
    """Indices of the rows whose moments are kept, in strips spread over the picture; None where all are."""
    if most is None or height * width <= most:
        return None
    if not most:
        return np.zeros(0, np.intp)
    every = -(-height * width // most)
    first = min(every, -(-height // STRIP)) // 2  # a flat picture may have fewer strips than that
    return np.flatnonzero(np.arange(height) // STRIP % every == first)


def _united(blocks: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """Sorted blocks, neighbours joined; a RenderError when two share a pass."""
    out: list[tuple[int, int, int]] = []
    for seed, start, end in sorted(blocks):
        if out and out[-1][0] == seed and start < out[-1][2]:
            raise RenderError("merge", f"pass {start} of seed {seed} is in twice", "use other passes or seeds")
        if out and out[-1][0] == seed and start == out[-1][2]:
            out[-1] = (seed, out[-1][1], end)
        else:
            out.append((seed, start, end))
    return out


def _difference(mine, theirs) -> str:
    """What differs between two values or two dicts of settings, in words."""
    if isinstance(mine, dict) and isinstance(theirs, dict):
        keys = [key for key in {**mine, **theirs} if mine.get(key) != theirs.get(key)]
        return ", ".join(f"{key} {mine.get(key)} and {theirs.get(key)}" for key in keys)
    return f"{mine} and {theirs}"
