"""Photons in flight, and where they were deposited."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Photons(NamedTuple):
    """Photons in flight; kernels compact them in place."""

    o: np.ndarray  # (n, 3) f32, origin of the next ray [m]
    d: np.ndarray  # (n, 3) f32, unit direction of flight
    phi: np.ndarray  # (n, 3) f32, flux [W]
    key: np.ndarray  # (n,) u64, random numbers of this path
    seen: np.ndarray  # (n,) u8, history: SEEN_SHARP, and the number of vertices D times ONE_ROUGH
    dark: np.ndarray  # (n,) f32, a surface nearer than this takes the photon without being lit (soft lamps) [m];
    # below 0: limits on the photon of a lamp without shadows, see transport/photon_rules.py
    inside: np.ndarray  # (n,) i64, bits of the absorbing media it is in; (0,) in a scene without
    lamp: np.ndarray  # (n,) i32, lamp that it comes straight from and whose nodes its flux lacks; -1: none; (0,)


class Deposits(NamedTuple):
    """Photons where they fell on a rough surface."""

    position: np.ndarray  # (n, 3) f32 [m]
    flux: np.ndarray  # (n, 3) f32 [W]
    wi: np.ndarray  # (n,) u32, packed unit vector back along the flight
    normal: np.ndarray  # (n,) u32, packed geometric normal on the side of arrival
    seen: np.ndarray  # (n,) u8, history before this hit, as in Photons


SEEN_SHARP = 1  # the path has a vertex S
ONE_ROUGH = 2  # added for each vertex D
MAX_ROUGH = 126  # more than that are not told apart


def empty_photons(n: int, media: bool = False, lamps: bool = False) -> Photons:
    """Room for n photons in flight; media: where something absorbs; lamps: where a lamp's nodes are evaluated."""
    return Photons(
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.uint64),
        np.zeros(n, np.uint8),
        np.zeros(n, np.float32),
        np.zeros(n if media else 0, np.int64),
        np.full(n if lamps else 0, -1, np.int32),
    )


def empty_deposits(n: int) -> Deposits:
    """Room for n deposits."""
    return Deposits(
        np.empty((n, 3), np.float32),
        np.empty((n, 3), np.float32),
        np.empty(n, np.uint32),
        np.empty(n, np.uint32),
        np.empty(n, np.uint8),
    )


def head(batch, n: int):
    """The first n entries of a batch, as views."""
    return type(batch)(*(field[:n] for field in batch))


def join(parts: list):
    """Batches of one kind as one, in their order; there is at least one."""
    return type(parts[0])(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))
