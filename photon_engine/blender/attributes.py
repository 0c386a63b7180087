"""Properties that Attribute nodes read of objects, instancers and view layers, and what particles say of themselves."""

from __future__ import annotations

from typing import Any

from ..scene.data import Graph

NOTHING = (0.0, 0.0, 0.0, 0.0)
PER_INSTANCE = ("OBJECT", "INSTANCER")
MOST_CHANNELS = 4


def wanted_attributes(graph: Graph) -> frozenset[tuple[str, str]]:
    """(kind, name) of what a graph reads of its objects, kind OBJECT or INSTANCER."""
    return frozenset(
        (node.props["attribute_type"], node.props.get("attribute_name", ""))
        for node in graph.nodes
        if node.type == "ShaderNodeAttribute" and node.props.get("attribute_type") in PER_INSTANCE
    )


def property_value(block: Any, name: str) -> tuple[float, ...] | None:
    """A block's custom property, or a property by its path, as rgba; None: there is none, or it is no number."""
    if block is None or not name:
        return None
    try:
        value = block.get(name)
        if value is None:
            value = block.path_resolve(name)
    except (ValueError, TypeError, AttributeError):
        return None
    if isinstance(value, (bool, int, float)):
        return (float(value),) * 3 + (1.0,)
    try:
        channels = [float(c) for c in value]
    except (TypeError, ValueError):
        return None
    if len(channels) > MOST_CHANNELS:
        return None
    return (*channels, *(0.0, 0.0, 0.0, 1.0)[len(channels):])


def first_value(blocks: Any, name: str) -> tuple[float, ...]:
    """The first of the blocks that has the property, else zeros."""
    for block in blocks:
        value = property_value(block, name)
        if value is not None:
            return value
    return NOTHING


def instance_attribute(item: Any, kind: str, name: str) -> tuple[float, ...]:
    """What an Attribute node of kind OBJECT or INSTANCER sees; item: a depsgraph's object instance."""
    blocks: list[Any] = []
    if kind == "INSTANCER" and item.is_instance:
        if item.particle_system is not None:
            blocks.append(item.particle_system.settings)
        blocks.append(item.parent)
    return first_value([*blocks, item.object, item.object.data], name)


def view_layer_attribute(scene: Any, layer: Any, name: str) -> tuple[float, ...]:
    """What an Attribute node of kind VIEW_LAYER sees."""
    return first_value([layer, scene, scene.world], name)


def particle_of(item: Any, frame: float) -> tuple[float, ...] | None:
    """Particle Info: index, age, lifetime, size, location, velocity, angular velocity; None: it is no particle.

    Ages and lifetimes in frames, as in Cycles.
    """
    if not item.is_instance or item.particle_system is None:
        return None
    index = item.persistent_id[0]
    particles = item.particle_system.particles
    if index < 0 or index >= len(particles):
        return None
    p = particles[index]
    vectors = (*p.location, *p.velocity, *p.angular_velocity)
    return (float(index), frame - p.birth_time, p.lifetime, p.size, *(float(c) for c in vectors))
