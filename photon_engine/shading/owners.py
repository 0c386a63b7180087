"""What a lamp's nodes ask about their object, which is one and the same for all of its light: constants."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..scene.data import Graph, Instance, Node
from . import nodes  # noqa: F401  (fills the registry)
from .points import ObjectTable, sky_points
from .registry import REGISTRY

ASKING = {"ShaderNodeObjectInfo", "ShaderNodeParticleInfo"}
PER_OBJECT = {"OBJECT", "INSTANCER"}  # attributes


def asks_owner(item: Node) -> bool:
    """Whether a node asks about the object and nothing else."""
    return item.type in ASKING or (
        item.type == "ShaderNodeAttribute" and item.props.get("attribute_type") in PER_OBJECT
    )


def with_owner(graph: Graph, owner: Instance) -> Graph:
    """The graph with such nodes' answers in their places, of a lamp as an instance (its mesh is not looked at)."""
    points = sky_points(np.array([[0.0, 0.0, 1.0]]))
    points.objects = ObjectTable.from_instances([owner])
    items = [_answer(item, points) if asks_owner(item) else item for item in graph.nodes]
    return replace(graph, nodes=items)


def _answer(item: Node, points) -> Node:
    """A node of the same outputs that holds their values."""
    found = REGISTRY[item.type].function({}, {**item.props, "used": frozenset(item.output_kinds)}, points)
    values = {name: [float(c) for c in np.ravel(value)] for name, value in found.items()}
    plain = {name: value[0] if len(value) == 1 else value for name, value in values.items()}
    return replace(item, type="PhotonKnown", props={"values": plain}, inputs={})
