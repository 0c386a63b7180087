"""Blender's Principled BSDF as a list of lobes: alpha, sheen, coat, emission, metal, transmission, specular, diffuse.

Sheen, coat and specular are layers (`layout.LAYER`): what they reflect, as seen from the eye, is taken from what
follows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import layout as lay
from .layout import Lobe
from .microfacet import DELTA_ALPHA
from .recipes import (
    MULTI,
    color,
    column,
    diffuse,
    emission,
    film,
    film_over,
    layered_ratio,
    make,
    next_group,
    sheen,
    stretched,
    translucent,
    unit,
)
from .sheet import sheet_width
from .subsurface import Flesh, subsurface

CUTOFF = 1e-5  # weights below this count as absent
MAX_F0 = 0.99


@dataclass
class PrincipledInputs:
    """Inputs of the node, each one value or one for each hit, as in `recipes`; defaults are Blender's."""

    base_color: Any = 0.8
    metallic: Any = 0.0
    roughness: Any = 0.5
    ior: Any = 1.5
    alpha: Any = 1.0
    normal: Any = None
    diffuse_roughness: Any = 0.0
    specular_ior_level: Any = 0.5
    specular_tint: Any = 1.0
    anisotropic: Any = 0.0
    tangent: Any = None
    transmission_weight: Any = 0.0
    sheen_weight: Any = 0.0
    sheen_roughness: Any = 0.5
    sheen_tint: Any = 1.0
    coat_weight: Any = 0.0
    coat_roughness: Any = 0.03
    coat_ior: Any = 1.5
    coat_tint: Any = 1.0
    coat_normal: Any = None
    emission_color: Any = 1.0
    emission_strength: Any = 0.0
    subsurface_weight: Any = 0.0
    subsurface_radius: Any = (1.0, 0.2, 0.1)
    subsurface_scale: Any = 0.005
    subsurface_ior: Any = 1.4
    subsurface_anisotropy: Any = 0.0
    subsurface_method: str = "RANDOM_WALK"
    thin_film_thickness: Any = 0.0
    thin_film_ior: Any = 1.33
    thin_wall: Any = 0.0
    distribution: str = MULTI


def principled(**inputs: Any) -> list[Lobe]:
    """Lobes of a Principled BSDF; the keywords are the fields of `PrincipledInputs`."""
    node = PrincipledInputs(**inputs)
    group = column(next_group())
    alpha = unit(node.alpha)
    weight = alpha.copy()
    lobes = make(lay.TRANSPARENT, 1.0 - alpha)
    lobes += fibres(node, weight, group)
    lobes += coat(node, weight, group)
    lobes += grouped(emission(color(node.emission_color) * weight[:, None], node.emission_strength), group)
    metallic = floor(unit(node.metallic))
    lobes += metal(node, weight * metallic, group)
    weight = weight * (1.0 - metallic)
    transmission = floor(unit(node.transmission_weight))
    wall = column(node.thin_wall) != 0.0
    lobes += transmitted(node, weight * transmission * ~wall, group)
    lobes += walled(node, weight * transmission * wall, group)
    weight = weight * (1.0 - transmission)
    lobes += specular(node, weight, group)
    spread = floor(unit(node.subsurface_weight))
    lobes += grouped(spread_thin(node, weight * spread * wall), group)
    lobes += grouped(below(node, weight * spread * ~wall), group)
    base = diffuse(node.base_color, node.diffuse_roughness, node.normal, weight * (1.0 - spread))
    return lobes + grouped(base, group)


def floor(value: np.ndarray) -> np.ndarray:
    """The value, 0 where it is below the cutoff."""
    return np.where(value > CUTOFF, value, 0.0)


def grouped(lobes: list[Lobe], group: np.ndarray) -> list[Lobe]:
    """The lobes as members of a layered group."""
    return [Lobe(lobe.kind, lobe.weight, {**lobe.fields, lay.GROUP: group}) for lobe in lobes]


def fibres(node: PrincipledInputs, weight: np.ndarray, group: np.ndarray) -> list[Lobe]:
    """The sheen over everything but alpha, about the base's normal."""
    tint = color(node.sheen_tint) * floor(np.maximum(column(node.sheen_weight), 0.0))[:, None]
    return sheen(tint, node.sheen_roughness, node.normal, weight, group=group, layer=tint.max(axis=1))


def coat(node: PrincipledInputs, weight: np.ndarray, group: np.ndarray) -> list[Lobe]:
    """The clear coat: a dielectric mirror over everything but alpha.

    Its normal is the surface's, not the base's, unless given; energy is kept whatever the distribution, as in Blender.
    """
    cover = floor(np.maximum(column(node.coat_weight), 0.0))
    return make(
        lay.REFLECT, weight * cover, node.coat_normal,
        roughness=unit(node.coat_roughness), fresnel=column(lay.FRESNEL_DIELECTRIC),
        ior=np.maximum(column(node.coat_ior), 1.0), multiscatter=np.ones(1), group=group,
        layer=cover, tint=color(node.coat_tint),
    )  # fmt: skip


