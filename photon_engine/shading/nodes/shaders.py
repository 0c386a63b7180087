"""Shader nodes: what scatters or shines. Each gives a list of lobes from bsdf/recipes.py."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ...bsdf import recipes
from ...bsdf.principled import PrincipledInputs
from ...bsdf.subsurface import Flesh
from ...bsdf.subsurface import subsurface as subsurface_lobes
from ..registry import column, f32, node
from .normals import contiguous, outward_rows
from .relief import in_surface, radial
from .vectors import cross, dot

UNIT_RADIUS = np.ones((1, 3), f32)
PRINCIPLED_INPUTS = frozenset(item.name for item in fields(PrincipledInputs))


def linked_normal(name: str = "Normal"):
    """For `varies`: a given normal is turned to the outside, which needs the surface."""
    def check(item, used):
        socket = item.inputs.get(name)
        return socket is not None and (socket.node >= 0 or socket.value is not None)

    return check


def outward(x, points, name="Normal"):
    """The linked normal turned back to the outside, as lobes want it; None: the surface's own."""
    normal = x.get(name)
    if normal is None:
        return None
    out = np.empty(points.ns.shape, f32)
    outward_rows(contiguous(normal), contiguous(points.ns), points.backfacing, out)
    return out


def is_stretched(item) -> bool:
    """Whether a glossy node may have wider facets along one direction."""
    sockets = [item.inputs.get(name) for name in ("Anisotropy", "Anisotropic")]
    return any(socket is not None and (socket.node >= 0 or socket.value) for socket in sockets)


def stretched_varies(item, used):
    """A direction in the surface, or a linked normal, needs the surface."""
    return is_stretched(item) or linked_normal()(item, used) or linked_normal("Coat Normal")(item, used)


def stretched_needs(item, used):
    """Without a linked tangent facets lie round the z axis of Generated space."""
    socket = item.inputs.get("Tangent")
    return {"generated", "objects"} if is_stretched(item) and (socket is None or socket.node < 0) else set()


def stretch(x, points, amount: str, rotation: str) -> dict:
    """Anisotropy and tangent (n, 3) of a node; the tangent is turned about the normal by `rotation` full turns."""
    if points is None or not np.any(x.get(amount, 0.0)):
        return {}
    t = x.get("Tangent")
    t = in_surface(points, radial(points)) if t is None else t.T
    turns = x.get(rotation)
    if turns is not None and np.any(turns):
        n = x.get("Normal")
        n = points.facing(points.ns).T if n is None else n.T
        angle = turns * f32(2.0 * np.pi)
        c, s = np.cos(angle), np.sin(angle)
        t = t * c + cross(n, t) * s + n * (dot(n, t) * (f32(1.0) - c))
    return {amount.lower(): x[amount], "tangent": np.broadcast_to(t, points.ns.T.shape).T}


@node("ShaderNodeBsdfDiffuse", varies=linked_normal())
def diffuse(x, props, points):
    """Lambert or Oren-Nayar."""
    return {"BSDF": recipes.diffuse(x["Color"], x["Roughness"], outward(x, points))}


@node("ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfGlossy", varies=stretched_varies, needs=stretched_needs)
def glossy(x, props, points):
    """A microfacet mirror without Fresnel."""
    distribution = props.get("distribution", "MULTI_GGX")
    along = stretch(x, points, "Anisotropy", "Rotation")
    return {"BSDF": recipes.glossy(x["Color"], x["Roughness"], outward(x, points), distribution, **along)}


def filmed(x) -> dict:
    """Fields of a node's thin film; 4.5 has none on glass and metal."""
    return recipes.film(x.get("Thin Film Thickness", 0.0), x.get("Thin Film IOR", 1.33))


@node("ShaderNodeBsdfGlass", varies=linked_normal())
def glass(x, props, points):
    """A dielectric that reflects and refracts."""
    distribution = props.get("distribution", "MULTI_GGX")
    return {"BSDF": recipes.glass(x["Color"], x["Roughness"], x["IOR"], outward(x, points), distribution, filmed(x))}


@node("ShaderNodeBsdfRefraction", varies=linked_normal())
def refraction(x, props, points):
    """A dielectric that only refracts."""
    distribution = props.get("distribution", "GGX")
    return {"BSDF": recipes.refraction(x["Color"], x["Roughness"], x["IOR"], outward(x, points), distribution)}


@node("ShaderNodeBsdfTranslucent", varies=linked_normal())
def translucent(x, props, points):
    """Lambert through the surface."""
    return {"BSDF": recipes.translucent(x["Color"], outward(x, points))}


@node("ShaderNodeBsdfSheen", varies=linked_normal())
def sheen(x, props, points):
    """Cloth: a layer of fibres, or Ashikhmin's velvet."""
    make = recipes.velvet if props.get("distribution") == "ASHIKHMIN" else recipes.sheen
    return {"BSDF": make(x["Color"], x["Roughness"], outward(x, points))}


