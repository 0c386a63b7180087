"""Where a texture node looks: the linked vector, else Generated coordinates, through the node's own mapping."""

from __future__ import annotations

import numpy as np

from ..registry import f32


def columns(rows):
    """Rows (n, 3) of the points as components (3, n)."""
    return np.ascontiguousarray(rows.T)


def texture_varies(item, used) -> bool:
    """Whether the node looks at the surface: it has a Vector input and nothing is linked there."""
    socket = item.inputs.get("Vector")
    return socket is not None and socket.node < 0 and socket.value is None


def texture_needs(item, used) -> set:
    """Generated coordinates where no vector is linked."""
    return {"generated"} if texture_varies(item, used) else set()


def mapped(vector, props):
    """The vector by the texture node's own mapping, (3, n)."""
    mapping = props.get("texture_mapping")
    if mapping is None:
        return vector
    matrix = np.asarray(mapping["matrix"], f32)
    vector = matrix[:, :3] @ vector + matrix[:, 3:]
    if mapping["normal"]:
        size = np.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])
        vector = vector / np.where(size > 0.0, size, f32(1.0))
    return vector


def texture_vector(x, props, points):
    """Where the texture is looked up, (3, n | 1)."""
    vector = x.get("Vector")
    return mapped(columns(points.generated) if vector is None else vector, props)
