"""What a scene holds, as far as it decides what must be rendered: names of what shines, reflects, receives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .issues import IssueLog
from .scene.data import Light, Material, SceneData, World
from .scene.reach import out_of_reach
from .shading.material import compile_material
from .shading.program import Program, constant_background

DEFAULT = "the default material"


class Survey(NamedTuple):
    """Names of materials, lamps and the world by what they may do; upper bounds: what is not named does it never."""

    surfaces: tuple[str, ...]  # materials on triangles
    unworn: tuple[str, ...]  # other materials
    idle: tuple[int, ...]  # lamps whose light meets neither what scatters it nor the camera, indices into scene.lights
    lit: tuple[str, ...]  # other lamps, materials and the world that give light
    can_be_hit: tuple[str, ...]  # of these, what a ray can meet
    seen: tuple[str, ...]  # of these, lamps and materials that eye paths can see
    sky: tuple[str, ...]  # the world, when it gives light
    sharp: tuple[str, ...]  # materials with a lobe of class S
    rough: tuple[str, ...]  # materials with a lobe of class D
    narrow: tuple[str, ...]  # materials with a rough lobe too narrow for a photon map
    see_through: tuple[str, ...]  # materials and objects that let light straight through
    deep: tuple[str, ...]  # materials that scatter light below the surface
    absorbing: tuple[str, ...]  # materials whose inside absorbs
    varying: tuple[str, ...]  # materials that vary over a surface or with direction
    needs: frozenset[str]  # what these look up, as in shading.program

    def unlit(self, may_shine: bool = False) -> Survey:
        """The same scene, known to light nothing; may_shine: what glows may do so for some rays only (Light Path)."""
        dark = self._replace(lit=(), can_be_hit=())
        return dark if may_shine else dark._replace(seen=(), sky=())


def survey(
    scene: SceneData, threshold: float, programs: Sequence[Program] | None = None, reach: bool = True
) -> Survey:
    """Look through a scene.

    threshold : roughness below which a lobe is sharp;  programs : of scene.materials, when they are compiled already
    reach : whether lamps that light nothing are told apart, and count as dark
    """
    used = used_materials(scene)
    if programs is None:
        programs = [compile_material(m, scene.images, IssueLog()) if i in used else unworn_program(m)
                    for i, m in enumerate(scene.materials)]  # fmt: skip
    known = [(programs[m].name, programs[m]) for m in sorted(used) if m >= 0]
    default = (DEFAULT,) if -1 in used else ()

    def having(ask) -> tuple[str, ...]:
        return tuple(name for name, program in known if ask(program))

    receivers = {m for m in used if m < 0 or scatters(programs[m], threshold)}
    idle = tuple(i for i in out_of_reach(scene, receivers) if shines(scene.lights[i])) if reach else ()
    lamps = [light for i, light in enumerate(scene.lights) if i not in idle and shines(light)]
    sky = (scene.world.name,) if world_shines(scene.world) else ()
    emitting = having(lambda program: program.emits)
    areas = tuple(light.name for light in lamps if not is_delta(light))
    ghosts = tuple(dict.fromkeys(item.name for item in scene.instances if not item.visible_shadow))
    varying = having(lambda program: not program.constant)
    return Survey(
        surfaces=having(lambda program: True) + default,
        unworn=tuple(m.name for i, m in enumerate(scene.materials) if i not in used),
        idle=idle,
        lit=tuple(light.name for light in lamps) + emitting + sky,
        can_be_hit=areas + emitting + sky,
        seen=areas + emitting,
        sky=sky,
        sharp=having(lambda program: program.has_sharp(threshold)),
        rough=having(lambda program: program.may_be_rough(threshold)) + default,
        narrow=having(lambda program: program.may_be_narrow(threshold)),
        see_through=having(lambda program: program.has_null) + ghosts,
        deep=having(lambda program: program.has_deep),
        absorbing=having(lambda program: program.absorption is not None),
        varying=varying,
        needs=frozenset().union(*(program.needs for _, program in known)),
    )


def scatters(program: Program, threshold: float) -> bool:
    """Whether light that meets a material may be turned by it, or end on it as something to see."""
    return program.has_sharp(threshold) or program.may_be_rough(threshold)


def shines(light: Light) -> bool:
    """Whether a lamp has any power."""
    return bool(np.any(np.asarray(light.strength) > 0.0))


def is_delta(light: Light) -> bool:
    """Whether no ray can meet a lamp: a point, one direction, or parallel rays from an area."""
    extent = {"SUN": light.angle, "AREA": light.spread}.get(light.kind, light.radius)
    return extent <= 0.0


def world_shines(world: World) -> bool:
    """Whether the world may give light; one that varies with direction may."""
    return bool(np.any(np.asarray(world.color) > 0.0)) or constant_background(world.graph) is None


def used_materials(scene: SceneData) -> set[int]:
    """Indices of the materials that triangles wear; -1: the default material."""
    slots = [
        np.zeros(1, np.int64) if mesh.material_index is None else np.unique(mesh.material_index)
        for mesh in scene.meshes
    ]
    used: set[int] = set()
    for item in scene.instances:
        if len(scene.meshes[item.mesh].triangles) == 0:
            continue
        worn = item.materials or [-1]
        used.update(max(worn[min(slot, len(worn) - 1)], -1) for slot in slots[item.mesh].tolist())
    return used


def unworn_program(material: Material) -> Program:
    """Stands in for the program of a material that no triangle wears."""
    return Program(material.name, [], None)
