"""The command line: render, info, extract, merge, report.

Exit codes: 0 done; 1 an unexpected error (a bug); 2 wrong usage; 3 the scene or another input cannot be rendered;
4 the output cannot be written; 130 cancelled, what was rendered is kept. Ended by a signal, 128 and its number for a
shell: 139 when Blender's reader crashes on a damaged file, which is told.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import logging
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from .arguments import UsageError, flag_settings, frame_range, scene_arguments, settings_argument
from .driver import guard
from .driver.checks import check_scene
from .driver.console import Console, ConsoleHandler, interruptible
from .driver.frames import frame_path
from .driver.listener import clock, percent
from .driver.log import evidence, issue_records, run_record, write_json
from .driver.session import Session
from .driver.watch import measured
from .film.accumulate import Film
from .film.darkroom import Darkroom, never
from .film.output import OutputError, check_writable
from .film.passes import ALL_NAMES, BY_NAME, ERROR_MAPS, GUIDES, NOISY, PASSES, in_full_frame, usual_outputs
from .issues import IssueLog, RenderError, StopReason, log
from .report.command import add_arguments as add_report_arguments
from .scene.data import Frame, SceneData
from .settings import Settings

OK, UNEXPECTED, USAGE, BAD_INPUT, BAD_OUTPUT, CANCELLED = 0, 1, 2, 3, 4, 130


class Loaded(NamedTuple):
    """What was asked to be rendered."""

    scene: SceneData
    settings: dict  # stored in the .blend, by name; flags override them
    layer: str  # the view layer's name


def main(argv: list[str] | None = None) -> int:
    """Run a command; returns the exit code. Never raises, never shows a traceback without a message."""
    arguments = parser().parse_args(argv)  # exits with 2 on wrong usage
    console = Console(quiet=getattr(arguments, "quiet", False))
    handler = ConsoleHandler(console)
    log.addHandler(handler)
    log.propagate = False
    log.setLevel(logging.INFO)
    try:
        return arguments.run(arguments, console)
    except UsageError as error:
        return _fail(console, str(error), USAGE)
    except OutputError as error:
        return _fail(console, str(error), BAD_OUTPUT)
    except RenderError as error:
        return _fail(console, str(error), BAD_INPUT)
    except KeyboardInterrupt:
        return _fail(console, "broken off, nothing kept", CANCELLED)
    except MemoryError:
        return _fail(console, "out of memory (fewer photons, a smaller resolution, or smaller textures)", UNEXPECTED)
    except Exception as error:
        notes = "".join(f", {note}" for note in getattr(error, "__notes__", ()))
        traceback.print_exc(file=console.stream)
        text = f"unexpected {type(error).__name__}: {error}{notes} (a bug: please report it)"
        return _fail(console, text, UNEXPECTED)
    finally:
        console.close()
        log.removeHandler(handler)


def _fail(console: Console, text: str, code: int) -> int:
    """Say what went wrong."""
    console.say(f"error: {text}")
    return code


def parser() -> argparse.ArgumentParser:
    """All commands and flags."""
    root = argparse.ArgumentParser(
        prog="photon_engine", description="Photon Map: renders Blender scenes by photon mapping", epilog=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    commands = root.add_subparsers(required=True, metavar="COMMAND")
    render = commands.add_parser("render", help="render a .blend, or a saved scene (.npz)")
    scene_arguments(render)
    settings_argument(render)
    render.add_argument(
        "--frames", type=frame_range, metavar="A-B[:STEP]",
        help="an animation's frames, each into a file of its own: its number goes behind OUT, or where OUT has ####",
    )  # fmt: skip
    render.add_argument("-o", "--output", metavar="OUT.exr", help="multilayer EXR (default: the scene's name, here)")
    render.add_argument("--no-sheet", action="store_true", help="do not write the PNG sheet OUT.png")
    render.add_argument("--passes", metavar="N", help="stop after N passes")
    render.add_argument("--seconds", metavar="S", help="stop after S seconds (both: whichever is first)")
    render.add_argument("--error", metavar="E", help="stop when the error is below this: 0.01 is 1%% of the brightness")
    render.add_argument("--error-pass", metavar="NAME", help="of this pass (default: Combined)")
    render.add_argument("--error-share", metavar="P", help="of this part of the pixels (default: 0.95)")
    render.add_argument("--maps", action="store_true", help="also write the passes Noise and Bias, the errors by pixel")
    render.add_argument("--seed", metavar="K", help="another seed, another noise")
    render.add_argument("--threads", metavar="N", help="worker threads, 0: one for each core")
    render.add_argument("--first", type=int, default=0, metavar="I", help="number of the first pass, to merge later")
    render.add_argument("--log", metavar="RUN.json", help="write what was done, and how fast")
    render.add_argument("--state", metavar="FILE.npz", help="write the film's sums, to go on or merge")
    render.add_argument("--resume", metavar="FILE.npz", help="go on with a film saved by --state")
    render.add_argument("-q", "--quiet", action="store_true", help="no progress")
    render.set_defaults(run=run_render)
    info = commands.add_parser("info", help="what a scene holds, what will run, what is not supported")
    scene_arguments(info)
    settings_argument(info)
    info.add_argument("--json", action="store_true", help="as JSON")
    info.set_defaults(run=run_info)
    extract = commands.add_parser("extract", help="save a .blend's scene, to render it where there is no Blender")
    scene_arguments(extract)
    extract.add_argument("-o", "--output", required=True, metavar="OUT.npz")
    extract.set_defaults(run=run_extract)
    merge = commands.add_parser("merge", help="merge films saved by render --state")
    merge.add_argument("films", nargs="+", metavar="FILE.npz")
    merge.add_argument("-o", "--output", required=True, metavar="OUT", help="OUT.exr, or OUT.npz for another film")
    merge.add_argument("--no-sheet", action="store_true", help="do not write the PNG sheet")
    merge.add_argument("--denoise", action="store_true", help="denoise the picture")
    merge.set_defaults(run=run_merge)
    report = commands.add_parser("report", help="error against seconds, beside Cycles: table, plot and JSON")
    add_report_arguments(report)
    report.set_defaults(run=run_report)
    return root


@contextmanager
def source(arguments: argparse.Namespace, issues: IssueLog) -> Iterator[Callable[..., Loaded]]:
    """What reads the scene of the command line, from a .blend (by bpy) or saved: read(issues, frame).

    issues : is told what the file lacks
    """
    path = Path(arguments.scene)
    if not path.is_file():
        raise RenderError(str(path), "is a folder" if path.is_dir() else "no such file", "check the path")
    if path.suffix.lower() == ".npz":
        yield lambda _issues, frame=None: _load_saved(path, arguments)
        return
    try:
        from .blender import load as blender_load
    except ImportError as error:
        if error.name != "bpy":
            raise
        raise RenderError(
            str(path), "Blender as a module (bpy) is not installed, .blend files cannot be read",
            "pip install bpy, or give a scene saved as .npz",
        ) from None  # fmt: skip
    options = blender_load.Options(arguments.frame, arguments.camera, arguments.view_layer, arguments.resolution)
    with blender_load.OpenBlend(path, options, issues) as opened:

        def read(issues: IssueLog, frame: int | None = None) -> Loaded:
            loaded = Loaded(*opened.read(issues, frame))
            guard.done()
            return loaded

        yield read


def load(arguments: argparse.Namespace, issues: IssueLog) -> Loaded:
    """The one scene of the command line."""
    with source(arguments, issues) as read:
        return read(issues)


def _load_saved(path: Path, arguments: argparse.Namespace) -> Loaded:
    """A scene saved without Blender; what chooses within a .blend has no meaning for it."""
    from .scene.io import load_scene

    for name in ("frame", "frames", "camera", "view_layer", "resolution"):
        if getattr(arguments, name, None) is not None:
            raise UsageError(f"--{name.replace('_', '-')}: a saved scene holds one picture only")
    return Loaded(load_scene(path), {}, "ViewLayer")


class Places(NamedTuple):
    """Where the files of a render go; None: not wanted."""

    output: Path
    sheet: Path | None
    state: Path | None
    log: Path | None

    def of_frame(self, frame: int) -> Places:
        """Those of one frame of several."""
        return Places(*(frame_path(path, frame) if path else None for path in self))


def run_render(arguments: argparse.Namespace, console: Console) -> int:
    """`render`: scene -> EXR, sheet, state, log; of each frame in turn."""
    flags = flag_settings(arguments)
    output = Path(arguments.output or f"{Path(arguments.scene).stem}.exr")
    if output.suffix.lower() != ".exr":
        raise UsageError(f"-o {output}: pictures are written as multilayer EXR, use the ending .exr")
    if arguments.frames and (arguments.resume or arguments.frame is not None):
        raise UsageError("--frames: neither --resume nor --frame goes with it, both are of one picture")
    sheet = None if arguments.no_sheet else output.with_suffix(".png")
    state, record = (Path(path) if path else None for path in (arguments.state, arguments.log))
    places = Places(output, sheet, state, record)
    jobs = [(frame, places.of_frame(frame)) for frame in arguments.frames or []] or [(None, places)]
    for path in (path for _, job in jobs for path in job if path):
        check_writable(path)
    kept, code, missing = None, OK, IssueLog()
    with source(arguments, missing) as read:
        for frame, job in jobs:
            issues = IssueLog()
            issues.extend(missing)
            begin = time.perf_counter()
            loaded = read(issues, frame)
            session = _session(loaded, flags, issues, arguments, kept)
            session.stages["Reading the scene"] = time.perf_counter() - begin
            code = _render_one(session, loaded, job, arguments, console)
            if code != OK:
                break
            kept = session.kept
    return code


def _session(loaded: Loaded, flags: dict, issues: IssueLog, arguments: argparse.Namespace, kept: Any) -> Session:
    """A session for one picture; a film that is saved holds the guides, so that it can be denoised when merged."""
    settings = Settings(**{**loaded.settings, **flags})
    outputs = arguments.only or usual_outputs(settings.denoise)
    outputs |= ERROR_MAPS if arguments.maps else frozenset()
    outputs |= GUIDES if arguments.state or arguments.resume else frozenset()
    return Session(loaded.scene, settings, issues, outputs=outputs, kept=kept)


def _render_one(
    session: Session, loaded: Loaded, places: Places, arguments: argparse.Namespace, console: Console
) -> int:
    """Render one picture and write its files; the exit code."""
    film = Film.load(arguments.resume) if arguments.resume else None
    if film:
        film.seed = session.settings.seed
    with interruptible(console):
        try:
            stop = session.render(console, film, arguments.first)
        finally:  # after an error too: what was rendered is kept
            _save(session, loaded, places, arguments.only or frozenset())
    if not session.film.count:
        raise KeyboardInterrupt
    error, share = session.watch.error, session.settings.error_share
    within = f", {share:.0%} of pixels within {percent(error)}" if error is not None else ""
    spent = clock(session.film.meta["seconds"])
    console.say(f"{places.output}: {session.film.count} passes in {spent}{within}, {stop.value}")
    return CANCELLED if stop is StopReason.CANCELLED else OK


def _save(session: Session, loaded: Loaded, places: Places, asked: frozenset[str]) -> None:
    """Write all that was asked for, when there is a picture."""
    film = session.film
    if film and film.count:
        film.meta |= {"frame": dataclasses.asdict(loaded.scene.frame), "layer": loaded.layer}
        film.meta |= evidence(session)
        begin = time.perf_counter()
        if places.state:
            film.save(places.state)
        session.darkroom.cancelled = never  # Ctrl-C ends the passes; the picture is finished
        _write_pictures(session.darkroom, places.output, places.sheet, asked)
        session.stages["Denoising"] = session.darkroom.seconds
        session.stages["Writing"] = time.perf_counter() - begin - session.darkroom.seconds
    if places.log and film:
        write_json(places.log, run_record(session))


def _write_pictures(
    darkroom: Darkroom, output: Path, sheet: Path | None, asked: frozenset[str] = frozenset()
) -> None:
    """EXR and sheet of a film whose meta holds frame and layer; denoised, with the noisy pictures beside.

    asked : names that were asked for one by one: they are written even if they are not usual
    """
    from .film.exr import write_exr, write_sheet

    film = darkroom.film
    frame = Frame(**film.meta["frame"])
    wanted = frozenset(film.meta.get("outputs", ALL_NAMES))
    if darkroom.denoise != "OFF":
        wanted |= {NOISY + name for name in wanted}
    beside = asked | (ERROR_MAPS if darkroom.denoise == "OFF" else frozenset(BY_NAME))
    names = [item.name for item in PASSES if item.name in wanted and (item.usual or item.name in beside)]
    pictures = {name: in_full_frame(picture, frame) for name, picture in darkroom.pictures(names).items()}
    meta = {name: film.meta[name] for name in ("scene", "settings", "seconds")}
    meta |= {name: film.meta[name] for name in ("stop", "radii", "error_curve", "machine") if name in film.meta}
    meta |= {"passes": film.count, "seed": film.seed, "blocks": film.blocks}
    if darkroom.version:
        meta["denoiser"] = f"Open Image Denoise {darkroom.version}"
    write_exr(output, pictures, film.meta["layer"], meta)
    if sheet:
        write_sheet(sheet, pictures)


def run_merge(arguments: argparse.Namespace, console: Console) -> int:
    """`merge`: several films -> one film or picture."""
    output = Path(arguments.output)
    if output.suffix.lower() not in (".exr", ".npz"):
        raise UsageError(f"-o {output}: use the ending .exr or .npz")
    check_writable(output)
    film = Film.load(arguments.films[0])
    for path in arguments.films[1:]:
        film.merge(Film.load(path))
    film.meta |= {"error_curve": [measured(film, film.meta.get("seconds", 0.0)).record()], "stop": "merged"}
    if output.suffix.lower() == ".npz":
        film.save(output)
    else:
        darkroom = Darkroom(film, "FINAL" if arguments.denoise else "OFF", 0, IssueLog())
        _write_pictures(darkroom, output, None if arguments.no_sheet else output.with_suffix(".png"))
    console.say(f"{output}: {film.count} passes of {len(arguments.films)} films")
    return OK


def run_extract(arguments: argparse.Namespace, console: Console) -> int:
    """`extract`: .blend -> saved scene. Settings stored in the .blend are not part of a scene."""
    from .scene.io import save_scene

    output = Path(arguments.output)
    if output.suffix.lower() != ".npz":
        raise UsageError(f"-o {output}: use the ending .npz")
    check_writable(output)
    loaded = load(arguments, IssueLog())
    save_scene(loaded.scene, output)
    console.say(f"{output}: {len(loaded.scene.instances)} objects, {len(loaded.scene.lights)} lights")
    return OK


def run_info(arguments: argparse.Namespace, console: Console) -> int:
    """`info`: what the scene holds, what will run, what is not supported."""
    flags = flag_settings(arguments)
    issues = IssueLog()
    log.setLevel(logging.CRITICAL)  # issues are part of the report
    loaded = load(arguments, issues)
    settings = Settings(**{**loaded.settings, **flags})
    from .driver.summary import summarize, summary_text

    check_scene(loaded.scene, issues)
    record = summarize(loaded.scene, settings, issues, arguments.only or usual_outputs(settings.denoise))
    text = json.dumps(record | {"issues": issue_records(issues)}, indent=2) if arguments.json else None
    sys.stdout.write((text or summary_text(record, issues)) + "\n")
    return OK


def run_report(arguments: argparse.Namespace, console: Console) -> int:
    """`report`: scenes -> table, plots, JSON."""
    from .report.command import run

    run(arguments, console.say)
    return OK
