"""Random numbers: no two decisions of a path read the same one, and no path has the key of another."""

import dataclasses
from itertools import combinations

import pytest

from ...sampling.rng import DIMENSIONS_PER_BOUNCE
from ...settings import Settings
from ..camera_kernels import FURTHER, ROUND
from ..deep_kernels import END, LANDED, WALK_KEYS
from ..direct_kernels import LOBE_RAY
from ..eye_batch import DIRECT_DIMENSION, SECOND_DIMENSION
from ..eye_kernels import first_dimension
from ..eye_pass import MOST_LIT
from ..lobes import most_lobe_rays
from ..second_kernels import GENERATION
from ..walk_kernels import FIRST, MOST_LEGS, PER_LEG

LIMITS = {field.name: field.metadata for field in dataclasses.fields(Settings)}
BOUNCES = LIMITS["max_bounces"]["max"]
SECONDS = {SECOND_DIMENSION + (bounce + 1) * DIMENSIONS_PER_BOUNCE + k for bounce in range(BOUNCES) for k in range(4)}
POINT = {first + k for first in (DIRECT_DIMENSION, SECOND_DIMENSION) for k in range(3)}
EYE = [first_dimension(bounce) for bounce in range(BOUNCES)]
WALK = set(range(END + 1)) | {FIRST + PER_LEG * leg + k for leg in range(MOST_LEGS) for k in range(7)}


@pytest.mark.parametrize("own", [{first + k for first in EYE for k in range(4)}, WALK], ids=["eye path", "walk"])
def test_decisions_of_a_path_read_numbers_of_their_own(own):
    """An eye path, or a walk below a surface, the visible point where it ends, and the first ray from there."""
    assert len(EYE) == len(set(EYE)) and len(WALK) == END + 1 + 7 * MOST_LEGS
    assert not own & POINT and not own & SECONDS and not POINT & SECONDS


def test_paths_that_come_of_one_key_have_keys_of_their_own():
    """Numbers that `path_key` mixes into a path's key; forks take the first ones, two a lobe."""
    taken = {
        "forks": range(1, 1024),
        "further paths to lamps": range(FURTHER, FURTHER + (1 << 20)),
        "landings": range(GENERATION, GENERATION + MOST_LIT + 1),
        "lobe rays": range(LOBE_RAY, LOBE_RAY + most_lobe_rays(LIMITS["light_samples"]["max"])),
        "a pixel's other paths": range(ROUND, ROUND + LIMITS["eye_samples"]["max"]),
        "walks": range(WALK_KEYS, WALK_KEYS + BOUNCES),
        "walks from landings": range(WALK_KEYS + LANDED, WALK_KEYS + LANDED + BOUNCES),
    }
    for (a, first), (b, second) in combinations(taken.items(), 2):
        assert first[-1] < second[0] or second[-1] < first[0], (a, b)
