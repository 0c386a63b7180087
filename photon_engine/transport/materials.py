"""Every hit gets its row of lobes: a fixed row for a plain material, a fresh one where textures vary.

Only what some program needs is looked up (UVs, tangents, generated coordinates, ...).
"""

from __future__ import annotations

import numpy as np

from ..bsdf.layout import DIFFUSE, N_FIELDS, LobeRows, pack
from ..geometry.flatten import Flattened
from ..geometry.intersect import Hits
from ..geometry.surface import surface_points
from ..jit import kernel
from ..scene.data import SceneData
from ..shading.points import ObjectTable, ShadePoints, probe_points
from ..shading.program import Program
from .attributes import Neighbours, fill_attributes
from .node_rays import NodeRays

DEFAULT_GREY = 0.8  # what Blender shows for a slot without a material


@kernel
def look_up(table, index, out):
    """Entries of a table, out[i] = table[index[i]]; 0 where the index is negative. A fifth of numpy's time."""
    if len(table) == 0:
        out[:] = 0
        return
    for i in range(len(index)):  # without branches: which rays miss is anybody's guess
        value = table[max(index[i], 0)]
        out[i] = value if index[i] >= 0 else 0


def only_rough(program: Program, threshold: float) -> bool:
    """Whether a material scatters, and nowhere sharply nor straight on."""
    return program.may_be_rough(threshold) and not program.has_sharp(threshold) and not program.has_null


class MaterialTable:
    """The programs of a scene's materials; row M is the default material."""

    def __init__(
        self,
        scene: SceneData,
        flat: Flattened,
        threshold: float,
        programs: list[Program],
        rays: NodeRays | None = None,
    ) -> None:
        """programs : of scene.materials;  threshold : roughness below which a lobe is sharp;  rays : of their nodes."""
        self.rays = rays
        self.scene = scene
        self.flat = flat
        self.programs = programs
        count = len(self.programs)
        self.slots = max([1] + [program.slots for program in self.programs])
        self.fixed = LobeRows(
            np.zeros((count + 1, self.slots), np.int32), np.zeros((count + 1, self.slots, N_FIELDS), np.float32)
        )
        self.fixed.kind[count, 0] = DIFFUSE
        self.fixed.params[count, 0, :3] = DEFAULT_GREY
        for m, program in enumerate(self.programs):
            if program.constant:
                rows = pack(program.lobes(probe_points(1)), 1, self.slots)
                self.fixed.kind[m], self.fixed.params[m] = rows.kind[0], rows.params[0]
        used = np.zeros(count + 1, bool)
        used[np.unique(flat.geometry.material)] = True
        self.used = used
        self.varying = [m for m, program in enumerate(self.programs) if used[m] and not program.constant]
        self.objects = ObjectTable.from_instances(scene.instances) if self.varying else None
        self.has_sharp = self._flags(lambda program: program.has_sharp(threshold), False)
        self.emits = self._flags(lambda program: program.emits, False)
        self.bends_deep = bool(self._flags(lambda program: program.bends_deep, False).any())
        ends = self._flags(lambda program: only_rough(program, threshold), True)
        # rows for photons that end at any rough surface: there the default one, which costs nothing, tells as much
        self.for_ends = np.where(ends, count, np.arange(count + 1)).astype(np.int32)

    def _flags(self, ask, default: bool) -> np.ndarray:
        """(M + 1,) bool: the answer of each used program, then of the default material."""
        answers = [bool(ask(program)) for program in self.programs] + [default]
        return np.array(answers, bool) & self.used

    def shade(self, hits: Hits, d: np.ndarray, ends_at_rough: bool = False, **path) -> tuple[LobeRows, np.ndarray]:
        """Rows of lobes and the row of each hit; d : (n, 3) f32 ray directions; path: fields of ShadePoints, arrays for
        all hits or empty; ends_at_rough: what is but rough need not be told apart from Lambert."""
        material = np.empty(len(hits.prim), np.int32)
        look_up(self.flat.geometry.material, hits.prim, material)
        if ends_at_rough:
            look_up(self.for_ends, material, material)
        if not self.varying:
            return self.fixed, material
        valid = hits.prim >= 0
        picked = [(m, np.flatnonzero(valid & (material == m))) for m in self.varying]
        picked = [(m, index) for m, index in picked if len(index)]
        if not picked:
            return self.fixed, material
        kinds, params = [self.fixed.kind], [self.fixed.params]
        row = material.copy()
        start = len(self.fixed.kind)
        for m, index in picked:
            mine = {name: value[index] for name, value in path.items() if isinstance(value, np.ndarray) and len(value)}
            mine |= {name: value for name, value in path.items() if not isinstance(value, np.ndarray)}
            rows = self.rows_at(m, Hits(*(field[index] for field in hits)), -d[index], **mine)
            kinds.append(rows.kind)
            params.append(rows.params)
            row[index] = np.arange(start, start + len(index), dtype=np.int32)
            start += len(index)
        return LobeRows(np.concatenate(kinds), np.concatenate(params)), row

    def rows_at(self, m: int, hits: Hits, wo: np.ndarray, **path) -> LobeRows:
        """Fresh rows of a varying material at hits, seen from wo (n, 3)."""
        program = self.programs[m]
        n = len(hits.prim)
        p, ng, ns = (np.empty((n, 3), np.float32) for _ in range(3))
        surface_points(self.flat.geometry, hits.prim, hits.u, hits.v, p, ng, ns)
        points = ShadePoints(
            p=p,
            origin=self.flat.origin,
            ng=ng,
            ns=ns,
            wo=np.ascontiguousarray(wo, np.float32),
            backfacing=(wo * ng).sum(axis=1) < 0.0,
            instance=self.flat.geometry.instance[hits.prim],
            objects=self.objects,
            parametric=np.stack([hits.u, hits.v], axis=1),
            ray_length=hits.t,
            **path,
        )
        fill_attributes(points, program.needs, self.scene, self.flat, hits)
        points.rays = self.rays if "rays" in program.needs else None
        if "bump" in program.needs:
            points.around = Neighbours(points, program.needs, self.scene, self.flat, hits)
        return pack(program.lobes(points), n, self.slots)
