"""The lobes that are neither matte nor facets: SHEEN, VELVET, TOON, TOON_GLOSSY. Values are for unit weight.

Their f is not the same from both sides; photons (adjoint) see it with the way they go as the view. They sample the
cosine, since the cones of eye paths do not cover what a photon may do.
"""

from __future__ import annotations

from ..jit import kernel
from ..vec import dot
from .diffuse import INV_PI, sample_cosine
from .layout import ROUGHNESS, SHEEN, TOON, TOON_GLOSSY
from .reflect import BLACK
from .sheen import cloth_value, sheen_direction
from .toon import toon_direction, toon_value


@kernel
def eval_odd(rows, row, k, n, wo, wi, adjoint):
    """(f rgb without cosine [1/sr], pdf_w of `sample_odd`); n on the side of wo."""
    kind = rows.kind[row, k]
    cos = dot(n, wi)
    if cos <= 0.0 or dot(n, wo) <= 0.0:
        return BLACK, 0.0
    view, light = (wi, wo) if adjoint else (wo, wi)
    pdf = cos * INV_PI
    if kind == TOON or kind == TOON_GLOSSY:
        f, cone = toon_value(rows, row, k, n, view, light)
        if kind == TOON_GLOSSY or not adjoint:
            pdf = cone
    else:
        f = cloth_value(rows, row, k, n, view, light)
        if kind == SHEEN and not adjoint:
            pdf = cos * f
    return (f, f, f), pdf


@kernel
def sample_odd(rows, row, k, n, ng, wo, u, adjoint):
    """Direction of an odd lobe: (ok, wi, f cos / pdf rgb, pdf_w); n, ng on the side of wo, u[1], u[2] are used."""
    if dot(n, wo) <= 0.0:
        return False, wo, BLACK, 0.0
    kind = rows.kind[row, k]
    if kind == TOON_GLOSSY or (kind == TOON and not adjoint):
        wi = toon_direction(rows, row, k, n, wo, u[1], u[2])
    elif kind == SHEEN and not adjoint:
        wi = sheen_direction(float(rows.params[row, k, ROUGHNESS]), n, wo, u[1], u[2])
    else:
        wi = sample_cosine(n, u[1], u[2])
    if dot(ng, wi) <= 0.0:
        return False, wi, BLACK, 0.0
    f, pdf = eval_odd(rows, row, k, n, wo, wi, adjoint)
    if pdf <= 0.0:
        return False, wi, BLACK, 0.0
    s = f[0] * dot(n, wi) / pdf
    return True, wi, (s, s, s), pdf
