"""What photons do whatever they meet: which are stored, how their history grows, when they end."""

from __future__ import annotations

from ..jit import inlined
from ..photons.batch import MAX_ROUGH, ONE_ROUGH, SEEN_SHARP
from ..vec import max3, scale

CAUSTIC = 0  # store L S+ D, stop at the first D
DIFFUSE = 1  # store every D after the first D; go on
GLOBAL = 2  # store every D, for final gathering; go on

# Photons.dark of photons that a lamp without shadows sent (shadowless.py):
THROUGH = -1.0  # came through other surfaces: rough lobes alone scatter it
FIRST = -2.0  # at the first surface on its line: all lobes scatter it, but a straight pass makes it
STRAIGHT = -3.0  # on its way straight on to mirrors and glass alone


@inlined
def stores(mode, seen):
    """Whether a photon that arrives at a rough lobe with this history belongs into the map of this mode."""
    if mode == CAUSTIC:
        return seen == SEEN_SHARP
    return (mode == GLOBAL) | (seen >= ONE_ROUGH)


@inlined
def after_rough(seen):
    """A photon's history after one more vertex D."""
    return seen + ONE_ROUGH if seen // ONE_ROUGH < MAX_ROUGH else seen


@inlined
def roulette(before, after, u):
    """Russian roulette on what scattering left of a photon's flux: (whether it goes on, its flux then).

    The survivors' strongest channel keeps its flux, so photons stay about equally strong [Jensen 2001, 5.2].
    """
    survival = min(1.0, max3(after) / max3(before))
    return u < survival, scale(after, 1.0 / survival)
