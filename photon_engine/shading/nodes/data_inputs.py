"""Nodes that read data: attributes, the object, its particle, the camera; and Vector Transform between their spaces."""

from __future__ import annotations

import numpy as np

from ..procedural.white import hash_rows_beside_zero
from ..registry import constant, f32, node
from .coordinates import columns
from .geometry_inputs import affine, matrices, to_object, to_world
from .vectors import dot, normalize, rotate

LOCATION = 4  # of Instance.particle


@node("ShaderNodeVertexColor", varies=True, needs=lambda item, used: {f"attribute:{item.props.get('layer_name', '')}"})
def vertex_color(x, props, points):
    """A colour attribute of the mesh; no name: the active one."""
    rgba = points.attributes[props.get("layer_name", "")]
    return {"Color": columns(rgba[:, :3]), "Alpha": rgba[:, 3]}


def attribute_needs(item, used):
    """The mesh's attribute; objects' properties are in their table."""
    kind, name = item.props.get("attribute_type", "GEOMETRY"), item.props.get("attribute_name", "")
    if kind == "GEOMETRY":
        return {f"attribute:{name}"} if name else set()
    return {"objects"} if kind in ("OBJECT", "INSTANCER") else set()


def attribute_varies(item, used) -> bool:
    """All but those of the view layer."""
    return item.props.get("attribute_type", "GEOMETRY") != "VIEW_LAYER"


@node("ShaderNodeAttribute", varies=attribute_varies, needs=attribute_needs)
def attribute(x, props, points):
    """A mesh attribute, or a property of the object, the instancer or the view layer."""
    kind, name = props.get("attribute_type", "GEOMETRY"), props.get("attribute_name", "")
    if kind == "VIEW_LAYER":
        rows = np.array([props.get("value", (0.0,) * 4)], f32)
    elif kind == "GEOMETRY":
        rows = points.attributes.get(name) if name else None
    else:
        table = points.objects.attributes.get(f"{kind}:{name}")
        rows = None if table is None else table[points.instance]
    if rows is None:  # of lamps and the world, or without a name
        rows = np.tile(np.array([0.0, 0.0, 0.0, 1.0], f32), (len(points), 1))
    color = columns(rows[:, :3])
    mean = (color[0] + color[1] + color[2]) * f32(1.0 / 3.0)
    return {"Color": color, "Vector": color, "Fac": rows[:, 4] if rows.shape[1] > 4 else mean, "Alpha": rows[:, 3]}


@node("ShaderNodeCameraData", varies=True, needs={"camera"})
def camera_data(x, props, points):
    """View vector, depth and distance of the point from the camera."""
    v = affine(points.camera, points.p.T)
    return {"View Vector": normalize(v), "View Z Depth": v[2], "View Distance": np.sqrt(dot(v, v))}


@node("ShaderNodeObjectInfo", varies=True, needs={"objects"})
def object_info(x, props, points):
    """Properties of the object that was hit."""
    table, i = points.objects, points.instance
    return {"Location": located(points), "Color": columns(table.color[i, :3]), "Alpha": table.color[i, 3],
            "Object Index": table.pass_index[i], "Random": table.random[i],
            "Material Index": np.full(len(i), props.get("material_index", 0), f32)}


def located(points):
    """Origins of the points' objects in the world (3, n) f32."""
    return columns(points.objects.location[points.instance].astype(f32))


@node("PhotonKnown")
def known(x, props, points):
    """Outputs that were known when the scene was read: what a lamp's nodes ask about their object."""
    return {name: constant(value, "VECTOR" if isinstance(value, list) else "VALUE")
            for name, value in props["values"].items()}


@node("ShaderNodeParticleInfo", varies=True, needs={"objects"})
def particle_info(x, props, points):
    """What the instancing particle says of itself; zeros of other objects."""
    rows = points.objects.particle[points.instance]
    index, age, lifetime, size = rows[:, :LOCATION].T
    random = np.empty(len(rows), f32)
    hash_rows_beside_zero(index.astype(np.int64), random)
    location, velocity, spin = (columns(rows[:, LOCATION + 3 * k : LOCATION + 3 * k + 3]) for k in range(3))
    return {"Index": index, "Random": random, "Age": age, "Lifetime": lifetime, "Size": size, "Location": location,
            "Velocity": velocity, "Angular Velocity": spin}


@node("ShaderNodePointInfo", varies=True)
def point_info(x, props, points):
    """Of a point cloud; zeros on meshes."""
    zero = np.zeros(len(points), f32)
    return {"Position": np.zeros((3, len(points)), f32), "Radius": zero, "Random": zero}


@node("ShaderNodeHairInfo", varies=True)
def hair_info(x, props, points):
    """Of a strand; zeros on meshes."""
    return {name: np.zeros((3, len(points)) if name == "Tangent Normal" else len(points), f32)
            for name in props["used"]}


def vector_transform_needs(item, used):
    """The spaces that are not the world's."""
    spaces = {item.props.get("convert_from", "WORLD"), item.props.get("convert_to", "OBJECT")}
    return ({"objects"} if "OBJECT" in spaces else set()) | ({"camera"} if "CAMERA" in spaces else set())


@node("ShaderNodeVectorTransform", varies=True, needs=vector_transform_needs)
def vector_transform(x, props, points):
    """A point, vector or normal of one space in another."""
    kind = props.get("vector_type", "VECTOR")
    start, end = props.get("convert_from", "WORLD"), props.get("convert_to", "OBJECT")
    v = x["Vector"]
    if start != end:
        v = _from_world(_to_world(v, kind, start, points), kind, end, points)
    return {"Vector": v}


def _to_world(v, kind, space, points):
    """From a space to the world."""
    if space == "OBJECT":
        if kind == "NORMAL":
            return to_world(points, v)
        turned = rotate(matrices(points.objects.matrix, points), v)
        return turned + located(points) if kind == "POINT" else turned
    if space == "CAMERA":
        matrix = np.linalg.inv(points.camera.astype(np.float64)).astype(f32)
        if kind == "NORMAL":
            return normalize(points.camera[:3, :3].T @ v)
        return affine(matrix, v) + middle(points) if kind == "POINT" else matrix[:3, :3] @ v
    return v


def middle(points):
    """Where positions are counted from, (3, 1) f32, in the world."""
    return points.origin.astype(f32)[:, None]


def _from_world(v, kind, space, points):
    """From the world to a space."""
    if space == "OBJECT":
        if kind == "NORMAL":
            return to_object(points, v)
        if kind == "POINT":
            v = v - located(points)
        return rotate(matrices(points.objects.inverse, points), v)
    if space == "CAMERA":
        if kind == "NORMAL":
            return normalize(np.linalg.inv(points.camera[:3, :3].astype(np.float64)).T.astype(f32) @ v)
        return affine(points.camera, v - middle(points)) if kind == "POINT" else points.camera[:3, :3] @ v
    return v


@node("GeometryNodeInputSceneTime")
def scene_time(x, props, points):
    """When it is."""
    return {"Seconds": np.full(1, props.get("seconds", 0.0), f32), "Frame": np.full(1, props.get("frame", 0.0), f32)}
