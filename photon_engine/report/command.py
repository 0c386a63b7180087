"""`python -m photon_engine report`: error against seconds of scenes, as a table, a plot and JSON."""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..driver.log import machine, write_json
from ..film.output import OutputError
from ..issues import RenderError
from .metrics import Errors, errors, noise_figure
from .plot import by_line, load_matplotlib, plot
from .reference import Known, References, choose
from .runs import CYCLES, CYCLES_DENOISED, OURS, OURS_DENOISED, Run, Task, cycles, ours
from .speed import compare, medians

Say = Callable[[str], None]
SECONDS = (2.0, 4.0, 8.0, 16.0, 32.0)
SIZE = (256, 256)
LONGER = 8.0  # times the longest run: the reference that is made where none is given
REFERENCE_SETTINGS = ("caustic_radius=1", "diffuse_radius=1.5", "light_samples=8", "seed=1000")


def add_arguments(command: argparse.ArgumentParser) -> None:
    """The flags of the command."""
    command.add_argument("scenes", nargs="+", metavar="SCENE.blend")
    command.add_argument("--against", choices=["cycles"], help="render with Cycles too, as is and denoised")
    command.add_argument("--seconds", type=_seconds, default=SECONDS, metavar="S,S,...", help="default: 2,4,8,16,32")
    command.add_argument("--reference", action="append", default=[], metavar="REF.exr",
                         help="may be repeated: of Combined, Direct, Caustic, ... the first file that holds it counts; "
                              "default: a long run of our own, which cannot show faults of ours")  # fmt: skip
    command.add_argument("--resolution", type=_resolution, metavar="WxH", help="default: the reference's, or 256x256")
    command.add_argument("--threads", type=int, default=os.cpu_count() or 1, metavar="N", help="of every engine")
    command.add_argument("--repeat", type=int, default=1, metavar="N", help="runs of each, whose medians are told")
    command.add_argument("--denoise", action="store_true", help="render denoised pictures of ours too")
    command.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a setting of ours")
    command.add_argument("-o", "--output", default="report", metavar="FOLDER", help="default: report")


def _seconds(text: str) -> tuple[float, ...]:
    """`2,4,8` as numbers above 0."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of seconds like 2,4,8") from None
    if not all(value > 0.0 for value in values):
        raise argparse.ArgumentTypeError(f"'{text}': seconds must be above 0")
    return values


def _resolution(text: str) -> tuple[int, int]:
    """`WxH` as two numbers above 0."""
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT") from None
    if min(width, height) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' has no pixels")
    return width, height


def run(arguments: argparse.Namespace, say: Say) -> None:
    """Report on every scene; raises RenderError or OutputError."""
    load_matplotlib()  # better missing before the renders than after them
    folder = Path(arguments.output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(str(folder), f"cannot be made: {error.strerror}", "choose another place") from None
    for scene in arguments.scenes:
        if not Path(scene).is_file():
            raise RenderError(scene, "no such file", "check the path")
    if arguments.reference and len(arguments.scenes) > 1:
        raise RenderError("--reference", "is of one scene, there are several", "report on one scene at a time")
    for scene in arguments.scenes:
        report(Path(scene).resolve(), arguments, folder, say)


def report(blend: Path, arguments: argparse.Namespace, folder: Path, say: Say) -> dict[str, Any]:
    """All renders of one scene, paired in time; writes NAME.json, .png and .svg and says the table."""
    known = choose(arguments.reference) if arguments.reference else None
    size = arguments.resolution or (known.size if known else SIZE)
    task = Task(blend, size, arguments.threads, tuple(arguments.set))
    runs: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary)
        if known is None:
            say(f"{blend.stem}: reference ...")
            known = long_run(task, LONGER * max(arguments.seconds), place)
        say(f"{blend.stem}: held against {known.told()}")
        for seconds in arguments.seconds:
            for seed in range(max(arguments.repeat, 1)):
                for engine, render in engines(arguments):
                    say(f"{blend.stem}: {engine}, {seconds:g} s ...")
                    runs += judge(engine, seconds, render(task._replace(seed=seed), seconds, place), known.pictures)
    points = medians(runs)
    told = compare(points) if arguments.against else []
    record = {
        "scene": blend.name, "resolution": list(size), "threads": arguments.threads, "reference": known.sources,
        "reference_relMSE": {name: noise_figure(each) for name, each in known.pictures.items() if each.se is not None},
        "settings": list(arguments.set), "machine": machine(), "points": points, "runs": runs,
        "against": [item._asdict() for item in told],
    }  # fmt: skip
    write_json(folder / f"{blend.stem}.json", record)
    title = f"{blend.stem}, {size[0]} x {size[1]}, {arguments.threads} threads"
    paths = plot(points, title, f"held against {known.told()}", folder / blend.stem)
    say(table(points))
    for item in told:
        say(str(item))
    say(", ".join(str(path) for path in (folder / f"{blend.stem}.json", *paths)))
    return record


def long_run(task: Task, seconds: float, place: Path) -> References:
    """A reference of our own: all light passes."""
    pictures = ours(task._replace(settings=(*task.settings, *REFERENCE_SETTINGS)), seconds, False, place).pictures
    source = f"ours, {seconds:g} s with {' '.join(REFERENCE_SETTINGS)}"
    return References({name: Known(picture) for name, picture in pictures.items()}, dict.fromkeys(pictures, source))


def engines(arguments: argparse.Namespace) -> list[tuple[str, Callable[[Task, float, Path], Run]]]:
    """Who renders, in the order of their turns."""
    found = [(OURS, lambda task, seconds, place: ours(task, seconds, False, place))]
    if arguments.denoise or arguments.against:
        found.append((OURS_DENOISED, lambda task, seconds, place: ours(task, seconds, True, place)))
    if arguments.against:
        found.append((CYCLES, lambda task, seconds, place: cycles(task, seconds, False, place)))
        found.append((CYCLES_DENOISED, lambda task, seconds, place: cycles(task, seconds, True, place)))
    return found


def judge(engine: str, asked: float, result: Run, known: dict[str, Known]) -> list[dict[str, Any]]:
    """The errors of a run's pictures, as one record each; components only of raw pictures of ours.

    A component that is black in the reference is one that the scene does not have, and is left out.
    """
    parts = [name for name in result.pictures if name in known and (name == "Combined" or engine == OURS)]
    shared = {"engine": engine, "asked_seconds": asked, "seconds": result.seconds, "cpu_seconds": result.cpu,
              "setup_seconds": result.setup}  # fmt: skip
    found = {
        name: errors(result.pictures[name], known[name])
        for name in parts
        if name == "Combined" or known[name].mean.any()
    }
    return [{**shared, "part": name, **figures._asdict(), "detail": result.detail} for name, figures in found.items()]


def table(points: list[dict[str, Any]]) -> str:
    """The figures in columns, a block of rows for each line of the plot: engines first, then components of ours."""
    head = f"{'engine':<22}{'picture':<13}{'seconds':>8}{'cpu':>8}"
    lines = [head + "".join(f"{name:>11}" for name in Errors._fields)]
    for (engine, part), line in by_line(points).items():
        for index, point in enumerate(line):
            names = f"{engine:<22}{part:<13}" if index == 0 else " " * 35
            figures = "".join(f"{point[name]:>11.4g}" for name in Errors._fields)
            lines.append(f"{names}{point['seconds']:>8.2f}{point['cpu_seconds']:>8.2f}{figures}")
    return "\n".join(lines)
