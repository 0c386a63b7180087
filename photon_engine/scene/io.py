"""A scene in one file: an .npz archive of plain arrays and one JSON tree that refers to them. No pickle."""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..issues import RenderError
from . import data
from .archive import KINDS, Archive, BadArchive
from .typed import WrongType, check_record
from .validate import check_scene

FORMAT = "photon-map-scene"
VERSION = 1
TREE = "tree"  # the archive's member that holds the JSON text as bytes

RECORDS = {
    item.__name__: item
    for item in (
        data.Mesh, data.Instance, data.Socket, data.Node, data.Graph, data.Material, data.Image, data.Light, data.World,
        data.Camera, data.Frame, data.SceneData,
    )
}  # fmt: skip


def save_scene(scene: data.SceneData, path: str | os.PathLike) -> None:
    """Write the scene; ``load_scene`` gives back an equal one. An existing file is replaced when all is written."""
    arrays: dict[str, np.ndarray] = {}
    tree = {"format": FORMAT, "version": VERSION, "scene": _encode(scene, arrays)}
    arrays[TREE] = np.frombuffer(json.dumps(tree).encode(), np.uint8)
    target = Path(path)
    partial = target.with_name(target.name + ".part")
    try:
        with partial.open("wb") as file:
            np.savez(file, **arrays)
        partial.replace(target)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise RenderError(str(path), f"cannot be written: {error.strerror}", "check the folder") from error


def load_scene(path: str | os.PathLike) -> data.SceneData:
    """Read a scene file; a RenderError says what is wrong with a missing, foreign, broken or inconsistent one.

    Nothing of the file is believed: sizes are checked before memory is taken, types and indices before a kernel, which
    does not look, reads them.
    """
    try:
        with Archive(path) as archive:
            arrays = {name: archive.read(name) for name in archive.headers}
        scene = _decode_tree(arrays)
        check_record(scene, "scene")
        check_scene(scene)
    except FileNotFoundError:
        raise RenderError(str(path), "there is no such file", "check the path") from None
    except BadArchive as error:
        raise RenderError(str(path), f"is not a scene file, or is damaged: {error}", "save the scene again") from error
    except (_BadFile, WrongType) as error:
        where = f" in '{error.name}'" if isinstance(error, WrongType) and error.name else ""
        raise RenderError(str(path), f"is damaged{where}: {error}", "save the scene again") from error
    except OSError as error:
        raise RenderError(str(path), f"cannot be read: {error.strerror}", "check the file") from error
    return scene


class _BadFile(Exception):
    """Something in a scene file is not what this version writes."""


def _encode(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """JSON for a value; arrays go to ``arrays``."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, (np.ndarray, np.generic)):
        return _encode_array(value, arrays)
    if isinstance(value, list):
        return [_encode(item, arrays) for item in value]
    if isinstance(value, (tuple, set, frozenset)):
        items = sorted(value) if not isinstance(value, tuple) else value
        return {"$": type(value).__name__, "items": [_encode(item, arrays) for item in items]}
    if isinstance(value, dict):
        return {"$": "dict", "items": [[_encode(k, arrays), _encode(v, arrays)] for k, v in value.items()]}
    name = type(value).__name__
    if RECORDS.get(name) is type(value):
        return {"$": name} | {f.name: _encode(getattr(value, f.name), arrays) for f in dataclasses.fields(value)}
    raise TypeError(f"a scene cannot hold a {type(value).__qualname__}")


def _encode_array(value: np.ndarray | np.generic, arrays: dict[str, np.ndarray]) -> dict[str, str]:
    """A reference to an array or numpy scalar."""
    array = np.asarray(value)
    if array.dtype.kind not in KINDS:
        raise TypeError(f"a scene cannot hold an array of {array.dtype}")
    name = f"a{len(arrays)}"
    arrays[name] = array
    return {"$": "array" if isinstance(value, np.ndarray) else "scalar", "name": name}


def _decode_tree(arrays: dict[str, np.ndarray]) -> data.SceneData:
    """The scene from the archive's members."""
    if TREE not in arrays:
        raise _BadFile("it is not a scene of this program")
    try:
        tree = json.loads(arrays[TREE].tobytes())
    except (ValueError, RecursionError) as error:
        raise _BadFile("its description is no JSON") from error
    if not isinstance(tree, dict) or tree.get("format") != FORMAT:
        raise _BadFile("it is not a scene of this program")
    if tree.get("version") != VERSION:
        raise _BadFile(f"it has format version {tree.get('version')}, this program reads {VERSION}")
    try:
        scene = _decode(tree.get("scene"), arrays)
    except RecursionError as error:
        raise _BadFile("its description is nested too deeply") from error
    if not isinstance(scene, data.SceneData):
        raise _BadFile("it holds no scene")
    return scene


SEQUENCES = {"tuple": tuple, "set": set, "frozenset": frozenset}


def _decode(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """The value behind its JSON."""
    if isinstance(value, list):
        return [_decode(item, arrays) for item in value]
    if not isinstance(value, dict):
        return value
    kind = value.get("$")
    if not isinstance(kind, str):
        raise _BadFile(f"'{kind}' is no known record")
    if kind in ("array", "scalar"):
        name = value.get("name")
        if not isinstance(name, str) or name not in arrays:
            raise _BadFile(f"array '{name}' is missing")
        if kind == "scalar" and arrays[name].ndim:
            raise _BadFile(f"array '{name}' is no single number")
        return arrays[name] if kind == "array" else arrays[name][()]
    if kind in RECORDS:
        return _decode_record(RECORDS[kind], value, arrays)
    items = value.get("items")
    if not isinstance(items, list):
        raise _BadFile(f"'{kind}' is no known record")
    try:
        if kind == "dict":
            return {_decode(k, arrays): _decode(v, arrays) for k, v in items}
        if kind in SEQUENCES:
            return SEQUENCES[kind](_decode(item, arrays) for item in items)
    except (TypeError, ValueError) as error:
        raise _BadFile(f"a {kind} in it is malformed") from error
    raise _BadFile(f"'{kind}' is no known record")


def _decode_record(record: type, value: dict[str, Any], arrays: dict[str, np.ndarray]) -> Any:
    """One dataclass; every field must be there and none besides."""
    names = {f.name for f in dataclasses.fields(record)}
    given = set(value) - {"$"}
    if names != given:
        odd = ", ".join(sorted(names ^ given))
        raise _BadFile(f"a {record.__name__} in it lacks or has unknown fields: {odd}")
    return record(**{name: _decode(value[name], arrays) for name in names})
