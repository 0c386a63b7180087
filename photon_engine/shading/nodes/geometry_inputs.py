"""Nodes that read the surface: coordinates, normals, Fresnel, Layer Weight, Light Path, Object Info."""

from __future__ import annotations

import numpy as np

from ..registry import column, f32, node
from .normals import contiguous, tangent_rows
from .vectors import cross, dot, normalize, rotate

ONE = f32(1.0)


def pad(uv):
    """(n, 2) as (n, 3) with z = 0."""
    return np.concatenate([uv, np.zeros((len(uv), 1), f32)], axis=1)


def surface_normal(x, points, name="Normal"):
    """The linked normal, else the surface's on the side that was hit."""
    linked = x.get(name)
    return points.facing(points.ns) if linked is None else linked


def to_object(points, normals):
    """World normals in the object's space: M^T n, unit."""
    matrix = points.objects.matrix
    matrix = matrix if len(matrix) == 1 else matrix[points.instance]
    return normalize(rotate(matrix.transpose(0, 2, 1), normals))


def to_world(points, normals):
    """Object-space normals in the world: M^-T n, unit."""
    inverse = points.objects.inverse
    inverse = inverse if len(inverse) == 1 else inverse[points.instance]
    return normalize(rotate(inverse.transpose(0, 2, 1), normals))


