"""Random walks below a surface: where the next leg goes, and what it leaves of the light.

Legs are sampled by nine estimators at once, combined by the balance heuristic: in three colours, evenly by the phase
function or toward the surface [Krivanek and d'Eon 2014], or toward the far side of a thin body [Meng et al. 2016]. Cut
off after MOST_LEGS, as in Cycles, which so takes a little light from white bodies of a size of many free paths.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.surface import leave, surface_point
from ..jit import kernel
from ..sampling.rng import uniform
from ..sampling.warps import turn
from ..vec import basis, dot, load3, madd, max3, mul, scale, store3

MOST_LEGS = 256
EXACT_LEGS = 9  # legs after these are of the similar isotropic medium
PER_LEG = 8  # random numbers of a leg,
FIRST = 8  # after those of the entry
FAR = 10.0  # free paths: how far the first leg looks for the other side
WEAK = 0.05  # of the light that entered: a walk with less goes on by Russian roulette
T, COS, PHASE, BACK, PICK = 0, 1, 2, 3, 4  # columns of Walkers.leg: PICK has 3


class Walkers(NamedTuple):
    """Walks below surfaces, each from the hit of a ray."""

    lane: np.ndarray  # (n,) i32, which ray
    lobe: np.ndarray  # (n,) i32, which lobe of its hit
    key: np.ndarray  # (n,) u64, random numbers
    p: np.ndarray  # (n, 3) f64 [m]
    d: np.ndarray  # (n, 3) f64, of the latest leg
    beta: np.ndarray  # (n, 3) f64, throughput
    weak: np.ndarray  # (n,) f64, below it the walk may end
    normal: np.ndarray  # (n, 3) f64, where it entered, outward
    start: np.ndarray  # (n,) f64, height of the entry along the normal [m]
    albedo: np.ndarray  # (n, 3) f64, of single scattering
    sigma: np.ndarray  # (n, 3) f64, extinction [1/m]
    g: np.ndarray  # (n,) f64, mean cosine
    length: np.ndarray  # (n,) f64, diffusion length over the free path
    across: np.ndarray  # (n,) f64, depth of the other side [m]; below 0: none near
    leg: np.ndarray  # (n, 7) f64, how the leg was sampled
    prim: np.ndarray  # (n,) i32, where it entered, then where it came out; -1: it did not
    u: np.ndarray  # (n,) f32, where on that triangle
    v: np.ndarray  # (n,) f32


def empty_walkers(n: int) -> Walkers:
    """Room for n walks."""
    three, one = (lambda: np.empty((n, 3))), (lambda: np.empty(n))
    return Walkers(
        np.empty(n, np.int32), np.empty(n, np.int32), np.empty(n, np.uint64), three(), three(), three(), one(), three(),
        one(), three(), three(), one(), one(), one(), np.empty((n, 7)), np.empty(n, np.int32),
        np.empty(n, np.float32), np.empty(n, np.float32),
    )  # fmt: skip


@kernel
def begin(walkers, j, lane, lobe, key, surfaces, normal, d, beta, inner):
    """Write walk j from hit `lane` along d; inner : the medium, as of `deep.medium`. Out: whether light goes along."""
    if max3(beta) <= 0.0:
        return False
    albedo, sigma, g = inner
    a = max3(albedo)
    length = 1.0 / math.sqrt(1.0 - a ** (2.44294 - 0.0215813 * a + 0.578637 / a))  # [d'Eon and Krivanek 2020, Eq. 67]
    prim, u, v = surfaces.prim[lane], surfaces.u[lane], surfaces.v[lane]
    p, _, _ = surface_point(surfaces.geometry, prim, float(u), float(v))
    walkers.lane[j], walkers.lobe[j], walkers.key[j] = lane, lobe, key
    store3(walkers.p, j, p)
    store3(walkers.d, j, d)
    store3(walkers.beta, j, beta)
    walkers.weak[j] = WEAK * max3(beta)
    store3(walkers.normal, j, normal)
    walkers.start[j] = dot(p, normal)
    store3(walkers.albedo, j, albedo)
    store3(walkers.sigma, j, sigma)
    walkers.g[j], walkers.length[j], walkers.across[j] = g, length, -1.0
    walkers.prim[j], walkers.u[j], walkers.v[j] = prim, u, v
    return True


@kernel
def coefficients(walkers, i, bounce):
    """(extinction rgb, scattering rgb, g, share of guided legs) of a leg of walk i."""
    sigma, g = load3(walkers.sigma, i), float(walkers.g[i])
    scatter = mul(sigma, load3(walkers.albedo, i))
    if bounce <= EXACT_LEGS:
        return sigma, scatter, g, 1.0 - max(0.5, abs(g) ** 0.125)
    less = scale(scatter, -g)
    return madd(sigma, 1.0, less), madd(scatter, 1.0, less), 0.0, 0.75


@kernel
def guide_density(length, cos):
    """Density of the cosine to the normal of a guided leg, over 2 pi: Dwivedi's [Meng et al. 2016, Eq. 9]."""
    return 1.0 / (2.0 * math.pi * (length - cos) * math.log((length + 1.0) / (length - 1.0)))


