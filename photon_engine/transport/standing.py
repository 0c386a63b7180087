"""What materials, lights and casters come to, kept from render to render while nothing that they read changes.

Each function asks the memo with all that the work behind it reads: a camera that moves makes none of it anew, a thing
that moves only what depends on it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..geometry.flatten import Flattened, bounding_sphere
from ..geometry.intersect import Intersector
from ..issues import IssueLog
from ..lights.nodes import LampNodes, make_lamp_nodes
from ..lights.sky import Sky, build_sky
from ..lights.table import Emitters, LightTable, build_lights
from ..lights.targets import Targets, build_targets
from ..scene.data import Light, SceneData
from ..scene.memo import Memo
from ..shading.material import compile_material
from ..shading.program import Program
from ..survey import unworn_program, used_materials
from .cull import boxes_of
from .emission import find_emitters
from .materials import MaterialTable
from .media import Media, find_media, locate_lights
from .node_rays import NodeRays

SMALLEST = 1e-9  # of the scene's radius: what photons are aimed at is no smaller, positions are not that fine
VIEW_NEEDS = {"camera", "bump"}  # of a program: it gives something else when the camera moves


class Casters(NamedTuple):
    """Bounds of what may focus light, and of all there is."""

    centers: np.ndarray  # (n, 3) f64, spheres round the instances with a specular surface; round all if none has one
    radii: np.ndarray  # (n,) f64 [m]
    boxes: np.ndarray  # (m, 2, 3) f64, round specular surfaces; see cull.boxes_of
    all_boxes: np.ndarray  # (k, 2, 3) f64, round everything


def material_programs(memo: Memo, scene: SceneData, every: bool, issues: IssueLog) -> list[Program]:
    """The programs of a scene's materials; every : also of those that no triangle wears."""
    images, worn = tuple(scene.images), used_materials(scene)
    return [
        memo.get(("material", i), (item, images), lambda own, m=item: compile_material(m, scene.images, own), issues)
        if every or i in worn
        else unworn_program(item)
        for i, item in enumerate(scene.materials)
    ]


def node_rays(memo: Memo, flat: Flattened, intersector: Intersector) -> NodeRays:
    """Rays of the materials' nodes, with the trees of single instances that they have asked for so far."""
    return memo.get("node rays", (flat, intersector), lambda _own: NodeRays(flat, intersector), IssueLog())


def glowing_triangles(memo: Memo, scene: SceneData, flat: Flattened, table: MaterialTable) -> Emitters:
    """As `emission.find_emitters`; what it reads are the triangles that glow, and the instances that wear them."""
    geometry = flat.geometry
    tri = np.flatnonzero(table.emits[geometry.material]) if len(geometry.material) else np.zeros(0, np.int64)
    materials = np.unique(geometry.material[tri])
    worn = [table.programs[m] for m in materials]
    owners = [scene.instances[i] for i in np.unique(geometry.instance[tri])]
    seen = any(VIEW_NEEDS & program.needs for program in worn)
    traced = any("rays" in program.needs for program in worn)  # what is near by darkens them
    inputs = (
        tri, geometry.positions[geometry.triangles[tri]], geometry.material[tri], geometry.instance[tri], flat.origin,
        worn, table.fixed.kind[materials], table.fixed.params[materials],
        owners, [scene.meshes[item.mesh] for item in owners], (scene.camera, scene.frame) if seen else None,
        flat if traced else None,
    )  # fmt: skip
    return memo.get("emitters", inputs, lambda _own: find_emitters(flat, table), IssueLog())


def sky_table(memo: Memo, scene: SceneData, issues: IssueLog) -> Sky | None:
    """As `sky.build_sky`."""
    inputs = scene.world, tuple(scene.images)
    return memo.get("sky", inputs, lambda own: build_sky(scene.world, scene.images, own), issues)


