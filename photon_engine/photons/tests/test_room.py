"""Joined batches in memory that is used again."""

import numpy as np

from ..batch import empty_deposits, join
from ..room import Room


def batches(sizes, seed):
    """Deposits of random numbers."""
    rng = np.random.default_rng(seed)
    out = [empty_deposits(n) for n in sizes]
    for batch in out:
        for field in batch:
            field[:] = rng.integers(0, 200, field.shape)
    return out


def test_batches_are_joined_as_in_fresh_memory_and_memory_is_kept():
    room = Room()
    first = room.join(batches([5, 0, 7], 1))
    address = first.position.ctypes.data
    for sizes in ([12], [3, 2], [0]):
        parts = batches(sizes, len(sizes))
        joined = room.join(parts)
        assert joined.position.ctypes.data == address
        for mine, fresh in zip(joined, join(parts), strict=True):
            np.testing.assert_array_equal(mine, fresh)
            assert mine.dtype == fresh.dtype
    parts = batches([40, 41], 3)
    for mine, fresh in zip(room.join(parts), join(parts), strict=True):
        np.testing.assert_array_equal(mine, fresh)


def test_parts_are_appended_behind_what_was_joined():
    room, all_parts = Room(), []
    for k, sizes in enumerate(([0], [3, 2], [1], [50, 0], [4])):
        parts = batches(sizes, k)
        all_parts += parts
        joined = room.append(parts) if k else room.join(parts)
        for mine, fresh in zip(joined, join(all_parts), strict=True):
            np.testing.assert_array_equal(mine, fresh)
            assert mine.dtype == fresh.dtype
    assert len(room.join(batches([2], 9)).wi) == 2, "joining starts anew"
