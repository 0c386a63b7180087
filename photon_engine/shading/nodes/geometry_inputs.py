"""Nodes that read the surface: coordinates, normals, Fresnel, Layer Weight, Normal Map."""

from __future__ import annotations

import numpy as np

from ...geometry.pointiness import NAME as POINTINESS
from ..registry import f32, node
from .coordinates import columns
from .normals import contiguous, tangent_rows
from .vectors import cross, dot, normalize, rotate

ONE = f32(1.0)


def pad(uv):
    """(n, 2) as (3, n) with z = 0."""
    out = np.zeros((3, len(uv)), f32)
    out[:2] = uv.T
    return out


def facing(points, rows=None):
    """The surface's normal, or another (n, 3), turned to the side that was hit, (3, n)."""
    return columns(points.facing(points.ns if rows is None else rows))


def surface_normal(x, points, name="Normal"):
    """The linked normal, else the surface's on the side that was hit."""
    linked = x.get(name)
    return facing(points) if linked is None else linked


def matrices(table, points):
    """The matrix of each point's object from a table (I, 3, 3), as (3, 3, n | 1)."""
    return (table if len(table) == 1 else table[points.instance]).transpose(1, 2, 0)


def to_object(points, normals):
    """World normals in the object's space: M^T n, unit."""
    return normalize(rotate(matrices(points.objects.matrix, points).transpose(1, 0, 2), normals))


def to_world(points, normals):
    """Object-space normals in the world: M^-T n, unit."""
    return normalize(rotate(matrices(points.objects.inverse, points).transpose(1, 0, 2), normals))


def affine(matrix, p):
    """Points p (3, n) by a matrix (4, 4)."""
    matrix = np.asarray(matrix, f32)
    return matrix[:3, :3] @ p + matrix[:3, 3:]


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
    return {"Fac": fresnel_dielectric(dot(points.wo.T, surface_normal(x, points)), eta)}


@node("ShaderNodeLayerWeight", varies=True)
def layer_weight(x, props, points):
    """Weights that grow towards grazing view."""
    blend, out = x["Blend"], {}
    cosine = dot(points.wo.T, surface_normal(x, points))
    if "Fresnel" in props["used"]:
        eta = np.maximum(ONE - blend, f32(1e-5))
        out["Fresnel"] = fresnel_dielectric(cosine, np.where(points.backfacing, eta, ONE / eta))
    if "Facing" in props["used"]:
        b = np.clip(blend, 0.0, f32(1.0 - 1e-5))
        exponent = np.where(b < 0.5, 2.0 * b, f32(0.5) / (ONE - b))
        out["Facing"] = ONE - np.abs(cosine) ** exponent
    return out


TEX_COORD_NEEDS = {
    "UV": {"uv"}, "Generated": {"generated"}, "Object": {"object"}, "Camera": {"camera"}, "Window": {"camera"},
    "Normal": {"objects"},
}  # fmt: skip


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
        out["Generated"] = columns(points.generated)
    if "Object" in used:
        if (inverse := props.get("object_inverse")) is not None:
            out["Object"] = affine(points.to_space(inverse), points.p.T)
        else:
            out["Object"] = columns(points.object)
    if "Normal" in used:
        out["Normal"] = to_object(points, facing(points))
    if "Camera" in used:
        out["Camera"] = affine(points.camera, points.p.T)
    if "Window" in used:
        out["Window"] = window_coordinates(points)
    if "Reflection" in used:
        n, wo = facing(points), columns(points.wo)
        out["Reflection"] = 2.0 * dot(wo, n) * n - wo
    return out


def window_coordinates(points):
    """Where in the picture the points are seen, (3, n): (0, 0) bottom left, (1, 1) top right."""
    left, right, bottom, top, perspective = points.window
    x, y, z = affine(points.camera, points.p.T)
    if perspective:
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = np.where(z != 0.0, x / z, f32(0.0)), np.where(z != 0.0, y / z, f32(0.0))
    return np.stack([(x - left) / f32(right - left), (y - bottom) / f32(top - bottom), np.zeros_like(z)])


def uv_layer(item, used):
    """The named layer, or the active one."""
    name = item.props.get("uv_map", "")
    return {f"uv:{name}" if name else "uv"}


@node("ShaderNodeUVMap", varies=True, needs=uv_layer)
def uv_map(x, props, points):
    """Coordinates of a UV layer."""
    return {"UV": pad(points.uvs[props.get("uv_map", "")])}