def metal(node: PrincipledInputs, weight: np.ndarray, group: np.ndarray) -> list[Lobe]:
    """The metallic part: F82-tint of base colour and specular tint."""
    return make(
        lay.REFLECT, weight, node.normal, roughness=unit(node.roughness), fresnel=column(lay.FRESNEL_F82),
        ior=column(1.5), color_a=np.minimum(color(node.base_color), 1.0),
        color_b=np.minimum(color(node.specular_tint), 1.0), multiscatter=column(node.distribution == MULTI),
        group=group, **stretched(layered_ratio(node.anisotropic), node.tangent), **coating(node),
    )  # fmt: skip


def coating(node: PrincipledInputs) -> dict:
    """Fields of the thin film."""
    return film(node.thin_film_thickness, node.thin_film_ior)


def transmitted(node: PrincipledInputs, weight: np.ndarray, group: np.ndarray) -> list[Lobe]:
    """The glassy part: tinted F0, and the root of the base colour at each crossing."""
    fields = coating(node)
    ior = film_over(np.maximum(column(node.ior), 1e-5), fields)
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2
    return make(
        lay.GLASS, weight, node.normal, roughness=unit(node.roughness), fresnel=column(lay.FRESNEL_GENERALIZED),
        ior=ior, color_a=np.minimum(color(node.specular_tint) * f0[:, None], 1.0),
        color_b=np.sqrt(np.minimum(color(node.base_color), 1.0)), multiscatter=column(node.distribution == MULTI),
        group=group, **fields,
    )  # fmt: skip


def walled(node: PrincipledInputs, weight: np.ndarray, group: np.ndarray) -> list[Lobe]:
    """The glassy part of a thin wall: a mirror, and what passes unbent, smooth or blurred by two refractions."""
    ior = np.maximum(column(node.ior), 1e-5)
    alpha = unit(node.roughness) ** 2
    width = sheet_width(alpha, ior)
    smooth = width <= DELTA_ALPHA
    fields = {
        "fresnel": column(lay.FRESNEL_SHEET), "ior": ior, "color_a": np.minimum(color(node.specular_tint), 1.0),
        "color_b": np.minimum(color(node.base_color), 1.0), "multiscatter": np.ones(1), "group": group, **coating(node),
    }  # fmt: skip
    lobes = make(lay.REFLECT, weight, node.normal, roughness=unit(node.roughness), **fields)
    lobes += make(lay.THIN, weight * ~smooth, node.normal, roughness=np.sqrt(width), **fields)
    return lobes + make(lay.TRANSPARENT, weight * smooth, node.normal, roughness=np.zeros(1), **fields)


def spread_thin(node: PrincipledInputs, weight: np.ndarray) -> list[Lobe]:
    """Subsurface scattering of a thin wall: diffuse on both sides, shared by the anisotropy."""
    ahead = unit(0.5 * (1.0 + column(node.subsurface_anisotropy)))
    color_here, rough = np.minimum(color(node.base_color), 1.0), node.diffuse_roughness
    behind = diffuse(color_here, rough, node.normal, weight * (1.0 - ahead))
    return behind + translucent(color_here, node.normal, rough, weight * ahead)


def below(node: PrincipledInputs, weight: np.ndarray) -> list[Lobe]:
    """Subsurface scattering of a body. Only the law for skin has an index of its own."""
    skin = node.subsurface_method == "RANDOM_WALK_SKIN"
    flesh = Flesh(
        color(node.subsurface_radius) * np.maximum(column(node.subsurface_scale), 0.0)[:, None],
        node.subsurface_ior if skin else specular_index(node)[0], unit(node.roughness) ** 2,
        node.subsurface_anisotropy, node.subsurface_method,
    )  # fmt: skip
    return subsurface(np.minimum(color(node.base_color), 1.0), flesh, node.normal, weight) if weight.any() else []


def specular_index(node: PrincipledInputs) -> tuple[np.ndarray, np.ndarray]:
    """(eta, F0) of the specular layer: the level scales F0 (0.5: as the index says) and bends the index to it."""
    ior = np.maximum(column(node.ior), 1e-5)
    level = np.maximum(column(node.specular_ior_level), 0.0)
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2 * 2.0 * level
    root = np.sqrt(np.clip(f0, 0.0, MAX_F0))
    bent = (1.0 + root) / (1.0 - root)
    return np.where(level == 0.5, ior, np.where(ior < 1.0, 1.0 / bent, bent)), f0


def specular(node: PrincipledInputs, weight: np.ndarray, group: np.ndarray) -> list[Lobe]:
    """The dielectric specular layer over the diffuse base."""
    eta, f0 = specular_index(node)
    fields = coating(node)
    here = ((eta != 1.0) | (np.asarray(fields.get("film", 0.0)) > 0.0)).astype(float)
    return make(
        lay.REFLECT, weight * here, node.normal, roughness=unit(node.roughness),
        fresnel=column(lay.FRESNEL_GENERALIZED), ior=film_over(eta, fields),
        color_a=np.minimum(color(node.specular_tint) * f0[:, None], 1.0),
        color_b=np.ones((1, 3)), multiscatter=column(node.distribution == MULTI), group=group, layer=here,
        **stretched(layered_ratio(node.anisotropic), node.tangent), **fields,
        tint=np.ones((1, 3)),
    )  # fmt: skip
