"""A node graph as a list of calls, one pure function a node.

Compiling runs the nodes once whose inputs do not vary over the surface, drops the branches that a constant mix
factor hides, and leaves the rest to be run on each batch of hits.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..bsdf import layout
from ..bsdf.layout import Lobe
from ..bsdf.microfacet import DELTA_ALPHA, NEARLY_ONE
from ..issues import IssueLog, RenderError
from ..scene.data import Graph, Image, Node, Socket
from . import nodes  # noqa: F401  (fills the registry)
from .fallback import fallback_kind, report_unsupported
from .points import ShadePoints, probe_points
from .registry import REGISTRY, SCALARS, NodeKind, constant, convert, zero
from .relief import SHIFT, expand_bumps

BENDING_KINDS = {layout.GLASS, layout.REFRACT}
SHARP_KINDS = {layout.REFLECT, layout.THIN, *BENDING_KINDS}
ODD_KINDS = {layout.SHEEN, layout.VELVET, layout.TOON, layout.TOON_GLOSSY}
ROUGH_KINDS = {layout.DIFFUSE, layout.TRANSLUCENT, layout.SUBSURFACE, *ODD_KINDS, *SHARP_KINDS}


class Source(NamedTuple):
    """Where a call's input comes from: another call's output, or a constant."""

    call: int  # index into the program's calls; -1: `value`
    output: str
    kind: str  # of the output
    target: str  # of the input
    value: Any


@dataclass
class Call:
    """One node of a program."""

    node: Node
    kind: NodeKind
    inputs: dict[str, Source]
    props: dict[str, Any]
    outputs: dict[str, Any] | None = None  # its values, when they do not vary

    def run(self, values: list, points: ShadePoints | None) -> dict[str, Any]:
        """The node's outputs; values: outputs of the calls before.

        A RenderError names a node with inputs or settings that Blender would not have given it.
        """
        try:
            out, kinds = self._run(values, points), self.node.output_kinds
            for name, value in out.items():
                if isinstance(value, list) != (kinds.get(name, "VALUE") == "SHADER"):
                    raise TypeError(f"its output '{name}' is not what it says")
            return out
        except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
            name, what = f"node '{self.node.name}' ({self.node.type})", f"{type(error).__name__}: {error}"
            remedy = "save the scene again; of a scene straight from Blender this is a bug: please report it"
            raise RenderError(name, f"it cannot be computed with its inputs and settings: {what}", remedy) from error

    def _run(self, values: list, points: ShadePoints | None) -> dict[str, Any]:
        x = {name: fetch(source, values) for name, source in self.inputs.items()}
        if SHIFT in self.props and points is not None and points.around is not None:
            points = points.around.at(*self.props[SHIFT])
        if not (self.kind.rows or "SHADER" in self.node.output_kinds.values()):
            return self.kind.function(x, self.props, points)
        out = self.kind.function({name: transposed(value) for name, value in x.items()}, self.props, points)
        return {name: transposed(value) for name, value in out.items()}


def transposed(value):
    """A vector's components as rows, or back; anything else as it is."""
    return value.T if isinstance(value, np.ndarray) and value.ndim == 2 else value


def fetch(source: Source, values: list):
    """An input's value, converted to its kind."""
    if source.call < 0:
        return source.value
    value = values[source.call].get(source.output)
    if value is None:
        return zero(source.target)
    return convert(value, source.kind, source.target)


