"""Hits in blocks equal their laws one by one; chunks and spans of bounces leave nothing out."""

import numpy as np
import pytest

from ...bsdf.layout import (
    CLASS_SHARP,
    COLOR_A,
    COLOR_B,
    FRESNEL,
    FRESNEL_DIELECTRIC,
    FRESNEL_F82,
    FRESNEL_NONE,
    GLASS,
    IOR,
    MULTISCATTER,
    REFLECT,
    LobeRows,
)
from ...bsdf.layout import DIFFUSE as MATTE
from ...bsdf.matte import sample_lambert
from ...bsdf.surface import prepare_any, sample_any
from ...geometry.flatten import Geometry
from ...geometry.surface import leave, surface_point
from ...photons.batch import ONE_ROUGH, SEEN_SHARP, empty_deposits, empty_photons
from ...photons.packing import pack_direction, pack_facet
from ...sampling.rng import DIMENSIONS_PER_BOUNCE, uniform
from ..lamp_nodes import NO_GAIN
from ..matte_kernels import LANES, empty_lanes
from ..media import Media, no_media
from ..photon_kernels import ABSORBED, ESCAPED, Laws, Leg, Surfaces, deep_lists, photon_step
from ..photon_pass import CHUNK, FEW, LEAST, SMALL, deal, generations
from ..photon_rules import CAUSTIC, DIFFUSE, GLOBAL, stores

N = 3 * LANES + 5
BOUNCE = 3
COLOR = np.array([0.7, 0.5, 0.2], np.float32)
MAX_ROUGH = 3


def batch(seed: int = 1):
    """Photons that meet random triangles, half of them smooth, a fifth of them nothing, one too near to its lamp."""
    rng = np.random.default_rng(seed)
    triangles = np.arange(3 * N, dtype=np.int32).reshape(N, 3)
    positions = rng.normal(size=(3 * N, 3)).astype(np.float32)
    corner = positions.reshape(N, 3, 3)
    ng = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    ng /= np.linalg.norm(ng, axis=1, keepdims=True)
    normals = (ng[:, None] + 0.3 * rng.normal(size=(N, 3, 3))).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    zero = np.zeros(N, np.int32)
    row_of_normal = np.where(np.arange(N) % 2, np.arange(N), -1).astype(np.int32)
    geometry = Geometry(positions, triangles, row_of_normal, normals, zero, zero)
    rows = LobeRows(np.zeros((1, 2), np.int32), np.zeros((1, 2, 40), np.float32))
    rows.kind[0, 0] = MATTE
    rows.params[0, 0, :3] = COLOR
    prim = np.where(rng.random(N) < 0.2, -1, np.arange(N)).astype(np.int32)
    uv = (0.5 * rng.random((2, N))).astype(np.float32)
    surfaces = Surfaces(geometry, rows, zero, prim, uv[0], uv[1], np.ones(N, np.float32), np.empty((2, 8)))
    photons = empty_photons(N)
    photons.o[:] = 0.0
    d = rng.normal(size=(N, 3))
    photons.d[:] = d / np.linalg.norm(d, axis=1, keepdims=True)
    photons.phi[:] = rng.random((N, 3)) + 0.1
    photons.key[:] = rng.integers(0, 2**63, N, dtype=np.uint64)
    photons.seen[:] = rng.choice([0, SEEN_SHARP, ONE_ROUGH, ONE_ROUGH + SEEN_SHARP, MAX_ROUGH * ONE_ROUGH], N)
    photons.dark[np.flatnonzero(prim >= 0)[0]] = 2.0
    return surfaces, photons


def one_by_one(surfaces, photons, mode: int):
    """The law, photon by photon: deposits [(position, flux, wi, normal)], survivors [(key, o, d, phi, seen)]."""
    deposits, survivors = [], []
    for i in range(N):
        if surfaces.prim[i] < 0 or surfaces.t[i] < photons.dark[i]:
            continue
        p, ng, ns = surface_point(surfaces.geometry, surfaces.prim[i], float(surfaces.u[i]), float(surfaces.v[i]))
        phi, wo = photons.phi[i].astype(float), tuple(-photons.d[i].astype(float))
        seen, key = int(photons.seen[i]), photons.key[i]
        if stores(mode, seen):
            front = np.dot(ng, wo) >= 0.0
            instance = int(surfaces.geometry.instance[surfaces.prim[i]])
            facet = pack_facet(ng if front else tuple(-np.array(ng)), front, instance)
            deposits.append((p, phi, pack_direction(wo), facet))
        if mode == CAUSTIC or seen // ONE_ROUGH >= MAX_ROUGH:
            continue
        u = [uniform(key, (BOUNCE + 1) * DIMENSIONS_PER_BOUNCE + k) for k in range(4)]
        ok, wi, weight, _, _ = sample_lambert(ns, ng, wo, tuple(COLOR.astype(float)), (u[0], u[1], u[2]), 1)
        out = phi * weight
        survival = min(1.0, out.max() / phi.max())
        if ok and u[3] < survival:
            o = leave(surfaces.geometry, surfaces.prim[i], p, ng, wi)
            survivors.append((key, o, wi, out / survival, seen + ONE_ROUGH))
    return deposits, survivors