@node("ShaderNodeBsdfToon", varies=linked_normal())
def toon(x, props, points):
    """An even cone with a rim."""
    mirrored = props.get("component") == "GLOSSY"
    return {"BSDF": recipes.toon(x["Color"], x["Size"], x["Smooth"], outward(x, points), mirrored)}


@node("ShaderNodeSubsurfaceScattering", varies=linked_normal())
def subsurface(x, props, points):
    """A random walk below the surface."""
    radius = x.get("Radius", UNIT_RADIUS) * column(np.maximum(x.get("Scale", np.ones(1, f32)), 0.0))
    flesh = Flesh(
        radius, x.get("IOR", 1.4), x.get("Roughness", 1.0), x.get("Anisotropy", 0.0),
        props.get("falloff", "RANDOM_WALK"),
    )  # fmt: skip
    return {"BSSRDF": subsurface_lobes(x["Color"], flesh, outward(x, points))}


@node("ShaderNodeBsdfTransparent")
def transparent(x, props, points):
    """Straight through, coloured."""
    return {"BSDF": recipes.transparent(x["Color"])}


@node("ShaderNodeEmission")
def emission(x, props, points):
    """Light of the surface."""
    return {"Emission": recipes.emission(x["Color"], x["Strength"])}


FAR = np.finfo(f32).max


def falloff_varies(item, used):
    """Only the quadratic falloff, not smoothed, is the lamp's own."""
    smooth = item.inputs.get("Smooth")
    return bool(used - {"Quadratic"}) or (smooth is not None and (smooth.node >= 0 or bool(smooth.value)))


@node("ShaderNodeLightFalloff", varies=falloff_varies)
def light_falloff(x, props, points):
    """A lamp's strength, which grows with distance where it shall fall off by less than the square of that.

    Suns, and what is no lamp, keep theirs (on surfaces that is reported). Near the lamp, `Smooth` takes from it.
    """
    strength = x["Strength"]
    if points is None or not points.is_lamp:
        return dict.fromkeys(("Quadratic", "Linear", "Constant"), strength)
    t = np.where(points.ray_length < FAR, points.ray_length, f32(1.0))
    smooth = np.maximum(x["Smooth"], f32(0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        eased = np.where((smooth > 0.0) & (points.ray_length < FAR), t * t / (smooth + t * t), f32(1.0)) * strength
    return {"Quadratic": eased, "Linear": eased * t, "Constant": eased * t * t}


@node("ShaderNodeBackground")
def background(x, props, points):
    """Light of the world."""
    return {"Background": recipes.emission(x["Color"], x["Strength"])}


@node("ShaderNodeHoldout")
def holdout(x, props, points):
    """A hole in the picture."""
    return {"Holdout": recipes.holdout()}


@node("ShaderNodeMixShader")
def mix_shader(x, props, points):
    """Both shaders, weighted 1 - factor and factor."""
    t = column(np.clip(x["Fac"], 0.0, 1.0))
    first, second = x.get("Shader") or [], x.get("Shader_001") or []
    return {"Shader": recipes.scale_lobes(first, f32(1.0) - t) + recipes.scale_lobes(second, t)}


@node("ShaderNodeAddShader")
def add_shader(x, props, points):
    """Both shaders."""
    return {"Shader": (x.get("Shader") or []) + (x.get("Shader_001") or [])}


@node("ShaderNodeBsdfPrincipled", varies=stretched_varies, needs=stretched_needs)
def principled(x, props, points):
    """Blender's layered shader; sockets by name in small letters with underscores."""
    given = {name.lower().replace(" ", "_"): value for name, value in x.items() if value is not None}
    given["normal"] = outward(x, points)
    given["coat_normal"] = outward(x, points, "Coat Normal")
    given["distribution"] = props.get("distribution", "MULTI_GGX")
    given["subsurface_method"] = props.get("subsurface_method", "RANDOM_WALK")
    given["tangent"] = None
    given |= stretch(x, points, "Anisotropic", "Anisotropic Rotation")
    given = {name: value for name, value in given.items() if name in PRINCIPLED_INPUTS}
    return {"BSDF": recipes.principled(**given)}


@node("ShaderNodeBsdfMetallic", varies=stretched_varies, needs=stretched_needs)
def metallic(x, props, points):
    """A metal by colour and edge tint (F82), or by its complex index."""
    tail = x["Roughness"], outward(x, points), props.get("distribution", "MULTI_GGX")
    along = stretch(x, points, "Anisotropy", "Rotation") | {"thin_film": filmed(x)}
    if props.get("fresnel_type") == "PHYSICAL_CONDUCTOR":
        return {"BSDF": recipes.metallic_conductor(x["IOR"], x["Extinction"], *tail, **along)}
    return {"BSDF": recipes.metallic_f82(x["Base Color"], x["Edge Tint"], *tail, **along)}