@dataclass
class Program:
    """A material ready to be evaluated."""

    name: str
    calls: list[Call]
    surface: Source | None
    live: list[int] = field(default_factory=list)  # calls to run for each batch, in order
    needs: frozenset[str] = frozenset()  # fields of ShadePoints that are read: "uv", "uv:NAME", "generated", ...
    constant: bool = True
    relief: Program | None = None  # displacement shown as bump: its surface is the normal
    absorption: np.ndarray | None = None  # (3,) f64, of the inside [1/m]; None: nothing is there
    _probe: list[Lobe] = field(default_factory=list)

    def lobes(self, points: ShadePoints | None = None) -> list[Lobe]:
        """Lobes of a batch; of a constant program with one row for all (no points needed)."""
        if self.surface is None:
            return []
        if self.relief is None or points is None:
            return straightened(self.run(points))
        normal = points.facing(np.asarray(self.relief.run(points), np.float32).T)
        return with_normal(straightened(self.run(replace(points, ns=normal))), normal)

    def run(self, points: ShadePoints | None):
        """The value of the surface socket."""
        values = [call.outputs for call in self.calls]
        for index in self.live:
            values[index] = self.calls[index].run(values, points)
        return fetch(self.surface, values)

    @property
    def slots(self) -> int:
        """Number of lobes, at least 1."""
        return max(1, len(self._probe))

    @property
    def emits(self) -> bool:
        """Whether it may shine."""
        return any(lobe.kind == layout.EMISSION and may_be_nonzero(lobe.weight) for lobe in self._probe)

    @property
    def has_null(self) -> bool:
        """Whether light may go straight through."""
        return self._may_have({layout.TRANSPARENT, layout.HOLDOUT})

    @property
    def has_deep(self) -> bool:
        """Whether light may go below the surface."""
        return self._may_have({layout.SUBSURFACE})

    @property
    def bends_deep(self) -> bool:
        """Whether it may, and leave about another normal than the surface's own."""
        own = any(layout.HAS_NORMAL in lobe.fields for lobe in self._probe if lobe.kind == layout.SUBSURFACE)
        return self.has_deep and (own or self.relief is not None)

    @property
    def has_rough(self) -> bool:
        """Whether some lobe may be wider than a mirror at the threshold 0."""
        return any(may_be_rough(lobe, 0.0) for lobe in self._probe if may_be_nonzero(lobe.weight))

    def has_sharp(self, threshold: float) -> bool:
        """Whether some lobe may have a roughness below the threshold."""
        return any(may_be_sharp(lobe, threshold) for lobe in self._probe if may_be_nonzero(lobe.weight))

    def may_be_rough(self, threshold: float) -> bool:
        """Whether some lobe may have a roughness of at least the threshold."""
        return any(may_be_rough(lobe, threshold) for lobe in self._probe if may_be_nonzero(lobe.weight))

    def may_be_narrow(self, threshold: float) -> bool:
        """Whether some rough lobe may reflect or refract too narrowly for a photon map."""
        return any(
            may_be_rough(lobe, threshold)
            and (lobe.kind in BENDING_KINDS or may_be_sharp(lobe, layout.NARROW_ROUGHNESS))
            for lobe in self._probe
            if may_be_nonzero(lobe.weight)
        )

    def emission(self, points: ShadePoints | None = None) -> np.ndarray:
        """Radiance of the EMISSION lobes, (n | 1, 3) f32, without what layers above absorb."""
        total = np.zeros((1, 3), np.float32)
        for lobe in self.lobes(points):
            if lobe.kind == layout.EMISSION:
                total = total + lobe.weight
        return total

    def _may_have(self, kinds: set[int]) -> bool:
        """Whether a lobe of these kinds may have weight."""
        return any(lobe.kind in kinds and may_be_nonzero(lobe.weight) for lobe in self._probe)


def may_be_nonzero(weight: np.ndarray) -> bool:
    """False only for a weight that is zero everywhere: varying ones have two rows in the probe."""
    return len(weight) > 1 or bool(np.any(weight != 0.0))


def _roughness(lobe: Lobe) -> np.ndarray:
    """A lobe's roughness field, 0 when it has none."""
    return np.asarray(lobe.fields.get(layout.ROUGHNESS, np.zeros(1)), np.float32)


def may_be_sharp(lobe: Lobe, threshold: float) -> bool:
    """Whether a microfacet lobe may be below the threshold; one whose index varies may bend nothing somewhere."""
    if lobe.kind in BENDING_KINDS and len(lobe.fields[layout.IOR]) > 1:
        return True
    roughness = _roughness(lobe)
    return lobe.kind in SHARP_KINDS and (len(roughness) > 1 or bool(roughness[0] < threshold or is_ideal(roughness[0])))


