"""Flags that several commands share, and their values."""

from __future__ import annotations

import argparse

from .driver.frames import parse_frames
from .film.passes import ALL_NAMES, BY_NAME
from .issues import RenderError
from .settings import FIELDS, Settings, parse_value

LIMITS = ("passes", "seconds", "error")


class UsageError(Exception):
    """The command line is wrong."""


def scene_arguments(command: argparse.ArgumentParser) -> None:
    """Flags that choose what of a file is looked at."""
    command.add_argument("scene", metavar="SCENE", help=".blend, or .npz saved from one")
    command.add_argument("--frame", type=int, metavar="N", help="frame (default: the file's current one)")
    command.add_argument("--camera", metavar="NAME", help="camera object (default: the scene's)")
    command.add_argument("--view-layer", metavar="NAME", help="view layer (default: the file's active one)")
    command.add_argument("--resolution", type=resolution, metavar="WxH", help="in pixels (default: the scene's)")


def settings_argument(command: argparse.ArgumentParser) -> None:
    """--set, with the list of settings below the help."""
    command.epilog, command.formatter_class = settings_help(), argparse.RawDescriptionHelpFormatter
    command.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="any setting, see below")
    command.add_argument("--only", type=output_names, metavar="NAME[,NAME]",
                         help="make these pictures only, e.g. Caustic,Depth: no work for others")  # fmt: skip


def settings_help() -> str:
    """The settings that --set knows."""
    lines = ["settings for --set, with their defaults:"]
    for item in FIELDS.values():
        lines.append(f"  {item.name}={item.default if item.name != 'alpha' else '0.667'}  {item.metadata['text']}")
    return "\n".join(lines)


def resolution(text: str) -> tuple[int, int]:
    """`WxH` as two numbers above 0."""
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT") from None
    if width < 1 or height < 1:
        raise argparse.ArgumentTypeError(f"'{text}' has no pixels: both must be above 0")
    return width, height


def frame_range(text: str) -> list[int]:
    """A range of frames."""
    try:
        return parse_frames(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def output_names(text: str) -> frozenset[str]:
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