@kernel
def guide_cos(length, u):
    """A cosine to the normal of a guided leg, distributed as `guide_density` says."""
    return length - (length + 1.0) * ((length - 1.0) / (length + 1.0)) ** u


@kernel
def turned(d, cos, u):
    """A direction at this cosine to the unit vector d, at the angle 2 pi u about it."""
    s, t = basis(d)
    c1, s1 = turn(u)
    r = math.sqrt(max(1.0 - cos * cos, 0.0))
    return madd(madd(scale(d, cos), r * c1, s), r * s1, t)


@kernel
def phase_cos(g, u):
    """A cosine distributed as Henyey and Greenstein's phase function."""
    if abs(g) < 1e-3:
        return 1.0 - 2.0 * u
    k = (1.0 - g * g) / (1.0 - g + 2.0 * g * u)
    return min(max((1.0 + g * g - k * k) / (2.0 * g), -1.0), 1.0)


@kernel
def phase(g, cos):
    """Henyey and Greenstein's phase function [1/sr]."""
    if abs(g) < 1e-3:
        return 0.25 / math.pi
    return 0.25 / math.pi * (1.0 - g * g) / max(1.0 + g * g - 2.0 * g * cos, 1e-30) ** 1.5


@kernel
def aim(geometry, walkers, index, bounce, o, d, t_max):
    """Sample the next leg of walks `index` and write its ray."""
    for j in range(len(index)):
        i = index[j]
        stretch = _turn(walkers, i, bounce)
        sigma, _, _, _ = coefficients(walkers, i, bounce)
        key, dim = walkers.key[i], FIRST + PER_LEG * bounce
        pick = mul(load3(walkers.beta, i), load3(walkers.albedo, i))
        total = pick[0] + pick[1] + pick[2]
        pick = scale(pick, 1.0 / total)
        x = uniform(key, dim)
        rate = sigma[0] if x < pick[0] else sigma[1] if x < pick[0] + pick[1] else sigma[2]
        t = -math.log(1.0 - uniform(key, dim + 1)) / (rate * stretch)
        walkers.leg[i, T] = t
        walkers.leg[i, PICK], walkers.leg[i, PICK + 1], walkers.leg[i, PICK + 2] = pick
        p, w = load3(walkers.p, i), load3(walkers.d, i)
        reach = t
        if bounce == 0:
            _, ng, _ = surface_point(geometry, walkers.prim[i], float(walkers.u[i]), float(walkers.v[i]))
            p = leave(geometry, walkers.prim[i], p, ng, w)
            reach = max(t, FAR / min(sigma[0], min(sigma[1], sigma[2])))
        store3(o, j, p)
        store3(d, j, w)
        t_max[j] = min(reach, 1e30)


