"""The command line: render, info, extract, merge, report.

Exit codes: 0 done; 1 an unexpected error (a bug); 2 wrong usage; 3 the scene or another input cannot be rendered;
4 the output cannot be written; 130 cancelled, what was rendered is kept.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import logging
import sys
import time
import traceback
from pathlib import Path
from typing import NamedTuple

from .driver.checks import check_scene
from .driver.console import Console, ConsoleHandler, interruptible
from .driver.listener import clock, percent
from .driver.log import evidence, issue_records, run_record, write_json
from .driver.session import Session
from .driver.watch import measured
from .film.accumulate import Film
from .film.darkroom import Darkroom, never
from .film.output import OutputError, check_writable
from .film.passes import ALL_NAMES, BY_NAME, ERROR_MAPS, PASSES, in_full_frame
from .issues import IssueLog, RenderError, StopReason, log
from .report.command import add_arguments as add_report_arguments
from .scene.data import Frame, SceneData
from .settings import FIELDS, Settings, parse_value

LIMITS = ("passes", "seconds", "error")
OK, UNEXPECTED, USAGE, BAD_INPUT, BAD_OUTPUT, CANCELLED = 0, 1, 2, 3, 4, 130


class UsageError(Exception):
    """The command line is wrong."""


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
    _scene_arguments(render)
    _settings_argument(render)
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
    _scene_arguments(info)
    _settings_argument(info)
    info.add_argument("--json", action="store_true", help="as JSON")
    info.set_defaults(run=run_info)
    extract = commands.add_parser("extract", help="save a .blend's scene, to render it where there is no Blender")
    _scene_arguments(extract)
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


def _scene_arguments(command: argparse.ArgumentParser) -> None:
    """Flags that choose what of a file is looked at."""
    command.add_argument("scene", metavar="SCENE", help=".blend, or .npz saved from one")
    command.add_argument("--frame", type=int, metavar="N", help="frame (default: the file's current one)")
    command.add_argument("--camera", metavar="NAME", help="camera object (default: the scene's)")
    command.add_argument("--view-layer", metavar="NAME", help="view layer (default: the file's active one)")
    command.add_argument("--resolution", type=_resolution, metavar="WxH", help="in pixels (default: the scene's)")


def _settings_argument(command: argparse.ArgumentParser) -> None:
    """--set, with the list of settings below the help."""
    command.epilog, command.formatter_class = settings_help(), argparse.RawDescriptionHelpFormatter
    command.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="any setting, see below")
    command.add_argument("--only", type=_outputs, default=ALL_NAMES, metavar="NAME[,NAME]",
                         help="make these pictures only, e.g. Caustic,Depth: no work for others")  # fmt: skip


def settings_help() -> str:
    """The settings that --set knows."""
    lines = ["settings for --set, with their defaults:"]
    for item in FIELDS.values():
        lines.append(f"  {item.name}={item.default if item.name != 'alpha' else '0.667'}  {item.metadata['text']}")
    return "\n".join(lines)


def _resolution(text: str) -> tuple[int, int]:
    """`WxH` as two numbers above 0."""
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT") from None
    if width < 1 or height < 1:
        raise argparse.ArgumentTypeError(f"'{text}' has no pixels: both must be above 0")
    return width, height


def _outputs(text: str) -> frozenset[str]:
    """Names of pictures, separated by commas."""
    wanted = frozenset(name.strip().title() for name in text.split(","))
    if wrong := sorted(wanted - ALL_NAMES):
        raise argparse.ArgumentTypeError(f"there is no picture {', '.join(wrong)}: one of {', '.join(BY_NAME)}")
    return wanted


def flag_settings(arguments: argparse.Namespace) -> dict:
    """Settings given as flags: name -> value; a UsageError names the wrong one.

    One of --passes, --seconds and --error lifts the others' limits that a file may hold.
    """
    texts = {}
    for pair in arguments.set:
        name, equals, value = pair.partition("=")
        if not equals:
            raise UsageError(f"--set {pair}: there is no '=' (write --set NAME=VALUE)")
        texts[name.strip()] = value.strip()
    for name in ("passes", "seconds", "error", "error_pass", "error_share", "seed", "threads"):
        if getattr(arguments, name, None) is not None:
            texts[name] = getattr(arguments, name)
    if any(name in texts for name in LIMITS):
        texts = dict.fromkeys(LIMITS, "0") | texts
    try:
        values = {name: parse_value(name, text) for name, text in texts.items()}
        Settings(**values)
    except RenderError as error:
        raise UsageError(str(error)) from None
    return values


def load(arguments: argparse.Namespace, issues: IssueLog) -> Loaded:
    """The scene of the command line, from a .blend (by bpy) or saved."""
    path = Path(arguments.scene)
    if not path.is_file():
        raise RenderError(str(path), "is a folder" if path.is_dir() else "no such file", "check the path")
    if path.suffix.lower() == ".npz":
        return _load_saved(path, arguments)
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
    return Loaded(*blender_load.load_blend(path, options, issues))


def _load_saved(path: Path, arguments: argparse.Namespace) -> Loaded:
    """A scene saved without Blender; what chooses within a .blend has no meaning for it."""
    from .scene.io import load_scene

    for name in ("frame", "camera", "view_layer", "resolution"):
        if getattr(arguments, name) is not None:
            raise UsageError(f"--{name.replace('_', '-')}: a saved scene holds one picture only")
    return Loaded(load_scene(path), {}, "ViewLayer")


def run_render(arguments: argparse.Namespace, console: Console) -> int:
    """`render`: scene -> EXR, sheet, state, log."""
    flags = flag_settings(arguments)
    output = Path(arguments.output or f"{Path(arguments.scene).stem}.exr")
    if output.suffix.lower() != ".exr":
        raise UsageError(f"-o {output}: pictures are written as multilayer EXR, use the ending .exr")
    sheet = None if arguments.no_sheet else output.with_suffix(".png")
    for path in (output, sheet, arguments.state, arguments.log):
        if path:
            check_writable(path)
    issues = IssueLog()
    film = Film.load(arguments.resume) if arguments.resume else None
    begin = time.perf_counter()
    loaded = load(arguments, issues)
    reading = time.perf_counter() - begin
    settings = Settings(**{**loaded.settings, **flags})
    if film:
        film.seed = settings.seed
    outputs = arguments.only | ERROR_MAPS if arguments.maps else arguments.only
    session = Session(loaded.scene, settings, issues, outputs=outputs)
    session.stages["Reading the scene"] = reading
    with interruptible(console):
        try:
            stop = session.render(console, film, arguments.first)
        finally:  # after an error too: what was rendered is kept
            _save(session, loaded, output, sheet, arguments)
    if not session.film.count:
        raise KeyboardInterrupt
    error = session.watch.error
    within = f", {settings.error_share:.0%} of pixels within {percent(error)}" if error is not None else ""
    console.say(f"{output}: {session.film.count} passes in {clock(session.film.meta['seconds'])}{within}, {stop.value}")
    return CANCELLED if stop is StopReason.CANCELLED else OK


def _save(session: Session, loaded: Loaded, output: Path, sheet: Path | None, arguments: argparse.Namespace) -> None:
    """Write all that was asked for, when there is a picture."""
    film = session.film
    if film and film.count:
        film.meta |= {"frame": dataclasses.asdict(loaded.scene.frame), "layer": loaded.layer}
        film.meta |= evidence(session)
        begin = time.perf_counter()
        if arguments.state:
            film.save(arguments.state)
        session.darkroom.cancelled = never  # Ctrl-C ends the passes; the picture is finished
        _write_pictures(session.darkroom, output, sheet)
        session.stages["Denoising"] = session.darkroom.seconds
        session.stages["Writing"] = time.perf_counter() - begin - session.darkroom.seconds
    if arguments.log and film:
        write_json(arguments.log, run_record(session))


def _write_pictures(darkroom: Darkroom, output: Path, sheet: Path | None) -> None:
    """EXR and sheet of a film whose meta holds frame and layer; denoised, with the noisy pictures beside."""
    from .film.exr import write_exr, write_sheet

    film = darkroom.film
    frame = Frame(**film.meta["frame"])
    wanted = film.meta.get("outputs", ALL_NAMES)
    usual = ERROR_MAPS if darkroom.denoise == "OFF" else frozenset(BY_NAME)
    names = [item.name for item in PASSES if item.name in wanted and (item.usual or item.name in usual)]
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
    record = summarize(loaded.scene, settings, issues, arguments.only)
    text = json.dumps(record | {"issues": issue_records(issues)}, indent=2) if arguments.json else None
    sys.stdout.write((text or summary_text(record, issues)) + "\n")
    return OK


def run_report(arguments: argparse.Namespace, console: Console) -> int:
    """`report`: scenes -> table, plots, JSON."""
    from .report.command import run

    run(arguments, console.say)
    return OK
