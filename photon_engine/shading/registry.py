"""Which function computes which node, and how values pass from one kind of socket to another.

A node is a pure function ``f(x, props, points) -> {output identifier: value}``:

x : inputs by socket identifier, already converted to the input's kind; None where nothing is linked and the surface
    decides (a normal, a texture vector).
props : the node's settings, and ``props["used"]``, the outputs that somebody reads, ``props["images"]``, the scene's.
points : ShadePoints, or None when the node is computed once because nothing in it varies.

Values: VALUE (n | 1,) f32, VECTOR and RGBA (3, n | 1) f32 (alpha is dropped, as in Cycles), SHADER list[Lobe]. With
components first, a number meets a vector without a new axis, and numpy's inner loops run over the hits. Nodes with a
shader output, and those registered with rows=True, get and give their vectors as rows (n | 1, 3), as recipes want them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..bsdf import recipes
from ..scene.data import Node

f32 = np.float32
LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750], f32)  # Y of linear Rec. 709, as Cycles has it
SCALARS = {"VALUE", "INT", "BOOLEAN"}
TRIPLES = {"VECTOR", "RGBA", "ROTATION"}


class NodeKind(NamedTuple):
    """How to compute a type of node."""

    function: Callable
    varies: Callable[[Node, frozenset], bool]  # whether it looks at the surface, beyond its linked inputs
    needs: Callable[[Node, frozenset], set]  # what of ShadePoints it reads, beyond the basic fields
    rows: bool = False  # vectors as rows (n | 1, 3) in and out


REGISTRY: dict[str, NodeKind] = {}


def node(*types: str, varies=False, needs=None, rows=False):
    """Register a node function for Blender's node types.

    varies, needs : a constant, or a function of (Node, outputs in use);  rows : vectors as rows (n | 1, 3)
    """
    def register(function):
        entry = NodeKind(function, _as_function(varies), _as_function(needs or set()), rows)
        for name in types:
            REGISTRY[name] = entry
        return function

    return register


def _as_function(value):
    """A function of (node, used) from itself or from a constant."""
    return value if callable(value) else lambda node, used: value


def unlinked(name: str):
    """For `varies`: the node looks at the surface when this input is not linked."""
    def check(item: Node, used: frozenset) -> bool:
        socket = item.inputs.get(name)
        return socket is None or (socket.node < 0 and socket.value is None)

    return check


def column(value: np.ndarray) -> np.ndarray:
    """A scalar per row as (n | 1, 1), to multiply rows with."""
    return value[:, None]


def constant(value, kind: str):
    """A socket's plain value as an array of its kind; None stays None."""
    if kind == "SHADER":
        return []
    if value is None:
        return None if kind == "VECTOR" else zero(kind)
    row = np.atleast_1d(np.asarray(value, f32))
    if kind in SCALARS:
        return row[:1] if len(row) == 1 else convert(row[:3, None], "RGBA", kind)
    return (np.full(3, row[0], f32) if len(row) == 1 else row[:3])[:, None]


def zero(kind: str):
    """The value of an output that has none."""
    if kind == "SHADER":
        return []
    return np.zeros(1, f32) if kind in SCALARS else np.zeros((3, 1), f32)


def convert(value, source: str, target: str):
    """A value of one kind of socket as another, as Blender does it implicitly.

    colour -> value: luminance; vector -> value: mean; value -> colour or vector: repeated; colour -> shader: an
    emission of that colour; integer and boolean targets cut off the fraction.
    """
    if value is None or source == target:
        return value
    if target == "SHADER":
        return _as_shader(value, source)
    if source == "SHADER":
        return zero(target)
    if target in SCALARS:
        if source == "RGBA":
            value = LUMINANCE @ value
        elif source in TRIPLES:
            value = (value[0] + value[1] + value[2]) * f32(1.0 / 3.0)
        return value if target == "VALUE" or source in ("INT", "BOOLEAN") else np.trunc(value)
    if source in SCALARS:
        return np.broadcast_to(value, (3, len(value)))
    return value


def _as_shader(value, source: str):
    """A colour linked to a shader input shines with it."""
    color: Any = convert(value, source, "RGBA")
    return recipes.emission(color.T, np.ones(1, f32))