def may_be_rough(lobe: Lobe, threshold: float) -> bool:
    """Whether a lobe may be a rough one."""
    if lobe.kind not in SHARP_KINDS:
        return lobe.kind in ROUGH_KINDS
    roughness = _roughness(lobe)
    return len(roughness) > 1 or bool(roughness[0] >= threshold and not is_ideal(roughness[0]))


def is_ideal(roughness: np.float32) -> bool:
    """Whether a roughness is none at all for the kernels (bsdf/glass.py), whatever the threshold."""
    return float(roughness) ** 2 <= DELTA_ALPHA


def with_normal(lobes: list[Lobe], normal: np.ndarray) -> list[Lobe]:
    """The lobes, those about the surface's own normal now about this one, outward (n, 3).

    It stands for the surface's shading normal, so that no lobe is darkened for leaning away from that.
    """
    fields = {layout.HAS_NORMAL: np.full(1, layout.DISPLACED), layout.NORMAL: normal}
    return [
        Lobe(lobe.kind, lobe.weight, {**fields, **lobe.fields}) if lobe.kind in ROUGH_KINDS else lobe for lobe in lobes
    ]


def compile_graph(
    graph: Graph, name: str, images: list[Image], issues: IssueLog, target: str = "SHADER"
) -> Program:
    """The program of a graph's surface; target: the kind of value that it gives."""
    graph = expand_bumps(surface_part(graph))
    calls = [_make_call(graph, index, name, images, issues) for index in range(len(graph.nodes))]
    surface = None if graph.surface is None else _source(graph, graph.surface, target)
    varying = _fold(calls)
    needs: set[str] = set()
    live = _reachable(calls, surface, varying)
    for index in live:
        call = calls[index]
        needs |= call.kind.needs(call.node, call.props["used"]) | ({"bump"} if SHIFT in call.props else set())
    program = Program(name, calls, surface, live, frozenset(needs), not live)
    if target == "SHADER":
        program._probe = _probe(program)
    return program


def surface_part(graph: Graph) -> Graph:
    """The graph without the nodes that only its volume or displacement reach."""
    kept: set[int] = set()
    todo = [] if graph.surface is None else [graph.surface.node]
    while todo:
        index = todo.pop()
        if index >= 0 and index not in kept:
            kept.add(index)
            todo.extend(socket.node for socket in graph.nodes[index].inputs.values())
    if len(kept) == len(graph.nodes):
        return graph
    place = {old: new for new, old in enumerate(sorted(kept))}

    def moved(socket: Socket) -> Socket:
        return replace(socket, node=place[socket.node]) if socket.node >= 0 else socket

    used = [graph.nodes[old] for old in sorted(kept)]
    moved_nodes = [replace(item, inputs={k: moved(socket) for k, socket in item.inputs.items()}) for item in used]
    return Graph(moved_nodes, None if graph.surface is None else moved(graph.surface))


def _probe(program: Program) -> list[Lobe]:
    """All lobes that may occur: what varies is given two rows of values inside (0, 1), what is constant keeps its own.

    Recipes leave out lobes that weigh nothing in a batch, so no real batch need show all of them.
    """
    points = probe_points(2)
    values: list = [call.outputs for call in program.calls]
    for index in program.live:
        call = program.calls[index]
        if "SHADER" in call.node.output_kinds.values():
            values[index] = call.run(values, points)
        else:
            values[index] = {name: _generic(kind) for name, kind in call.node.output_kinds.items()}
    return [] if program.surface is None else straightened(fetch(program.surface, values))


def straightened(lobes: list[Lobe]) -> list[Lobe]:
    """The lobes, those of an index that bends nothing as what they are: transparent.

    They reflect nothing either, so shadow rays and photons pass them straight.
    """
    return [as_transparent(lobe) if bends_nothing(lobe) else lobe for lobe in lobes]


def bends_nothing(lobe: Lobe) -> bool:
    """Whether a lobe refracts by an index that is 1 wherever it is."""
    if lobe.kind not in BENDING_KINDS:
        return False
    index = np.asarray(lobe.fields[layout.IOR], np.float32)
    return len(index) == 1 and abs(float(index[0]) - 1.0) < NEARLY_ONE