GEOMETRY_NEEDS = {"Parametric": {"parametric"}, "Random Per Island": {"island"}, "Tangent": {"generated", "objects"},
                  "Pointiness": {f"attribute:{POINTINESS}"}}


@node("ShaderNodeNewGeometry", varies=True,
      needs=lambda item, used: set().union(*(GEOMETRY_NEEDS.get(name, set()) for name in used)))
def geometry(x, props, points):
    """Position, normals and the like, in the world."""
    used, out = props["used"], {}
    if "Position" in used:
        out["Position"] = columns(points.world())
    if "Normal" in used:
        out["Normal"] = facing(points)
    if "True Normal" in used:
        out["True Normal"] = facing(points, points.ng)
    if "Incoming" in used:
        out["Incoming"] = columns(points.wo)
    if "Backfacing" in used:
        out["Backfacing"] = points.backfacing.astype(f32)
    if "Parametric" in used:
        u, v = points.parametric.T
        out["Parametric"] = np.stack([ONE - u - v, u, np.zeros_like(u)])
    if "Random Per Island" in used:
        out["Random Per Island"] = points.island_random
    if "Pointiness" in used:
        out["Pointiness"] = points.attributes[POINTINESS][:, -1]
    if "Tangent" in used and points.is_lamp:  # Cycles divides by its length, 0: no number, which shines black
        out["Tangent"] = np.full((3, len(points)), np.nan, f32)
    elif "Tangent" in used:  # radial about the object's z axis
        x, y, z = points.generated.T - f32(0.5)
        radial = to_world(points, np.stack([-y, x, np.zeros_like(z)]))
        n = facing(points)
        out["Tangent"] = cross(n, normalize(cross(radial, n)))
    return out


def wireframe_needs(item, used):
    """The triangle; and how wide a pixel is, for sizes in pixels."""
    return {"corners", "bump"} if item.props.get("use_pixel_size") else {"corners"}


@node("ShaderNodeWireframe", varies=True, needs=wireframe_needs)
def wireframe(x, props, points):
    """1 within half the size of an edge of the triangle."""
    width = x["Size"] * f32(0.5)
    if points.corners is None or (props.get("use_pixel_size") and points.around is None):  # of vertices, or the world
        return {"Fac": np.zeros(len(points), f32)}
    if props.get("use_pixel_size"):
        across = [columns(d) for d in points.around.dp]
        wo = columns(points.wo)
        seen = [d - dot(d, wo) * wo for d in across]
        width = width * f32(0.5) * (np.sqrt(dot(seen[0], seen[0])) + np.sqrt(dot(seen[1], seen[1])))
    near = np.zeros(len(points), bool)
    corners = [columns(points.corners[:, k]) for k in range(3)]
    for k in range(3):
        edge = corners[k] - corners[k - 1]
        area = cross(edge, corners[k])
        near |= dot(area, area) < dot(edge, edge) * width * width
    return {"Fac": near.astype(f32)}


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
        color = np.stack([color[0], ONE - color[1], color[2]])
    own = facing(points)
    if space == "TANGENT":
        return {"Normal": _or_own(facing(points, _tangent_normal(color, strength, props, points)), own)}
    c = 2.0 * color - ONE
    if space.startswith("BLENDER"):
        c = c * np.array([[1.0], [-1.0], [-1.0]], f32)
    n = to_world(points, c) if space.endswith("OBJECT") else normalize(c)
    n = np.where(points.backfacing, -n, n)
    return {"Normal": _or_own(normalize(own + (n - own) * np.maximum(strength, 0.0)), own)}


def _or_own(n, own):
    """The surface's normal where the perturbed one vanishes."""
    bad = dot(n, n) == 0.0
    return np.where(bad, own, n) if bad.any() else n


def _tangent_normal(color, strength, props, points):
    """Normal from a tangent-space colour, with the mesh's own interpolated frame, world, outward, (n, 3)."""
    tangent = points.tangents.get(props.get("uv_map", ""))
    if tangent is None:
        return points.ns
    out = np.empty(points.ns.shape, f32)
    tangent_rows(
        contiguous(color.T), contiguous(strength), contiguous(tangent), contiguous(points.normal_local),
        contiguous(points.objects.inverse), points.instance, out,
    )  # fmt: skip
    return out
