"""Light of lamps whose nodes are evaluated at each sample: shadow rays, rays that meet a lamp, photons that land.

The nodes may ask for the distance, which a photon has not gone before it lands: its flux is multiplied where it meets
the first surface, and a straight pass through that leaves it as it was, for the next one.
"""

from __future__ import annotations

import numpy as np

from ..bsdf.layout import TRANSPARENT
from ..jit import kernel
from ..lights.sample import LAMP, hidden, lamp_met, sun_met
from ..lights.table import DELTA, SUN
from ..photons.batch import Photons
from ..vec import dot, load3, sub
from .direct_kernels import SecondPaths, ShadowRays
from .eye_batch import EyePaths, Tile
from .photon_kernels import Surfaces

NO_GAIN = np.zeros((0, 3), np.float32)  # where no lamp has such nodes


def multiply_nodes(scene, rays: ShadowRays) -> None:
    """Multiply the light of shadow rays to such lamps by what their nodes give."""
    for l, nodes in scene.lamp_nodes.items():
        index = np.flatnonzero(rays.emitter == LAMP - l)
        if len(index):
            rays.light[index] *= nodes.arriving(rays.o[index], rays.d[index])


def land(scene, photons: Photons, surfaces: Surfaces, emitted: np.ndarray) -> np.ndarray:
    """What the flux of photons straight from such lamps is multiplied by where they land; out: `Leg.gain`.

    Flux is multiplied at once where nothing lets light straight on, and the gain is 1 there; a photon that is then
    black hits nothing. emitted (3,) : to which the difference is added [W].
    """
    gain = np.ones((len(photons.key), 3), np.float32)
    reached = (surfaces.prim >= 0) & (surfaces.t >= photons.dark)
    for l, nodes in scene.lamp_nodes.items():
        index = np.flatnonzero(reached & (photons.lamp == l))
        d = photons.d[index]
        gain[index] = nodes.arriving(photons.o[index] + surfaces.t[index, None] * d, -d)
    through = (surfaces.rows.kind == TRANSPARENT).any(axis=1)[surfaces.row]
    index = np.flatnonzero(reached & (photons.lamp >= 0) & ~through)
    before = photons.phi[index]
    photons.phi[index] = before * gain[index]
    emitted += (photons.phi[index].astype(np.float64) - before).sum(axis=0)
    gain[index], photons.lamp[index] = 1.0, -1
    surfaces.prim[index[~photons.phi[index].any(axis=1)]] = -1
    return gain


def see_lamps(scene, surfaces: Surfaces, paths: EyePaths, tile: Tile) -> None:
    """Add what eye paths see of such lamps before their hits."""
    if not scene.plan.sees_lights:
        return
    weight = np.empty(len(paths.key))
    for l, nodes in scene.lamp_nodes.items():
        note_seen(scene.lights, l, paths, surfaces, weight)
        index = np.flatnonzero(weight)
        if len(index) == 0:
            continue
        light = paths.beta[index] * radiance(scene, l, nodes, weight[index], paths.o[index], paths, index)
        np.add.at(tile.emission, paths.pixel[index], light)
        if len(tile.guide_albedo):
            guiding = paths.unguided[index]
            np.add.at(tile.guide_albedo, paths.pixel[index[guiding]], np.clip(light[guiding], 0.0, 1.0))


def meet_lamps(scene, surfaces: Surfaces, paths: SecondPaths, samples: int, direct: np.ndarray) -> None:
    """Add the direct light of such lamps that rays from the lobes meet; direct (pixels, 3)."""
    weight = np.empty(len(paths.key))
    for l, nodes in scene.lamp_nodes.items():
        note_met(scene.lights, l, paths, surfaces, samples, weight)
        index = np.flatnonzero(weight)
        if len(index):
            light = radiance(scene, l, nodes, weight[index], paths.origin[index], paths, index)
            np.add.at(direct, paths.pixel[index], paths.beta[index] * light)


def radiance(scene, l: int, nodes, weight, origin, paths, index) -> np.ndarray:
    """Radiance (m, 3) of lamp l, weighted, that paths of these indices bring to their origins."""
    trail = paths.trail[index] if len(paths.trail) else None
    plain = (scene.lights.radiance[l] * weight[:, None]).astype(np.float32)
    return plain * nodes.arriving(origin, paths.d[index], trail)


@kernel
def note_seen(lights, l, paths, surfaces, weight):
    """The share of lamp l's radiance that each eye path sees before its hit; 0: none."""
    for i in range(len(weight)):
        o, d = load3(paths.o, i), load3(paths.d, i)
        weight[i] = 0.0
        if not hidden(lights, l, 0, 1 if paths.bare[i] else 0):
            weight[i] = met(lights, l, o, d, (o, 0.0, 0), surfaces, i)


@kernel
def note_met(lights, l, paths, surfaces, samples, weight):
    """The same for rays from the lobes that are direct light, with their MIS weight against `samples` light samples."""
    for i in range(len(weight)):
        weight[i] = 0.0
        if paths.bare[i] and not hidden(lights, l, 1, 0):
            o, d = load3(paths.o, i), load3(paths.d, i)
            since = (load3(paths.origin, i), float(paths.pdf_w[i]) / samples, 1)
            weight[i] = met(lights, l, o, d, since, surfaces, i)


@kernel
def met(lights, l, o, d, since, surfaces, i):
    """Gain and MIS weight of lamp l on a ray (o, d) up to hit i; since : where d was chosen, its density, use_mis."""
    origin, pdf_w, use_mis = since
    reach = float(surfaces.t[i]) if surfaces.prim[i] >= 0 else np.inf
    if lights.kind[l] == SUN:
        if lights.flags[l] & DELTA or reach < np.inf:
            return 0.0
        return sun_met(lights, l, d, origin, pdf_w, use_mis)
    start = dot(sub(o, origin), d)
    return lamp_met(lights, l, origin, d, (start, start + reach), pdf_w, use_mis)