def leg_of(mode: int) -> Leg:
    """Work space of one bounce of N photons."""
    lists = [np.empty(N + 1, np.int32) for _ in range(3)]
    return Leg(mode, BOUNCE, empty_lanes(), np.empty(1, np.uint8), *lists, NO_GAIN, *deep_lists(N, False))


@pytest.mark.parametrize("mode", [CAUSTIC, DIFFUSE, GLOBAL])
def test_blocks_equal_the_law_one_by_one(mode):
    """Kernel and law differ by rounding to single precision alone: 3e-7 of numbers of order 1."""
    surfaces, photons = batch()
    laws = Laws(0.05, 2.0, MAX_ROUGH, np.zeros(1, np.float32), no_media())
    out, deposits, tally = empty_photons(N + 1), empty_deposits(N + 1), np.zeros((4, 3))
    alive, stored = photon_step(laws, leg_of(mode), surfaces, photons, out, deposits, 0, tally)
    kept, survivors = one_by_one(surfaces, photons, mode)
    assert (stored, alive) == (len(kept), len(survivors))
    assert stored > 10 and (mode == CAUSTIC or alive > LANES)
    np.testing.assert_allclose(deposits.position[:stored], [k[0] for k in kept], atol=1e-6)
    np.testing.assert_allclose(deposits.flux[:stored], [k[1] for k in kept], atol=1e-6)
    assert deposits.wi[:stored].tolist() == [k[2] for k in kept]
    assert deposits.normal[:stored].tolist() == [k[3] for k in kept]
    if survivors:
        assert out.key[:alive].tolist() == [s[0] for s in survivors]
        for field, k in ((out.o, 1), (out.d, 2), (out.phi, 3)):
            np.testing.assert_allclose(field[:alive], [s[k] for s in survivors], atol=2e-6)
        assert out.seen[:alive].tolist() == [s[4] for s in survivors]
    missed = surfaces.prim < 0
    np.testing.assert_allclose(tally[ESCAPED], photons.phi[missed].sum(axis=0), rtol=1e-6)
    left = photons.phi[~missed].sum(axis=0) - out.phi[:alive].sum(axis=0)
    np.testing.assert_allclose(tally[ABSORBED], left, rtol=1e-5)


IDEAL = {  # lobe fields beside the weight
    "glass": (GLASS, {FRESNEL: FRESNEL_DIELECTRIC, IOR: 1.5, COLOR_A: (0.9, 1.0, 0.8), COLOR_B: (0.9, 1.0, 0.8)}),
    "mirror": (REFLECT, {FRESNEL: FRESNEL_NONE, MULTISCATTER: 1.0, IOR: 1.5}),
    "metal": (REFLECT, {FRESNEL: FRESNEL_F82, COLOR_A: (0.5, 0.7, 0.2), COLOR_B: (0.9, 0.8, 1.0), IOR: 1.5}),
}


def survivors_of_sharp(surfaces, photons, media):
    """The law of a row of one delta lobe, photon by photon: [(key, o, d, phi, seen, inside)]."""
    survivors = []
    for i in range(N):
        prim = surfaces.prim[i]
        if prim < 0 or surfaces.t[i] < photons.dark[i]:
            continue
        p, ng, ns = surface_point(surfaces.geometry, prim, float(surfaces.u[i]), float(surfaces.v[i]))
        phi, wo = photons.phi[i].astype(float), tuple(-photons.d[i].astype(float))
        u = [uniform(photons.key[i], (BOUNCE + 1) * DIMENSIONS_PER_BOUNCE + k) for k in range(4)]
        prepare_any(surfaces.rows, 0, ns, ng, wo, 0.05, surfaces.scratch)
        ok, wi, weight, _, _ = sample_any(
            surfaces.rows, 0, ns, ng, wo, CLASS_SHARP, surfaces.scratch, (u[0], u[1], u[2]), 1
        )
        out = phi * weight
        survival = min(1.0, out.max() / phi.max())
        if ok and u[3] < survival:
            before, after = np.dot(ng, wo) >= 0.0, np.dot(ng, wi) >= 0.0
            inside = int(photons.inside[i])
            if media.of_prim[prim] >= 0 and before != after:
                inside = inside & ~1 if after else inside | 1
            seen = int(photons.seen[i]) | SEEN_SHARP
            o = leave(surfaces.geometry, prim, p, ng, wi)
            survivors.append((photons.key[i], o, wi, out / survival, seen, inside))
    return survivors


