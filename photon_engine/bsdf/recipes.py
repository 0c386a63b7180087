"""Lobes of Blender's shader nodes: numpy constructors that take one value or one for each hit.

Colours are (3,), (1, 3), (n, 3) or a grey number, linear; numbers are scalars, (1,) or (n,). A normal is None (the
surface's own) or (n, 3), unit, world, on the side of the geometric normal. Roughness is Blender's, unsquared. Lobes
whose weight is zero for all hits are left out.
"""

from __future__ import annotations

import itertools

import numpy as np

from . import layout as lay
from .layout import Lobe
from .microfacet import NEARLY_ONE

MULTI = "MULTI_GGX"
FACETS = {MULTI: 1.0, "BECKMANN": lay.BECKMANN, "ASHIKHMIN_SHIRLEY": lay.ASHIKHMIN}  # MULTISCATTER; GGX: 0
SMOOTH = 0.01  # roughness of a mirror (microfacet.DELTA_ALPHA)
THINNEST_FILM = 0.1  # [nm]; Blender's renderer ignores thinner ones
_group_ids = itertools.count(1)


def real(value) -> np.ndarray:
    """An array of float32 as it is, anything else as float64."""
    value = np.asarray(value)
    return value if value.dtype == np.float32 and value.ndim else np.asarray(value, np.float64)


def column(value) -> np.ndarray:
    """A number for each hit as (n,) or (1,)."""
    value = np.atleast_1d(real(value))
    if value.ndim != 1:
        raise ValueError(f"a number needs the shape () or (n,), not {value.shape}")
    return value


def color(value) -> np.ndarray:
    """A colour, (3,) or (4,), or one for each hit, (n, 3) or (n, 4), or a grey number: as (1 | n, 3), not negative.

    A fourth channel is cut.
    """
    value = real(value)
    if value.ndim == 0:
        value = np.full((1, 3), value)
    value = np.atleast_2d(value)
    if value.ndim != 2 or value.shape[1] not in (3, 4):
        raise ValueError(f"a colour needs the shape (3,) or (n, 3), not {value.shape}")
    return np.maximum(value[:, :3], 0.0)


def factor(value) -> np.ndarray:
    """A weight: a number, one for each hit, (n,), or a colour for each hit, (n, 3): as (1 | n, 1 | 3), not negative."""
    value = real(value)
    return np.maximum(value if value.ndim == 2 else np.atleast_1d(value)[:, None], 0.0)


def unit(value) -> np.ndarray:
    """A number for each hit, clamped to [0, 1]."""
    return np.clip(column(value), 0.0, 1.0)


def facets(distribution: str) -> np.ndarray:
    """The field MULTISCATTER of a distribution's name."""
    return column(FACETS.get(distribution, 0.0))


def next_group() -> int:
    """A group number not used before (wraps inside the integers that float32 holds exactly)."""
    return next(_group_ids) % 1_000_000 + 1


def make(kind: int, weight, normal=None, **fields) -> list[Lobe]:
    """A list of one lobe, or none when it weighs nothing anywhere. Fields are named as in `layout`."""
    weight = factor(weight)
    if weight.shape[1] == 1:
        weight = weight * np.ones((1, 3), weight.dtype)
    if not weight.any():
        return []
    if "multiscatter" in fields:  # a mirror loses nothing between facets: spare it the tables
        fields["multiscatter"] = fields["multiscatter"] * (fields["roughness"] >= SMOOTH)
    values = {getattr(lay, name.upper()): value for name, value in fields.items()}
    if normal is not None:
        values[lay.HAS_NORMAL] = np.ones(1)
        values[lay.NORMAL] = np.atleast_2d(np.asarray(normal, np.float64))
    return [Lobe(kind, weight, values)]


def diffuse(base, roughness=0.0, normal=None, weight=1.0) -> list[Lobe]:
    """Diffuse BSDF: Lambert, or Oren-Nayar where roughness > 0."""
    base, roughness = color(base), unit(roughness)
    albedo = {"color_a": np.minimum(base, 1.0)} if roughness.any() else {}
    return make(lay.DIFFUSE, base * factor(weight), normal, roughness=roughness, **albedo)


def translucent(base, normal=None, roughness=0.0, weight=1.0) -> list[Lobe]:
    """Translucent BSDF: Lambert through the surface, or Oren-Nayar where roughness > 0."""
    base, roughness = color(base), unit(roughness)
    albedo = {"color_a": np.minimum(base, 1.0)} if roughness.any() else {}
    return make(lay.TRANSLUCENT, base * factor(weight), normal, roughness=roughness, **albedo)


def transparent(base) -> list[Lobe]:
    """Transparent BSDF: straight on, tinted."""
    return make(lay.TRANSPARENT, color(base))


def emission(base, strength=1.0) -> list[Lobe]:
    """Emission: radiance base times strength [W/m^2/sr], from both sides."""
    return make(lay.EMISSION, color(base) * factor(strength))


def holdout() -> list[Lobe]:
    """Holdout: a hole in the picture."""
    return make(lay.HOLDOUT, 1.0)


def stretched(ratio, tangent) -> dict:
    """Fields of a lobe whose facets are `ratio` times wider along the tangent (n, 3) than round ones; None: round."""
    ratio = column(ratio)
    if tangent is None or np.all(ratio == 1.0):
        return {}
    return {"anisotropy": np.where(ratio == 1.0, 0.0, ratio), "tangent": np.atleast_2d(np.asarray(tangent, np.float64))}


