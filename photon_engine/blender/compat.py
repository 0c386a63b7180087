"""Differences between Blender 4.5 and 5.x, all in one place."""

from __future__ import annotations

from typing import Any

import bpy

# since 5.0 every world and material has nodes, and their ``use_nodes`` is a deprecated constant
ALWAYS_NODES = bpy.app.version >= (5, 0, 0)


def uses_nodes(block: Any) -> bool:
    """Whether a material, world or light shades with its node tree."""
    if block.node_tree is None:
        return False
    return block.use_nodes if isinstance(block, bpy.types.Light) or not ALWAYS_NODES else True
