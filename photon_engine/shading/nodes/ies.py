"""IES Texture: a photometric file by direction."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..ies import MISSING, Photometry, look_up, parse_ies
from ..registry import f32, node
from .coordinates import columns, texture_varies
from .geometry_inputs import to_object
from .vectors import normalize


@lru_cache(maxsize=64)
def photometry(text: str) -> Photometry | None:
    """A file's photometry, parsed once; None: it cannot be read."""
    try:
        return parse_ies(text)
    except ValueError:
        return None


def needs(item, used) -> set:
    """Without a linked vector the view is turned into the object's space."""
    return {"objects"} if texture_varies(item, used) else set()


@node("ShaderNodeTexIES", varies=texture_varies, needs=needs)
def ies_texture(x, props, points):
    """The intensity toward a direction; without a linked vector toward the viewer."""
    vector = x.get("Vector")
    vector = to_object(points, columns(points.wo)) if vector is None else normalize(vector)
    table = photometry(props.get("text", ""))
    if table is None:
        value = np.full(1, MISSING, f32)
    else:
        down = np.arccos(np.clip(-vector[2], -1.0, 1.0))
        around = np.arctan2(vector[0], vector[1]) + f32(np.pi)
        value = look_up(table, around, down, bool(props.get("dark_beyond")))
    return {name: value * x["Strength"] for name in ("Fac", "Factor")}
