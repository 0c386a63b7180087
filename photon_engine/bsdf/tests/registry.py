"""Every lobe and recipe, for tests that run over all of them."""

from __future__ import annotations

import math

import numpy as np

from .. import recipes
from ..layout import LobeRows, pack

TINT = [0.9, 0.5, 0.2]
NORMAL = np.array([[0.2, -0.1, math.sqrt(1.0 - 0.05)]])

# materials with rough lobes, through which light goes only where the name says glass, refraction or translucent
ROUGH = {
    "lambert": lambda: recipes.diffuse(TINT),
    "oren_nayar": lambda: recipes.diffuse(TINT, 0.7),
    "bumped": lambda: recipes.diffuse(TINT, 0.0, NORMAL),
    "translucent": lambda: recipes.translucent(TINT),
    "glossy": lambda: recipes.glossy(TINT, 0.3, distribution="GGX"),
    "glossy_multi": lambda: recipes.glossy(TINT, 0.8),
    "glossy_bumped": lambda: recipes.glossy(TINT, 0.5, NORMAL),
    "f82": lambda: recipes.metallic_f82(TINT, [0.4, 0.7, 1.0], 0.4),
    "gold": lambda: recipes.metallic_conductor([0.18, 0.42, 1.37], [3.42, 2.35, 1.77], 0.4),
    "glass": lambda: recipes.glass(TINT, 0.4, 1.5, distribution="GGX"),
    "glass_multi": lambda: recipes.glass(TINT, 0.7, 1.5),
    "glossy_beckmann": lambda: recipes.glossy(TINT, 0.6, distribution="BECKMANN"),
    "glossy_ashikhmin": lambda: recipes.glossy(TINT, 0.6, distribution="ASHIKHMIN_SHIRLEY"),
    "beckmann_stretched": lambda: recipes.glossy(
        TINT, 0.5, distribution="BECKMANN", anisotropy=0.4, tangent=np.array([[0.8, 0.6, 0.1]])
    ),
    "ashikhmin_stretched": lambda: recipes.glossy(
        TINT, 0.6, distribution="ASHIKHMIN_SHIRLEY", anisotropy=-0.3, tangent=np.array([[0.8, 0.6, 0.1]])
    ),
    "glass_beckmann": lambda: recipes.glass(TINT, 0.5, 1.5, distribution="BECKMANN"),
    "refraction_beckmann": lambda: recipes.refraction(TINT, 0.5, 1.4, distribution="BECKMANN"),
    "glass_water": lambda: recipes.glass(TINT, 0.5, 0.75, distribution="GGX"),
    "refraction": lambda: recipes.refraction(TINT, 0.5, 1.33),
    "principled": lambda: recipes.principled(base_color=TINT),
    "principled_coat": lambda: recipes.principled(
        base_color=TINT, coat_weight=0.8, coat_tint=TINT, coat_roughness=0.3, metallic=0.4, diffuse_roughness=0.5
    ),
    "principled_glass": lambda: recipes.principled(base_color=TINT, transmission_weight=0.6, roughness=0.4),
    "glossy_stretched": lambda: recipes.glossy(
        TINT, 0.5, distribution="GGX", anisotropy=0.6, tangent=np.array([[0.8, 0.6, 0.1]])
    ),
    "metal_stretched": lambda: recipes.metallic_f82(
        TINT, 1.0, 0.5, anisotropy=0.9, tangent=np.array([[0.0, 1.0, 0.0]])
    ),
    "sheen": lambda: recipes.sheen(TINT, 0.5),
    "velvet": lambda: recipes.velvet(TINT, 0.5),
    "toon": lambda: recipes.toon(TINT, 0.4, 0.3),
    "toon_glossy": lambda: recipes.toon(TINT, 0.3, 0.2, mirrored=True),
    "principled_sheen": lambda: recipes.principled(
        base_color=TINT,
        sheen_weight=0.8,
        sheen_roughness=0.4,
        sheen_tint=[0.5, 0.8, 1.0],
        coat_weight=0.3,
        coat_roughness=0.2,
    ),
    "glass_film": lambda: recipes.glass(TINT, 0.4, 1.5, distribution="GGX", thin_film=recipes.film(400.0, 1.8)),
    "metal_film": lambda: recipes.metallic_f82(TINT, [0.4, 0.7, 1.0], 0.4, thin_film=recipes.film(350.0, 1.5)),
    "gold_film": lambda: recipes.metallic_conductor(
        [0.18, 0.42, 1.37], [3.42, 2.35, 1.77], 0.4, thin_film=recipes.film(500.0, 1.33)
    ),
    "principled_film": lambda: recipes.principled(base_color=TINT, thin_film_thickness=300.0, thin_film_ior=1.4),
    "glass_wall": lambda: recipes.principled(
        base_color=TINT, transmission_weight=0.7, roughness=0.6, thin_wall=True, thin_film_thickness=300.0
    ),
    "translucent_wall": lambda: recipes.principled(
        base_color=TINT, subsurface_weight=0.8, subsurface_anisotropy=0.3, thin_wall=True, diffuse_roughness=0.7
    ),
    "mixed": lambda: (
        recipes.scale_lobes(recipes.principled(coat_weight=1.0, coat_roughness=0.2), 0.4)
        + recipes.scale_lobes(recipes.glass(TINT, 0.3, 1.4), 0.6)
    ),
}
SHARP = {
    "mirror": lambda: recipes.glossy(TINT, 0.0),
    "near_mirror": lambda: recipes.glossy(TINT, 0.04),
    "smooth_glass": lambda: recipes.glass(TINT, 0.0, 1.5),
    "near_smooth_glass": lambda: recipes.glass(TINT, 0.04, 1.5),
    "smooth_refraction": lambda: recipes.refraction(TINT, 0.0, 1.5),
    "nothing_bent": lambda: recipes.glass(TINT, 0.5, 1.0),
    "smooth_coat": lambda: recipes.principled(base_color=TINT, coat_weight=1.0, coat_tint=TINT, roughness=0.0),
}
# materials that absorb nothing where facets lose nothing
WHITE = {
    "lambert": lambda: recipes.diffuse(1.0),
    "oren_nayar": lambda: recipes.diffuse(1.0, 1.0),
    "mirror": lambda: recipes.glossy(1.0, 0.0),
    "glossy_multi": lambda: recipes.glossy(1.0, 0.6),
    "smooth_glass": lambda: recipes.glass(1.0, 0.0, 1.5),
    "glass_multi": lambda: recipes.glass(1.0, 0.5, 1.5),
    "f82": lambda: recipes.metallic_f82(1.0, 1.0, 0.6),
}


def rows_of(lobes) -> LobeRows:
    """One row, with a free slot behind the lobes."""
    return pack(lobes, 1, len(lobes) + 1)


def direction(mu: float, phi: float = 0.3) -> np.ndarray:
    """Unit vector at the cosine mu to z."""
    s = math.sqrt(1.0 - mu * mu)
    return np.array([s * math.cos(phi), s * math.sin(phi), mu])


def frames(n: int, wo, ns=(0.0, 0.0, 1.0), ng=(0.0, 0.0, 1.0)):
    """(ns, ng, wo) repeated n times."""
    return tuple(np.tile(np.asarray(v, np.float64), (n, 1)) for v in (ns, ng, wo))


def zeros(n: int) -> np.ndarray:
    """Row numbers of n hits that share the first row."""
    return np.zeros(n, np.int64)
