"""What the inside of a surface absorbs, from the volume part of its graph."""

from __future__ import annotations

import numpy as np

from ..bsdf import layout
from ..issues import IssueLog
from ..scene.data import Graph, Image, Material, Node, Socket
from .program import compile_graph

# inputs by which a volume does more than absorb unless they are 0
ACTIVE = {
    "ShaderNodeVolumeScatter": {"Density": "scatters"},
    "ShaderNodeVolumePrincipled": {
        "Color": "scatters", "Emission Strength": "shines", "Blackbody Intensity": "shines",
    },
    "ShaderNodeVolumeCoefficients": {"Scatter Coefficients": "scatters", "Emission Coefficients": "shines"},
}  # fmt: skip
ONLY_ABSORPTION = "only its absorption is rendered"
PASSES = "Transparent"


def absorption_of(material: Material, images: list[Image], issues: IssueLog) -> np.ndarray | None:
    """Absorption coefficient of the inside, (3,) f64 [1/m]; None: no volume. What else a volume does is reported."""
    graph = material.graph
    if graph.volume is None or graph.volume.node < 0:
        return None
    for item in graph.nodes:
        report_active(item, material.name, issues)
    inside = compile_graph(Graph(graph.nodes, graph.volume), material.name, images, issues)
    if not inside.constant:
        issues.warn(material.name, "a volume that varies is not supported yet", "the inside is empty")
        return None
    sigma = [np.asarray(lobe.weight, np.float64)[0] for lobe in inside.lobes() if lobe.kind == layout.ABSORPTION]
    return sum(sigma, np.zeros(3))


def report_active(item: Node, material: str, issues: IssueLog) -> None:
    """Warn about what a volume node does beyond absorbing."""
    for name, verb in ACTIVE.get(item.type, {}).items():
        socket = item.inputs.get(name)
        if socket is None:
            continue
        if socket.node >= 0 or (socket.value is not None and np.any(np.atleast_1d(socket.value)[:3])):
            issues.warn(f"{material} > {item.name}", f"a volume that {verb} is not supported yet", ONLY_ABSORPTION)


def with_surface(graph: Graph) -> Graph:
    """The graph; one that has only a volume gets a transparent surface, as in Cycles."""
    if graph.surface is not None or graph.volume is None or graph.volume.node < 0:
        return graph
    clear = Node("ShaderNodeBsdfTransparent", PASSES, {}, {"Color": Socket([1.0, 1.0, 1.0, 1.0], kind="RGBA")},
                 {"BSDF": "SHADER"})  # fmt: skip
    surface = Socket(None, len(graph.nodes), "BSDF", "SHADER")
    return Graph([*graph.nodes, clear], surface, graph.volume, graph.displacement)
