"""A node's settings and constants as plain data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Euler

from .compat import IES_DARK_BEYOND, SUBSURFACE_NAMES, VORONOI_WORD_HASH
from .images import ImageTable

RAMP_SIZE = 256  # entries of a sampled ramp or curve, as in Cycles
LUMINANCE = (0.2126729, 0.7151522, 0.0721750)
SCALARS = {"VALUE", "INT", "BOOLEAN"}
TRIPLES = {"VECTOR", "RGBA", "ROTATION"}
SIMPLE = {"ENUM", "BOOLEAN", "INT", "FLOAT", "STRING"}
BASE = frozenset(item.identifier for item in bpy.types.ShaderNode.bl_rna.properties)


def socket_value(socket: Any) -> Any:
    """An input's constant: float or list; None where the surface decides (hidden values) or there is none."""
    if socket.type == "SHADER" or not hasattr(socket, "default_value"):
        return None
    if socket.type == "VECTOR" and getattr(socket, "hide_value", False):
        return None
    value = socket.default_value
    if socket.type in SCALARS:
        return float(value)
    return [float(c) for c in value] if socket.type in TRIPLES else None


def coerce(value: Any, kind: str, target: str) -> Any:
    """A constant of one socket type as another, as links convert it."""
    if value is None or kind == target or target not in SCALARS | TRIPLES:
        return value
    if target in SCALARS:
        if kind == "RGBA":
            value = sum(a * b for a, b in zip(value, LUMINANCE, strict=False))
        elif kind in TRIPLES:
            value = sum(value[:3]) / 3.0
        return value if target == "VALUE" else float(int(value))
    if kind in SCALARS:
        return [value] * 3
    return value


def node_props(node: Any, images: ImageTable) -> dict[str, Any]:
    """All simple settings of a node by name; ramps and curves sampled, images as indices."""
    props: dict[str, Any] = {}
    for item in node.bl_rna.properties:
        name = item.identifier
        if name in BASE:
            continue
        if item.type in SIMPLE:
            value = getattr(node, name)
            props[name] = [float(c) for c in value] if getattr(item, "is_array", False) else value
            if name in ("falloff", "subsurface_method"):
                props[name] = SUBSURFACE_NAMES.get(value, value)
        elif item.type == "POINTER":
            _pointer(props, name, node, images)
    if node.bl_idname == "ShaderNodeTexVoronoi":
        props["word_hash"] = VORONOI_WORD_HASH
    if node.bl_idname == "ShaderNodeAmbientOcclusion":
        world = bpy.context.scene.world
        props["world_distance"] = world.light_settings.distance if world is not None else 10.0
    if node.bl_idname == "GeometryNodeInputSceneTime":
        props |= scene_time(images)
    if node.bl_idname == "ShaderNodeTexIES":
        props |= {"text": photometric_text(node), "dark_beyond": IES_DARK_BEYOND}
    if node.bl_idname in ("ShaderNodeValue", "ShaderNodeRGB", "ShaderNodeNormal"):
        value = node.outputs[0].default_value
        props["value"] = float(value) if node.bl_idname == "ShaderNodeValue" else [float(c) for c in value]
    return props


def scene_time(images: ImageTable) -> dict[str, float]:
    """The frame that is rendered, and its time [s]."""
    scene = bpy.context.scene
    frame = float(scene.frame_current_final if images.frame is None else images.frame)
    return {"frame": frame, "seconds": frame * scene.render.fps_base / scene.render.fps}


def photometric_text(node: Any) -> str:
    """What an IES Texture reads: a text in the file, or a file beside it; nothing when there is none."""
    if node.mode == "INTERNAL":
        return node.ies.as_string() if node.ies is not None else ""
    path = Path(bpy.path.abspath(node.filepath, library=node.id_data.library))
    try:
        return path.read_text(encoding="latin-1") if path.is_file() else ""
    except OSError:
        return ""