def lamp_nodes(memo: Memo, scene: SceneData, flat: Flattened) -> tuple[LampNodes | None, ...]:
    """The nodes of each of a scene's lamps that are evaluated at every sample, None where there are none."""
    sphere, images = (flat.center, flat.radius), tuple(scene.images)

    def nodes_of(i: int, light: Light) -> LampNodes | None:
        if light.graph is None:
            return None
        inputs = light, images, scene.camera, flat.origin, sphere
        return memo.get(("lamp", i), inputs, lambda _own: make_lamp_nodes(light, scene.images, *inputs[2:]), IssueLog())

    return tuple(nodes_of(i, light) for i, light in enumerate(scene.lights))


def light_table(
    memo: Memo, scene: SceneData, idle: tuple[int, ...], emitters: Emitters, sky: Sky | None, flat: Flattened,
    issues: IssueLog,
) -> tuple[LightTable, dict[int, LampNodes]]:  # fmt: skip
    """As `table.build_lights`, of all lamps but those with the indices `idle`; and their nodes, by row of the table."""
    kept = [i for i in range(len(scene.lights)) if i not in idle]
    nodes = lamp_nodes(memo, scene, flat)
    lit = replace(scene, lights=[with_share(scene.lights[i], nodes[i]) for i in kept])
    count, sky_map = len(flat.geometry.triangles), None if sky is None else sky.map
    inputs = tuple(lit.lights), scene.world, emitters, count, flat.center, flat.radius, flat.origin, sky_map
    table = memo.get(
        "lights",
        inputs,
        lambda own: build_lights(lit, emitters, count, flat.center, flat.radius, flat.origin, own, sky_map),
        issues,
    )
    by_row = {row: nodes[kept[source]] for row, source in enumerate(table.source) if source >= 0}
    return table, {row: item for row, item in by_row.items() if item is not None}


def with_share(light: Light, nodes: LampNodes | None) -> Light:
    """A lamp as strong as it is in the mean over what its nodes give."""
    return light if nodes is None else replace(light, strength=tuple(s * nodes.share for s in light.strength))


def caster_bounds(memo: Memo, flat: Flattened, sharp: np.ndarray) -> Casters:
    """Bounds of what photons are aimed at; sharp : (T,) bool, the triangles with a specular lobe."""
    return memo.get("casters", (flat, sharp), lambda _own: _casters(flat, sharp), IssueLog())


def _casters(flat: Flattened, sharp: np.ndarray) -> Casters:
    """Spheres and boxes."""
    geometry = flat.geometry
    aimed = sharp if sharp.any() else np.ones(len(sharp), bool)
    centers, radii = [], []
    for i in np.unique(geometry.instance[aimed]):
        first, last = flat.first_triangle[i], flat.first_triangle[i + 1]
        inside = geometry.triangles[first:last][aimed[first:last]]
        center, radius = bounding_sphere(geometry.positions[inside.ravel()])
        centers.append(center)
        radii.append(max(radius, SMALLEST * flat.radius))
    return Casters(
        np.array(centers),
        np.array(radii),
        boxes_of(geometry.positions, geometry.triangles[sharp], geometry.instance[sharp]),
        boxes_of(geometry.positions, geometry.triangles, geometry.instance),
    )


def photon_targets(memo: Memo, lights: LightTable, casters: Casters) -> Targets:
    """As `targets.build_targets`, which estimates the flux of each light into each sphere."""
    inputs = lights, casters.centers, casters.radii
    return memo.get("targets", inputs, lambda _own: build_targets(lights, *inputs[1:]), IssueLog())


def absorbing_media(
    memo: Memo, scene: SceneData, flat: Flattened, intersector: Intersector, programs: list[Program],
    lights: LightTable, issues: IssueLog,
) -> Media:  # fmt: skip
    """What absorbs, and which lamps are inside of it."""
    sigma = [program.absorption for program in programs]
    places = lights.kind, lights.position[: lights.n_near]  # suns, meshes and sky are nowhere
    return memo.get(
        "media",
        (scene.name, flat, sigma, places),
        lambda own: locate_lights(find_media(scene, flat, sigma, own), flat, intersector, lights),
        issues,
    )
