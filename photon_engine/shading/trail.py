"""What a path did before it came to a surface, as one integer: what the Light Path node tells.

Cycles' rules [kernel/integrator/path_state.h]: a straight pass through transparency is counted and changes nothing
else; a reflection or a refraction puts the flags of its lobe in the place of all that were there.
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel

# flags
CAMERA, DIFFUSE, GLOSSY, SINGULAR, REFLECTION, TRANSMISSION = 1, 2, 4, 8, 16, 32
FLAGS = 255
# counts of eight bits each
DEPTH, DIFFUSE_DEPTH, GLOSSY_DEPTH, TRANSMISSION_DEPTH, TRANSPARENT_DEPTH = 8, 16, 24, 32, 40
MOST = 255
# a photon answers as the ray of an eye path that would bring its light the other way, from the matte surface where it
# will be seen: photons are kept on no other
PHOTON = DIFFUSE | REFLECTION | 1 << DEPTH | 1 << DIFFUSE_DEPTH
# light that is sampled, and shadow rays: Cycles counts one bounce more and sets no flag
FROM_LIGHT = 1 << DEPTH


@kernel
def count(trail, shift):
    """The trail with one more of a count, which stays at MOST."""
    return trail + (1 << shift) if (trail >> shift) & MOST < MOST else trail


@kernel
def passed(trail):
    """After a straight pass through a transparent surface."""
    return count(trail, TRANSPARENT_DEPTH)


@kernel
def bounced(trail, kind, reflected):
    """After a lobe of this kind (DIFFUSE, GLOSSY, or GLOSSY | SINGULAR) reflected the path or let it through."""
    trail = count((trail >> DEPTH) << DEPTH, DEPTH)
    if not reflected:
        return count(trail, TRANSMISSION_DEPTH) | kind | TRANSMISSION
    return count(trail, DIFFUSE_DEPTH if kind == DIFFUSE else GLOSSY_DEPTH) | kind | REFLECTION


def no_trails(n: int, wanted: bool) -> np.ndarray:
    """Room for the trails of n paths; none where no material asks for them."""
    return np.full(n if wanted else 0, CAMERA, np.int64)