def glossy_ratio(anisotropy) -> np.ndarray:
    """Widths' ratio of the Glossy node: 1 - a along the tangent, or for negative values 1 / (1 + a)."""
    a = np.clip(column(anisotropy), -0.99, 0.99)
    return np.where(np.abs(a) <= 1e-4, 1.0, np.where(a < 0.0, 1.0 / (1.0 + a), 1.0 - a))


def layered_ratio(anisotropic) -> np.ndarray:
    """Widths' ratio of Principled and Metallic: 1 / sqrt(1 - 0.9 a)."""
    return 1.0 / np.sqrt(1.0 - 0.9 * unit(anisotropic))


def film(thickness, ior) -> dict:
    """Fields of facets under a film of this thickness [nm] and index; none where there is none."""
    thickness = column(thickness)
    there = thickness > THINNEST_FILM
    if not there.any():
        return {}
    return {"film": np.where(there, thickness, 0.0), "film_ior": np.maximum(column(ior), 1e-5)}


def film_over(ior, fields: dict) -> np.ndarray:
    """The index under a film: where it would bend nothing it bends hardly anything, since the film still reflects."""
    there = np.asarray(fields.get("film", 0.0)) > 0.0
    return np.where(there & (np.abs(ior - 1.0) < 2.0 * NEARLY_ONE), 1.0 + 2.0 * NEARLY_ONE, ior)


def glossy(base, roughness, normal=None, distribution=MULTI, anisotropy=0.0, tangent=None) -> list[Lobe]:
    """Glossy BSDF: a GGX mirror without Fresnel."""
    base = color(base)
    return make(
        lay.REFLECT, base, normal, roughness=unit(roughness), fresnel=column(lay.FRESNEL_NONE), ior=column(1.5),
        color_a=base, multiscatter=facets(distribution), **stretched(glossy_ratio(anisotropy), tangent),
    )  # fmt: skip


def metallic_f82(
    base, edge_tint, roughness, normal=None, distribution=MULTI, anisotropy=0.0, tangent=None, thin_film=()
) -> list[Lobe]:
    """Metallic BSDF, F82 tint."""
    return make(
        lay.REFLECT, 1.0, normal, roughness=unit(roughness), fresnel=column(lay.FRESNEL_F82), ior=column(1.5),
        color_a=np.minimum(color(base), 1.0), color_b=np.minimum(color(edge_tint), 1.0),
        multiscatter=facets(distribution), **stretched(layered_ratio(anisotropy), tangent), **dict(thin_film),
    )  # fmt: skip


def metallic_conductor(
    index, extinction, roughness, normal=None, distribution=MULTI, anisotropy=0.0, tangent=None, thin_film=()
) -> list[Lobe]:
    """Metallic BSDF, physical conductor of complex index n + ik for each channel."""
    return make(
        lay.REFLECT, 1.0, normal, roughness=unit(roughness), fresnel=column(lay.FRESNEL_CONDUCTOR), ior=column(1.5),
        color_a=color(index), color_b=color(extinction), multiscatter=facets(distribution),
        **stretched(layered_ratio(anisotropy), tangent), **dict(thin_film),
    )  # fmt: skip


def glass(base, roughness, ior, normal=None, distribution=MULTI, thin_film=()) -> list[Lobe]:
    """Glass BSDF: reflects and refracts by Fresnel, both tinted; thin_film: see `film`."""
    base, fields = color(base), dict(thin_film)
    return make(
        lay.GLASS, np.any(base > 0.0, axis=1), normal, roughness=unit(roughness),
        fresnel=column(lay.FRESNEL_DIELECTRIC), ior=film_over(np.maximum(column(ior), 1e-5), fields),
        color_a=base, color_b=base, multiscatter=facets(distribution), **fields,
    )  # fmt: skip


def refraction(base, roughness, ior, normal=None, distribution="GGX") -> list[Lobe]:
    """Refraction BSDF: refracts only; total internal reflection is black."""
    return make(
        lay.REFRACT, color(base), normal, roughness=unit(roughness), ior=np.maximum(column(ior), 1e-5),
        multiscatter=facets(distribution),
    )  # fmt: skip


def sheen(base, roughness, normal=None, weight=1.0, **layer) -> list[Lobe]:
    """Sheen BSDF, microfibre; layer: fields of a layered group."""
    tint = color(base) * factor(weight)
    return make(lay.SHEEN, tint, normal, roughness=unit(roughness), tint=np.ones((1, 3)), ior=np.ones(1), **layer)


def velvet(base, sigma, normal=None) -> list[Lobe]:
    """Sheen BSDF, Ashikhmin: velvet of width sigma."""
    return make(lay.VELVET, color(base), normal, roughness=unit(sigma))


def toon(base, size, smooth, normal=None, mirrored=False) -> list[Lobe]:
    """Toon BSDF; mirrored: its glossy component."""
    kind = lay.TOON_GLOSSY if mirrored else lay.TOON
    return make(kind, color(base), normal, roughness=unit(size), ior=unit(smooth))


def scale_lobes(lobes: list[Lobe], weight) -> list[Lobe]:
    """The lobes times a factor (see `factor`), for Mix and Add Shader; their layers stay apart."""
    share = factor(weight)
    groups: dict[float, float] = {}
    out = []
    for lobe in lobes:
        scaled = lobe.weight * share
        fields = dict(lobe.fields)
        if lay.GROUP in fields:
            old = float(fields[lay.GROUP][0])
            fields[lay.GROUP] = column(groups.setdefault(old, next_group()))
        if scaled.any():
            out.append(Lobe(lobe.kind, scaled, fields))
    return out


def principled(**inputs) -> list[Lobe]:
    """Principled BSDF; keywords as in `principled.PrincipledInputs`."""
    from .principled import principled as build

    return build(**inputs)