@kernel
def _turn(walkers, i, bounce):
    """Turn walk i to its next leg, whose direction the first one has; out: what its extinction is stretched by."""
    if bounce == 0:
        return 1.0
    _, _, g, share = coefficients(walkers, i, bounce)
    key, dim = walkers.key[i], FIRST + PER_LEG * bounce
    n, w, length = load3(walkers.normal, i), load3(walkers.d, i), float(walkers.length[i])
    back, backward = 0.0, False
    if walkers.across[i] >= 0.0:
        depth = min(max(walkers.start[i] - dot(load3(walkers.p, i), n), 0.0), walkers.across[i])
        back = 1.0 / (1.0 + math.exp(min((walkers.across[i] - 2.0 * depth) / length, 700.0)))
        backward = uniform(key, dim + 3) < back
    guided = uniform(key, dim + 2) < share
    u0, u1 = uniform(key, dim + 4), uniform(key, dim + 5)
    if guided:
        cos = -guide_cos(length, u0) if backward else guide_cos(length, u0)
        new = turned(n, cos, u1)
    else:
        new = turned(w, phase_cos(g, u0), u1)
        cos = dot(new, n)
    walkers.leg[i, COS], walkers.leg[i, PHASE], walkers.leg[i, BACK] = cos, phase(g, dot(w, new)), back
    store3(walkers.d, i, new)
    if not guided:
        return 1.0
    return 1.0 + cos / length if backward else 1.0 - cos / length


@kernel
def advance(walkers, index, bounce, prim, u, v, far):
    """Take walks `index` along their legs, with what they hit of their own body; out: how many go on (compacted).

    `prim`, `u`, `v` of a walk that came out are where, its d how; -1 those of one that did not.
    """
    alive = 0
    for j in range(len(index)):
        i = index[j]
        t, hit = float(walkers.leg[i, T]), prim[j] >= 0
        if bounce == 0 and hit:
            walkers.across[i] = -far[j] * dot(load3(walkers.d, i), load3(walkers.normal, i))
            hit = far[j] < t
        t = float(far[j]) if hit else t
        beta = mul(load3(walkers.beta, i), _kept(walkers, i, bounce, t, hit))
        store3(walkers.p, i, madd(load3(walkers.p, i), t, load3(walkers.d, i)))
        if hit:
            walkers.prim[i], walkers.u[i], walkers.v[i] = prim[j], u[j], v[j]
            store3(walkers.beta, i, beta)
            continue
        walkers.prim[i] = -1
        strong = max3(beta)
        if strong < walkers.weak[i]:
            if uniform(walkers.key[i], FIRST + PER_LEG * bounce + 6) * walkers.weak[i] >= strong:
                continue
            beta = scale(beta, walkers.weak[i] / strong)
        store3(walkers.beta, i, beta)
        walkers.prim[i] = -2  # still below
        index[alive] = i
        alive += 1
    return alive


@kernel
def _kept(walkers, i, bounce, t, hit):
    """What a leg of length t leaves of the light (rgb), over its density by all estimators."""
    sigma, scatter, _, share = coefficients(walkers, i, bounce)
    passed = (math.exp(-sigma[0] * t), math.exp(-sigma[1] * t), math.exp(-sigma[2] * t))
    ahead, behind, forth, back = 0.0, 0.0, 1.0, 1.0
    if bounce > 0:
        cos, length, side = walkers.leg[i, COS], float(walkers.length[i]), float(walkers.leg[i, BACK])
        forth, back = 1.0 - cos / length, 1.0 + cos / length
        ahead = share * (1.0 - side) * guide_density(length, cos) / walkers.leg[i, PHASE]
        behind = share * side * guide_density(length, -cos) / walkers.leg[i, PHASE] if side > 0.0 else 0.0
    else:
        share = 0.0
    density = 0.0
    for c in range(3):
        s = sigma[c]
        even, front, rear = passed[c], math.exp(-s * forth * t), math.exp(-s * back * t)
        if not hit:
            even, front, rear = s * even, s * forth * front, s * back * rear
        density += walkers.leg[i, PICK + c] * ((1.0 - share) * even + ahead * front + behind * rear)
    if density <= 0.0:
        return (0.0, 0.0, 0.0)
    passed = scale(passed, 1.0 / density)
    return passed if hit else mul(scatter, passed)
