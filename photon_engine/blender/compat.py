"""Differences between Blender 4.5 and 5.x, all in one place."""

from __future__ import annotations

from typing import Any

import bpy

# since 5.0 every world and material has nodes, and their ``use_nodes`` is a deprecated constant
ALWAYS_NODES = bpy.app.version >= (5, 0, 0)

# since 5.0 groups, reroutes and muted nodes vanish before Cycles sees a tree, so their sockets convert nothing
INLINED_TREES = ALWAYS_NODES
# since 5.0 Cycles shades an empty material slot as a Principled BSDF with its default values, before as grey Lambert
DEFAULT_PRINCIPLED = ALWAYS_NODES
# since 5.0 Cycles multiplies an image by its alpha as the image's mode says, before as its file format stores it
ALPHA_BY_MODE = ALWAYS_NODES

# before 5.0 the cubic through a photometric file saw nothing beyond the first and the last angle
IES_DARK_BEYOND = not ALWAYS_NODES

# since 5.0 Voronoi cells are hashed as integers by PCG, before as floats by Jenkins' hash
VORONOI_WORD_HASH = ALWAYS_NODES

# before 5.0 there was one random walk: today's legacy one
SUBSURFACE_NAMES = {} if ALWAYS_NODES else {"RANDOM_WALK": "RANDOM_WALK_LEGACY"}

# nodes of zones, closures, bundles, menus and constants, which Blender itself resolves (since 5.0)
RESOLVED_NODES = {
    "FunctionNodeInputBool", "FunctionNodeInputInt", "FunctionNodeInputMenu", "FunctionNodeInputVector",
    "GeometryNodeMenuSwitch", "GeometryNodeRepeatInput", "GeometryNodeRepeatOutput", "NodeClosureInput",
    "NodeClosureOutput", "NodeCombineBundle", "NodeEvaluateClosure", "NodeImplicitConversion", "NodeJoinBundle",
    "NodeSeparateBundle",
}  # fmt: skip


def resolved(block: Any) -> Any:
    """What holds, as ``node_tree``, the tree of a material, world or light as Cycles sees it; to be kept while read.

    Repeat zones are unrolled, closures and bundles put in place by Blender where a tree has any; else the block itself.
    """
    if ALWAYS_NODES and hasattr(block, "inline_shader_nodes") and _has_resolved(block.node_tree, set()):
        return block.inline_shader_nodes()
    return block


def _has_resolved(tree: Any, seen: set[str]) -> bool:
    """Whether a tree, or a group in it, has a node that Blender resolves."""
    for node in tree.nodes:
        if node.bl_idname in RESOLVED_NODES:
            return True
        inner = getattr(node, "node_tree", None)
        if inner is not None and inner.name_full not in seen:
            seen.add(inner.name_full)
            if _has_resolved(inner, seen):
                return True
    return False


def uses_nodes(block: Any) -> bool:
    """Whether a material, world or light shades with its node tree."""
    if block.node_tree is None:
        return False
    return block.use_nodes if isinstance(block, bpy.types.Light) or not ALWAYS_NODES else True