def _pointer(props: dict, name: str, owner: Any, images: ImageTable) -> None:
    """Settings that are data of their own: image, colour ramp, curves, another object, texture mapping."""
    value = getattr(owner, name)
    if value is None:
        return
    if isinstance(value, bpy.types.Image):
        props[name] = images.index(value, getattr(owner, "image_user", None))
    elif isinstance(value, bpy.types.ColorRamp):
        props[name] = ramp_data(value)
    elif isinstance(value, bpy.types.CurveMapping):
        props[name] = curve_data(value)
    elif isinstance(value, bpy.types.Object):
        props[f"{name}_inverse"] = inverse_matrix(value.matrix_world)
    elif isinstance(value, bpy.types.TexMapping):
        if not _is_plain_mapping(value):
            props[name] = mapping_data(value)
    elif isinstance(value, bpy.types.ImageUser):
        props["frame"] = value.frame_current


def _is_plain_mapping(mapping: Any) -> bool:
    """Whether a node's built-in mapping changes nothing."""
    return (
        tuple(mapping.translation) == (0.0, 0.0, 0.0) and tuple(mapping.rotation) == (0.0, 0.0, 0.0)
        and tuple(mapping.scale) == (1.0, 1.0, 1.0)
        and (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z) == ("X", "Y", "Z")
    )


def mapping_data(mapping: Any) -> dict[str, Any]:
    """A texture node's own mapping: matrix (3, 4), and whether the result is normalised. Cycles ignores the limits."""
    kind = mapping.vector_type
    scale = [s if abs(s) >= 1e-5 or kind in ("POINT", "VECTOR") else 1e-5 for s in mapping.scale]
    linear = np.array(Euler(mapping.rotation).to_matrix(), np.float64) @ np.diag(scale)
    offset = np.array(mapping.translation) if kind in ("POINT", "TEXTURE") else np.zeros(3)
    if kind == "TEXTURE":
        linear = np.linalg.inv(linear)
        offset = -linear @ offset
    elif kind == "NORMAL":
        linear = np.linalg.inv(linear).T
    axes = np.zeros((3, 3))
    for row, axis in enumerate((mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)):
        if axis != "NONE":
            axes[row, "XYZ".index(axis)] = 1.0
    return {"matrix": np.column_stack([linear @ axes, offset]).tolist(), "normal": kind == "NORMAL"}


def ramp_data(ramp: Any) -> dict[str, Any]:
    """A colour ramp sampled at 256 places: table (256, 4) f32, interpolation."""
    table = np.array([ramp.evaluate(i / (RAMP_SIZE - 1)) for i in range(RAMP_SIZE)], np.float32)
    return {"table": table, "interpolation": ramp.interpolation}


def inverse_matrix(matrix: Any) -> list[list[float]]:
    """World to the local space of a ``mathutils.Matrix``: in double, since Blender's own inverse is rounded."""
    double = np.array(matrix, np.float64)
    if np.linalg.matrix_rank(double[:3, :3]) < 3:
        return [list(row) for row in matrix.inverted_safe()]
    return np.linalg.inv(double).tolist()


def curve_data(mapping: Any) -> dict[str, Any]:
    """Curves sampled at 256 places between the first and last point: tables (256,) f32 each, min_x, max_x.

    Of a colour mapping's four curves the last is applied first, to all channels.
    """
    mapping.initialize()
    curves = list(mapping.curves)
    min_x = min(curve.points[0].location[0] for curve in curves)
    max_x = max(curve.points[-1].location[0] for curve in curves)
    places = [min_x + (max_x - min_x) * i / (RAMP_SIZE - 1) for i in range(RAMP_SIZE)]
    if len(curves) == 4:
        places = [mapping.evaluate(curves[3], t) for t in places]
        curves = curves[:3]
    tables = [np.array([mapping.evaluate(curve, t) for t in places], np.float32) for curve in curves]
    return {"tables": tables, "min_x": min_x, "max_x": max_x, "extrapolate": mapping.extend == "EXTRAPOLATED"}
