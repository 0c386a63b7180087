"""Which rough lobes read a photon map, and which look one bounce further (final gather)."""

from __future__ import annotations

from ..bsdf.layout import (
    CLASS_ROUGH,
    GLASS,
    NARROW_ROUGHNESS,
    NONE,
    REFLECT,
    REFRACT,
    ROUGHNESS,
    THIN,
    TOON_GLOSSY,
)
from ..jit import kernel
from ..shading.trail import DIFFUSE, GLOSSY

ALL, WIDE, NARROW = 0, 1, 2  # of the rough lobes
REFRACTED = 4  # times more rays into rough glass than to a rough mirror: they turn twice before they meet a lamp


@kernel
def is_narrow(rows, row, k):
    """Whether lobe k of a row is a narrow microfacet lobe; refraction always is, it turns less than facets do."""
    kind = rows.kind[row, k]
    if kind == GLASS or kind == REFRACT:
        return True
    return (kind == REFLECT or kind == THIN) and rows.params[row, k, ROUGHNESS] < NARROW_ROUGHNESS


@kernel
def _keep(rows, row, scratch, narrow):
    """Zero the weights of the other kind of lobes."""
    remains = False
    for k in range(rows.kind.shape[1]):
        if rows.kind[row, k] == NONE:  # beyond it scratch holds another hit's lobes
            break
        if scratch[k, 4] != CLASS_ROUGH:
            continue
        if is_narrow(rows, row, k) == narrow:
            remains = remains or scratch[k, 3] > 0.0
        else:
            scratch[k, 0] = 0.0
            scratch[k, 1] = 0.0
            scratch[k, 2] = 0.0
            scratch[k, 3] = 0.0  # nor are they sampled
    return remains


@kernel
def keep_lobes(rows, row, scratch, lobes):
    """Silence some lobes of a prepared row: ALL, WIDE or NARROW stay; out: whether a rough lobe remains."""
    return lobes == ALL or _keep(rows, row, scratch, lobes == NARROW)


@kernel
def lobe_rays(rows, row, scratch, narrow):
    """How many rays leave a prepared row's rough lobes: one from wide ones, `narrow` or more where one is narrow.

    Narrow lobes see lamps and bright things that shadow rays and photons tell them little about. One ray a pass was
    77% of the noise of material_shelf's diffuse light, in the 3% of its pixels that show a ball of rough glass.
    """
    found = 1
    if narrow > 1:
        for k in range(rows.kind.shape[1]):
            kind = rows.kind[row, k]
            if kind == NONE:  # beyond it scratch holds another hit's lobes
                break
            if scratch[k, 4] == CLASS_ROUGH and scratch[k, 3] > 0.0 and is_narrow(rows, row, k):
                found = max(found, narrow * REFRACTED if kind == GLASS or kind == REFRACT else narrow)
    return found


def most_lobe_rays(narrow: int) -> int:
    """The most that `lobe_rays` tells."""
    return narrow * REFRACTED if narrow > 1 else 1


@kernel
def has_narrow(rows, row):
    """Whether a row has narrow lobes."""
    for k in range(rows.kind.shape[1]):
        if rows.kind[row, k] == NONE:
            return False
        if is_narrow(rows, row, k):
            return True
    return False


@kernel
def rough_kind(kinds, scratch):
    """DIFFUSE or GLOSSY of shading/trail.py: which of a prepared row's rough lobes weigh more; kinds (K,) i32."""
    matte, facets = 0.0, 0.0
    for k in range(len(kinds)):
        if kinds[k] == NONE:  # beyond it scratch holds another hit's lobes
            break
        if scratch[k, 4] != CLASS_ROUGH:
            continue
        if REFLECT <= kinds[k] <= THIN or kinds[k] == TOON_GLOSSY:
            facets += scratch[k, 3]
        else:
            matte += scratch[k, 3]
    return DIFFUSE if matte >= facets else GLOSSY
