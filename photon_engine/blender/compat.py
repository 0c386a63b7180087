"""Differences between Blender 4.5 and 5.x, all in one place."""

from __future__ import annotations

from typing import Any

import bpy

# since 5.0 every world and material has nodes and ``use_nodes`` is a deprecated constant
ALWAYS_NODES = bpy.app.version >= (5, 0, 0)


def node_tree_of(block: Any) -> Any | None:
    """The node tree that a world, material or light really shades with, or None."""
    tree = getattr(block, "node_tree", None)
    if tree is None:
        return None
    if ALWAYS_NODES and not isinstance(block, bpy.types.Light):
        return tree
    return tree if block.use_nodes else None
