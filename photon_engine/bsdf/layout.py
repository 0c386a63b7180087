"""How scattering is handed to the kernels: rows of lobes.

Every hit names a *row*; a row holds up to K lobes. A material without textures has one row for all its hits; a
textured one gets a fresh row per hit. A lobe is a kind and N_FIELDS numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# kinds
NONE = 0
DIFFUSE = 1  # Lambert, or Oren-Nayar when roughness > 0
TRANSLUCENT = 2  # Lambert through the surface
REFLECT = 3  # GGX reflection (glossy, metal, coat, dielectric specular), see the Fresnel modes
GLASS = 4  # GGX dielectric: reflects and refracts
REFRACT = 5  # GGX refraction only
THIN = 6  # GGX mirror to the other side: what passes a thin wall; FRESNEL_SHEET
TRANSPARENT = 7  # straight through: no vertex of the path ("null"); FRESNEL_SHEET: a smooth thin wall's share
EMISSION = 8  # radiates `weight`, both sides
HOLDOUT = 9
ABSORPTION = 10  # of the inside of a volume; never in a row
SHEEN = 11  # a layer of fibres, its albedo times the weight
VELVET = 12  # Ashikhmin's
TOON = 13  # an even cone about the normal: ROUGHNESS is its size, IOR the width of its rim, both of 90 degrees
TOON_GLOSSY = 14  # the same about the mirrored view
SUBSURFACE = 15  # a random walk below the surface: COLOR_A = albedo, COLOR_B = free path [m], ANISOTROPY = mean cosine

# laws of SUBSURFACE, in FRESNEL
WALK = 0  # entry by refraction, scattering albedo by d'Eon's inversion
WALK_LEGACY = 1  # by Chiang's
WALK_SKIN = 2  # by Chiang's, half of the entries diffuse

# Fresnel modes of REFLECT and GLASS
FRESNEL_NONE = 0  # 1 (Glossy BSDF: weight is the colour; COLOR_A = colour too, for MULTISCATTER)
FRESNEL_DIELECTRIC = 1  # unpolarised Fresnel of IOR
FRESNEL_F82 = 2  # metal: COLOR_A = F0, COLOR_B = tint at 82 degrees
FRESNEL_GENERALIZED = 3  # dielectric shape between COLOR_A = F0 and COLOR_B = F90, normalised by IOR
FRESNEL_CONDUCTOR = 4  # metal of index n + ik: COLOR_A = n, COLOR_B = k
FRESNEL_SHEET = 5  # a thin wall as a whole, by the view (sheet.py): COLOR_A = tint of F0, COLOR_B of what passes

# fields
WEIGHT = 0  # 3: colour times mixing weight
ROUGHNESS = 3  # Blender's, unsquared; SUBSURFACE: the GGX width of the entry
ANISOTROPY = 4  # REFLECT: A > 0: GGX widths roughness^2 A along TANGENT and roughness^2 / A across; 0: round
IOR = 5  # of the inside over the outside (for GLASS and REFRACT a back face inverts it)
FRESNEL = 6  # a mode
COLOR_A = 7  # 3; DIFFUSE and TRANSLUCENT with roughness: the albedo
COLOR_B = 10  # 3; GLASS: transmission tint, with COLOR_A the reflection tint (GENERALIZED: F0; F90 is 1)
HAS_NORMAL = 13  # 1: NORMAL replaces the surface's shading normal; DISPLACED: it is what the surface's has become
NORMAL = 14  # 3: unit, world, on the side of the geometric normal
GROUP = 17  # lobes of the same group > 0 are layered: see LAYER
LAYER = 18  # > 0: share covered (coat weight; specular: 1); later lobes of the group get what its albedo leaves
MULTISCATTER = 19  # 1: energy lost between microfacets is given back (Multiscatter GGX); or another shape of facets:
TINT = 20  # 3: coat tint: what passes under this layer is multiplied by TINT^(1/cos in the coat)
FILM = 23  # thickness of a film on the facets [nm], 0: none; of GLASS, SHEET, metals and GENERALIZED mirrors
TANGENT = 24  # 3: world, any length, with ANISOTROPY
FILM_IOR = 27  # of the film
N_FIELDS = 28
DISPLACED = 2.0  # value of HAS_NORMAL
BECKMANN = 2.0  # values of MULTISCATTER: facets that are not GGX's; REFLECT, and Beckmann's also GLASS and REFRACT
ASHIKHMIN = 3.0

# classes of a lobe, deciding the pass a path belongs to
CLASS_NULL = 0  # goes straight through
CLASS_SHARP = 1  # S: delta or near-delta
CLASS_ROUGH = 2  # D
CLASS_DEEP = 3  # D as well, but light leaves elsewhere than it came in: no sampler of lobes draws it (deep.py)

# below this roughness a rough lobe is so narrow that few photons of a map arrive from where it looks
NARROW_ROUGHNESS = 0.5


class LobeRows(NamedTuple):
    """Rows of lobes, as the kernels read them."""

    kind: np.ndarray  # (R, K) i32
    params: np.ndarray  # (R, K, N_FIELDS) f32


class Lobe(NamedTuple):
    """One lobe of a batch of hits before packing: field offset -> array broadcastable to (n,) or (n, 3)."""

    kind: int
    weight: np.ndarray  # (n | 1, 3)
    fields: dict[int, np.ndarray]  # (n | 1,) or (n | 1, 3)


def pack(lobes: list[Lobe], n: int, slots: int) -> LobeRows:
    """Rows for n hits from a material's lobes; lobes beyond the list are NONE.

    lobes : at most `slots` of them;  out : LobeRows with R = n, K = slots.
    """
    kind = np.zeros((n, slots), np.int32)
    params = np.zeros((n, slots, N_FIELDS), np.float32)
    for k, lobe in enumerate(lobes):
        kind[:, k] = lobe.kind
        params[:, k, WEIGHT : WEIGHT + 3] = lobe.weight
        for offset, value in lobe.fields.items():
            value = np.asarray(value)
            if value.ndim == 2:
                params[:, k, offset : offset + value.shape[1]] = value
            else:
                params[:, k, offset] = value
    return LobeRows(kind, params)