def as_transparent(lobe: Lobe) -> Lobe:
    """A TRANSPARENT lobe with the colour that a refracting one passes, in the same layer."""
    kept = {layout.GROUP: lobe.fields[layout.GROUP]} if layout.GROUP in lobe.fields else {}
    return Lobe(layout.TRANSPARENT, lobe.weight * np.asarray(lobe.fields.get(layout.COLOR_B, 1.0)), kept)


def _generic(kind: str) -> np.ndarray:
    """Two values of a varying value that is neither 0 nor 1."""
    values = [0.4, 0.6] if kind in SCALARS else [[0.4, 0.5], [0.5, 0.4], [0.6, 0.6]]
    return np.array(values, np.float32)


def _make_call(graph: Graph, index: int, name: str, images: list[Image], issues: IssueLog) -> Call:
    """The call of a node, with the outputs that somebody reads."""
    item = graph.nodes[index]
    used = {socket.output for other in graph.nodes for socket in other.inputs.values() if socket.node == index}
    if graph.surface is not None and graph.surface.node == index:
        used.add(graph.surface.output)
    kind = REGISTRY.get(item.type)
    if kind is None:
        kind = fallback_kind(item)
    report_unsupported(item, used, name, issues)
    inputs = {key: _source(graph, socket, socket.kind) for key, socket in item.inputs.items()}
    for key, source in inputs.items():
        if source.call < 0 and source.value is None and not surface_decides(item.type, key):
            inputs[key] = source._replace(value=zero(source.target))
    return Call(item, kind, inputs, {**item.props, "used": frozenset(used), "images": images})


def surface_decides(node_type: str, name: str) -> bool:
    """Whether an unlinked input means the surface's own normal, tangent or coordinates rather than zero."""
    if name == "Vector":
        return node_type.startswith("ShaderNodeTex")
    if node_type == "ShaderNodeRaycast":
        return True
    return name in ("Normal", "Coat Normal", "Tangent") and node_type != "ShaderNodeNormal"


def _source(graph: Graph, socket: Socket, target: str) -> Source:
    """Where a socket's value comes from."""
    if socket.node < 0:
        return Source(-1, "", socket.kind, target, constant(socket.value, target))
    kind = graph.nodes[socket.node].output_kinds.get(socket.output, "VALUE")
    return Source(socket.node, socket.output, kind, target, None)


def _fold(calls: list[Call]) -> list[bool]:
    """Run what does not vary; returns which calls vary."""
    varying: list[bool] = []
    values: list = []
    for call in calls:
        _prune_mix(call, varying, values)
        varies = call.kind.varies(call.node, call.props["used"]) or any(
            source.call >= 0 and varying[source.call] for source in call.inputs.values()
        )
        varying.append(bool(varies))
        if not varies:
            call.outputs = call.run(values, None)
        values.append(call.outputs)
    return varying


def _prune_mix(call: Call, varying: list[bool], values: list) -> None:
    """Unlink the shader that a constant factor of 0 or 1 hides."""
    if call.node.type != "ShaderNodeMixShader":
        return
    factor = call.inputs["Fac"]
    if factor.call >= 0 and varying[factor.call]:
        return
    t = float(fetch(factor, values)[0])
    hidden = "Shader" if t >= 1.0 else "Shader_001" if t <= 0.0 else None
    if hidden in call.inputs:
        call.inputs[hidden] = call.inputs[hidden]._replace(call=-1, value=[])


def _reachable(calls: list[Call], surface: Source | None, varying: list[bool]) -> list[int]:
    """Varying calls that the surface depends on, in order."""
    seen: set[int] = set()
    todo = [] if surface is None or surface.call < 0 else [surface.call]
    while todo:
        index = todo.pop()
        if index in seen or not varying[index]:
            continue
        seen.add(index)
        todo.extend(source.call for source in calls[index].inputs.values() if source.call >= 0)
    return sorted(seen)


def constant_background(graph: Graph | None) -> tuple[float, float, float] | None:
    """Radiance of a world whose graph does not vary with direction; None: it varies. No graph or surface: black."""
    if graph is None or graph.surface is None:
        return (0.0, 0.0, 0.0)
    program = compile_graph(graph, "World", [], IssueLog())
    if not program.constant:
        return None
    return tuple(float(c) for c in program.emission()[0])
