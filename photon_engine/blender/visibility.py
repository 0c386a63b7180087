"""Ray Visibility of objects and the world, as nodes: what some rays do not see is transparent, or black, to them.

Light Path tells a node which kind of ray looks, by Cycles' rules. Shadow rays and light that is sampled have no kind:
what casts a shadow is a setting of its own. Light on rough surfaces is brought by photons, which are of no kind either
on the surface that they leave: they see an object that is hidden from diffuse or rough glossy rays.
"""

from __future__ import annotations

from typing import Any

from ..issues import IssueLog
from ..scene.data import Graph, Node, Socket

FLAGS = {"camera": "Is Camera Ray", "glossy": "Is Glossy Ray", "transmission": "Is Transmission Ray"}
NAME = "Ray Visibility"  # of the nodes, for messages
BLACK, WHITE = [0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]


def hidden_rays(*objects: Any) -> tuple[str, ...]:
    """Rays from surfaces that do not see an object, or the instance that objects make together."""
    rays = ("diffuse", "glossy", "transmission")
    return tuple(ray for ray in rays if not all(getattr(ob, f"visible_{ray}") for ob in objects))


def report_hidden(name: str, rays: tuple[str, ...], glows: bool, issues: IssueLog) -> None:
    """Say which rays see an object that is hidden from them."""
    seen = [ray for ray in rays if glows or ray == "diffuse"]
    if seen:
        what = " on what glows" if glows else ""
        issues.warn(name, f"Ray Visibility > {', '.join(seen)} is not supported{what}: such rays see it")
    elif rays:
        issues.info(name, f"is hidden from {' and '.join(rays)} rays, but for rough ones: photons bring their light")


def see_through(graph: Graph, rays: tuple[str, ...]) -> Graph:
    """A surface's graph that lets such rays pass."""
    inputs = {"Color": Socket(WHITE, kind="RGBA")}
    return _without(graph, rays, Node("ShaderNodeBsdfTransparent", NAME, {}, inputs, {"BSDF": "SHADER"}))


def dark(graph: Graph, rays: tuple[str, ...]) -> Graph:
    """A world's graph that is black to such rays."""
    inputs = {"Color": Socket(BLACK, kind="RGBA"), "Strength": Socket(0.0)}
    return _without(graph, rays, Node("ShaderNodeBackground", NAME, {}, inputs, {"Background": "SHADER"}))


def grey_graph() -> Graph:
    """What an object without a material wears: Lambert of 0.8."""
    inputs = {"Color": Socket([0.8, 0.8, 0.8, 1.0], kind="RGBA"), "Roughness": Socket(0.0)}
    node = Node("ShaderNodeBsdfDiffuse", "Diffuse BSDF", {}, inputs, {"BSDF": "SHADER"})
    return Graph([node], Socket(node=0, output="BSDF", kind="SHADER"))


def _without(graph: Graph, rays: tuple[str, ...], instead: Node) -> Graph:
    """The graph with another closure for some kinds of ray: a Mix Shader for each."""
    if graph.surface is None or not rays:
        return graph
    nodes = list(graph.nodes)
    surface = graph.surface
    (output,) = instead.output_kinds
    nodes.append(instead)
    other = len(nodes) - 1
    nodes.append(Node("ShaderNodeLightPath", NAME, {}, {}, dict.fromkeys(FLAGS.values(), "VALUE")))
    path = len(nodes) - 1
    for ray in rays:
        inputs = {
            "Fac": Socket(node=path, output=FLAGS[ray]), "Shader": surface,
            "Shader_001": Socket(node=other, output=output, kind="SHADER"),
        }  # fmt: skip
        nodes.append(Node("ShaderNodeMixShader", NAME, {}, inputs, {"Shader": "SHADER"}))
        surface = Socket(node=len(nodes) - 1, output="Shader", kind="SHADER")
    return Graph(nodes, surface, graph.volume, graph.displacement)