def fresnel_dielectric(cosine, eta):
    """Unpolarised reflectance of a dielectric, 1 in total reflection; eta: index behind over index in front."""
    c = np.abs(cosine)
    g2 = eta * eta - ONE + c * c
    g = np.sqrt(np.maximum(g2, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (g - c) / (g + c)
        b = (c * (g + c) - ONE) / (c * (g - c) + ONE)
        f = f32(0.5) * a * a * (ONE + b * b)
    return np.where(g2 > 0.0, f, ONE)


@node("ShaderNodeFresnel", varies=True)
def fresnel(x, props, points):
    """Dielectric reflectance seen from here; the back side inverts the index."""
    eta = np.maximum(x["IOR"], f32(1e-5))
    eta = np.where(points.backfacing, ONE / eta, eta)
    return {"Fac": fresnel_dielectric(dot(points.wo, surface_normal(x, points)), eta)}


@node("ShaderNodeLayerWeight", varies=True)
def layer_weight(x, props, points):
    """Weights that grow towards grazing view."""
    blend, out = x["Blend"], {}
    cosine = dot(points.wo, surface_normal(x, points))
    if "Fresnel" in props["used"]:
        eta = np.maximum(ONE - blend, f32(1e-5))
        out["Fresnel"] = fresnel_dielectric(cosine, np.where(points.backfacing, eta, ONE / eta))
    if "Facing" in props["used"]:
        b = np.clip(blend, 0.0, f32(1.0 - 1e-5))
        exponent = np.where(b < 0.5, 2.0 * b, f32(0.5) / (ONE - b))
        out["Facing"] = ONE - np.abs(cosine) ** exponent
    return out


TEX_COORD_NEEDS = {"UV": {"uv"}, "Generated": {"generated"}, "Object": {"object"}, "Camera": {"camera"},
                   "Normal": {"objects"}}


def texture_coordinate_needs(item, used):
    """What the linked outputs read."""
    return set().union(*(TEX_COORD_NEEDS.get(name, set()) for name in used))


@node("ShaderNodeTexCoord", varies=True, needs=texture_coordinate_needs)
def texture_coordinate(x, props, points):
    """Coordinates of the surface point."""
    used, out = props["used"], {}
    if "UV" in used:
        out["UV"] = pad(points.uvs[""])
    if "Generated" in used:
        out["Generated"] = points.generated
    if "Object" in used:
        if (inverse := props.get("object_inverse")) is not None:
            inverse = np.asarray(inverse, f32)
            out["Object"] = points.p @ inverse[:3, :3].T + inverse[:3, 3]
        else:
            out["Object"] = points.object
    if "Normal" in used:
        out["Normal"] = to_object(points, points.facing(points.ns))
    if "Camera" in used:
        out["Camera"] = points.p @ points.camera[:3, :3].T + points.camera[:3, 3]
    if "Reflection" in used:
        n = points.facing(points.ns)
        out["Reflection"] = 2.0 * column(dot(points.wo, n)) * n - points.wo
    return out


def uv_layer(item, used):
    """The named layer, or the active one."""
    name = item.props.get("uv_map", "")
    return {f"uv:{name}" if name else "uv"}


@node("ShaderNodeUVMap", varies=True, needs=uv_layer)
def uv_map(x, props, points):
    """Coordinates of a UV layer."""
    return {"UV": pad(points.uvs[props.get("uv_map", "")])}


@node("ShaderNodeVertexColor", varies=True, needs=lambda item, used: {f"attribute:{item.props.get('layer_name', '')}"})
def vertex_color(x, props, points):
    """A colour attribute of the mesh; no name: the active one."""
    rgba = points.attributes[props.get("layer_name", "")]
    return {"Color": rgba[:, :3], "Alpha": rgba[:, 3]}


GEOMETRY_NEEDS = {"Parametric": {"parametric"}, "Tangent": {"generated", "objects"}}


@node("ShaderNodeNewGeometry", varies=True,
      needs=lambda item, used: set().union(*(GEOMETRY_NEEDS.get(name, set()) for name in used)))
def geometry(x, props, points):
    """Position, normals and the like, in the world."""
    used, out = props["used"], {}
    if "Position" in used:
        out["Position"] = points.p
    if "Normal" in used:
        out["Normal"] = points.facing(points.ns)
    if "True Normal" in used:
        out["True Normal"] = points.facing(points.ng)
    if "Incoming" in used:
        out["Incoming"] = points.wo
    if "Backfacing" in used:
        out["Backfacing"] = points.backfacing.astype(f32)
    if "Parametric" in used:
        u, v = points.parametric.T
        out["Parametric"] = np.stack([ONE - u - v, u, np.zeros_like(u)], axis=1)
    if "Tangent" in used:  # radial about the object's z axis
        g = points.generated - f32(0.5)
        radial = to_world(points, np.stack([-g[:, 1], g[:, 0], np.zeros_like(g[:, 0])], axis=1))
        n = points.facing(points.ns)
        out["Tangent"] = cross(n, normalize(cross(radial, n)))
    return out


LIGHT_PATH_FLAGS = {"Is Camera Ray": "is_camera", "Is Shadow Ray": "is_shadow"}


@node("ShaderNodeLightPath", varies=True)
def light_path(x, props, points):
    """What kind of ray looks: the eye, a photon (0 everywhere) or a shadow ray; unknown outputs are 0."""
    n = len(points)
    out = {name: np.zeros(n, f32) for name in props["used"]}
    for name, flag in LIGHT_PATH_FLAGS.items():
        if name in out and getattr(points, flag):
            out[name] = np.ones(n, f32)
    return out


@node("ShaderNodeCameraData", varies=True, needs={"camera"})
def camera_data(x, props, points):
    """View vector, depth and distance of the point from the camera."""
    v = points.p @ points.camera[:3, :3].T + points.camera[:3, 3]
    return {"View Vector": normalize(v), "View Z Depth": v[:, 2], "View Distance": np.sqrt(dot(v, v))}


@node("ShaderNodeObjectInfo", varies=True, needs={"objects"})
def object_info(x, props, points):
    """Properties of the object that was hit."""
    table, i = points.objects, points.instance
    return {"Location": table.location[i], "Color": table.color[i, :3], "Alpha": table.color[i, 3],
            "Object Index": table.pass_index[i], "Random": table.random[i],
            "Material Index": np.full(len(i), props.get("material_index", 0), f32)}


def normal_map_needs(item, used):
    """Tangents of the UV layer, in tangent space."""
    if item.props.get("space", "TANGENT") != "TANGENT":
        return {"objects"}
    name = item.props.get("uv_map", "")
    return {"objects", "normal_local", f"tangent:{name}" if name else "tangent"}


@node("ShaderNodeNormalMap", varies=True, needs=normal_map_needs)
def normal_map(x, props, points):
    """A shading normal from a colour, in tangent, object or world space; turned to the side that was hit."""
    color, strength, space = x["Color"], x["Strength"], props.get("space", "TANGENT")
    if props.get("convention") == "DIRECTX":
        color = np.stack([color[:, 0], ONE - color[:, 1], color[:, 2]], axis=1)
    own = points.facing(points.ns)
    if space == "TANGENT":
        return {"Normal": _or_own(points.facing(_tangent_normal(color, strength, props, points)), own)}
    c = 2.0 * color - ONE
    if space.startswith("BLENDER"):
        c = c * np.array([1.0, -1.0, -1.0], f32)
    n = to_world(points, c) if space.endswith("OBJECT") else normalize(c)
    n = points.facing(np.broadcast_to(n, own.shape))
    strength = column(np.maximum(strength, 0.0))
    return {"Normal": _or_own(normalize(own + (n - own) * strength), own)}


def _or_own(n, own):
    """The surface's normal where the perturbed one vanishes."""
    bad = dot(n, n) == 0.0
    return np.where(column(bad), own, n) if bad.any() else n


def _tangent_normal(color, strength, props, points):
    """Normal from a tangent-space colour, with the mesh's own interpolated frame, world, outward."""
    tangent = points.tangents.get(props.get("uv_map", ""))
    if tangent is None:
        return points.ns
    out = np.empty(points.ns.shape, f32)
    tangent_rows(
        contiguous(color), contiguous(strength), contiguous(tangent), contiguous(points.normal_local),
        contiguous(points.objects.inverse), points.instance, out,
    )  # fmt: skip
    return out
