"""Whether records hold values of the types that their dataclasses declare, and numbers that are finite.

A file can hold anything, and Python would carry it as far as a kernel.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from functools import cache
from typing import Any

import numpy as np

MOST = float(np.finfo(np.float32).max)  # kernels hold numbers in single precision
NUMBERS = {int: (int, np.integer), float: (int, float, np.integer, np.floating), bool: (bool, np.bool_),
           str: (str,)}  # fmt: skip


class WrongType(Exception):
    """A value is not of its declared type; says of what record and which."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        super().__init__(text)


@cache
def hints(record: type) -> dict[str, Any]:
    """Declared types of a dataclass's fields."""
    return typing.get_type_hints(record)


def check_record(record: Any, name: str = "") -> None:
    """Raise a WrongType naming the first field, at any depth, that is not what its dataclass declares.

    Numbers must be finite in single precision, but those in arrays, which are looked at where their shapes are.
    """
    own = getattr(record, "name", None)
    name = own if isinstance(own, str) and own else name
    for label, hint in hints(type(record)).items():
        value = getattr(record, label)
        if not conforms(value, hint, name):
            found = "a number that is not finite" if is_number(value) else f"a {type(value).__name__}"
            raise WrongType(name, f"'{label}' holds {found}, or something that is not what is declared")


def conforms(value: Any, hint: Any, name: str = "") -> bool:
    """Whether a value is of a type; records in it are checked in turn."""
    if hint is Any:
        return is_plain(value)
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return any(value is None if item is type(None) else conforms(value, item, name) for item in arguments)
    if origin is list:
        return isinstance(value, list) and all(conforms(item, arguments[0], name) for item in value)
    if origin is dict:
        return isinstance(value, dict) and all(
            conforms(k, arguments[0], name) and conforms(v, arguments[1], name) for k, v in value.items()
        )
    if origin is tuple:
        if not isinstance(value, tuple):
            return False
        kinds = arguments[:1] * len(value) if arguments[-1] is Ellipsis else arguments
        return len(kinds) == len(value) and all(
            conforms(item, kind, name) for item, kind in zip(value, kinds, strict=True)
        )
    if hint in NUMBERS:
        good = isinstance(value, NUMBERS[hint]) and (hint is bool) == isinstance(value, bool | np.bool_)
        return good and (hint in (str, bool) or is_finite(value))
    if not isinstance(value, hint):
        return False
    if dataclasses.is_dataclass(value):
        check_record(value, name)
    return True


def is_plain(value: Any) -> bool:
    """What a node may hold: text, switches, finite numbers, arrays, and lists, tuples and dicts of these."""
    if isinstance(value, dict):
        return all(is_plain(item) for pair in value.items() for item in pair)
    if isinstance(value, list | tuple | set | frozenset):
        return all(is_plain(item) for item in value)
    if isinstance(value, np.ndarray):
        return value.dtype.kind not in "fc" or bool(np.isfinite(value).all())
    return value is None or isinstance(value, str | bool | np.bool_) or (is_number(value) and is_finite(value))


def is_number(value: Any) -> bool:
    """Whether it is an integer or a real number."""
    return isinstance(value, NUMBERS[float]) and not isinstance(value, bool)


def is_finite(value: Any) -> bool:
    """Whether single precision holds a number; also of an integer beyond what a float can be made of."""
    return -MOST <= value <= MOST