@pytest.mark.parametrize("name", IDEAL)
def test_blocks_of_mirrors_and_glass_equal_the_law_one_by_one(name):
    """As above, through the general functions of a surface; half of the triangles hold an absorbing inside."""
    surfaces, photons = batch(2)
    kind, fields = IDEAL[name]
    surfaces.rows.kind[0, 0] = kind
    for field, value in fields.items():
        surfaces.rows.params[0, 0, field : field + np.size(value)] = value
    media = Media(np.ones((1, 3)), np.where(np.arange(N) % 4 < 2, 0, -1).astype(np.int8), np.zeros(0, np.int64))
    photons = photons._replace(inside=(np.arange(N) % 3 == 0).astype(np.int64))
    laws = Laws(0.05, 2.0, MAX_ROUGH, np.zeros(1, np.float32), media)
    out, deposits, tally = empty_photons(N + 1, True), empty_deposits(N + 1), np.zeros((4, 3))
    leg = leg_of(DIFFUSE)
    alive, stored = photon_step(laws, leg, surfaces, photons, out, deposits, 0, tally)
    survivors = survivors_of_sharp(surfaces, photons, media)
    assert stored == 0 and alive == len(survivors) > LANES // 2
    assert set(leg.ideal[:alive]) <= set(np.flatnonzero(surfaces.prim >= 0))
    assert out.key[:alive].tolist() == [s[0] for s in survivors]
    for field, k in ((out.o, 1), (out.d, 2), (out.phi, 3)):
        np.testing.assert_allclose(field[:alive], [s[k] for s in survivors], atol=2e-6)
    assert out.seen[:alive].tolist() == [s[4] for s in survivors]
    assert out.inside[:alive].tolist() == [s[5] for s in survivors]
    left = photons.phi[surfaces.prim >= 0].sum(axis=0) - out.phi[:alive].sum(axis=0)
    np.testing.assert_allclose(tally[ABSORBED], left, rtol=1e-5)


@pytest.mark.parametrize("mode", [CAUSTIC, DIFFUSE, GLOBAL])
def test_no_new_photon_is_stored_but_for_a_final_gather(mode):
    """At their first hits photons have no history: the step neither looks nor, for caustics, loads what is matte."""
    surfaces, photons = batch(2)
    photons.seen[:] = 0
    leg = leg_of(mode)._replace(bounce=0)
    laws = Laws(0.05, 2.0, MAX_ROUGH, np.zeros(1, np.float32), no_media())
    out, deposits = empty_photons(N + 1), empty_deposits(N + 1)
    alive, stored = photon_step(laws, leg, surfaces, photons, out, deposits, 0, np.zeros((4, 3)))
    lit = np.count_nonzero((surfaces.prim >= 0) & (surfaces.t >= photons.dark))
    assert stored == (lit if mode == GLOBAL else 0) == sum(stores(mode, 0) for _ in range(lit))
    assert (alive > 0) == (mode != CAUSTIC)


@pytest.mark.parametrize("total", [0, 1, LEAST, LEAST + 1, SMALL + 1, CHUNK + 1, 100_000, FEW * CHUNK + 1])
def test_shares_are_even_and_whole(total):
    """Every photon is in one share; shares differ by at most one and do not exceed a chunk; few are shared by all."""
    shares = deal(total)
    assert [k for share in shares for k in share] == list(range(total))
    sizes = {len(share) for share in shares}
    assert not sizes or (max(sizes) <= CHUNK and max(sizes) - min(sizes) <= 1)
    assert total <= LEAST or len(shares) % 2 == 0
    assert len(shares) >= min(FEW, total / SMALL)


@pytest.mark.parametrize("bounces", [1, 2, 3, 64, 100])
def test_spans_cover_all_bounces(bounces):
    """Spans follow one another from the first bounce to the last."""
    assert [b for span in generations(bounces) for b in span] == list(range(bounces))
