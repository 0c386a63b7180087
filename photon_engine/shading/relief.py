"""Bump as a change of the graph: what a height depends on is computed at the point and at two neighbours.

Like Cycles: every Bump node gets its height's nodes three times, those of the neighbours marked to run on shifted
points (`ShadePoints.around`). Displacement that is only shown as bump becomes one Bump node of its own.
"""

from __future__ import annotations

from dataclasses import replace

from ..scene.data import Graph, Node, Socket

BUMP = "ShaderNodeBump"
HEIGHT = "PhotonHeight"
SHIFT = "shift"  # setting of a copied node: (axis 0 or 1, filter width)
DEFAULT_WIDTH = 0.1  # of Cycles' own filter for displacement [pixels]


def expand_bumps(graph: Graph) -> Graph:
    """The graph with inputs "Height dx" and "Height dy" on every Bump node whose height is linked."""
    if not any(_needs_neighbours(item) for item in graph.nodes):
        return graph
    nodes: list[Node] = []
    place: dict[int, int] = {}
    for old, item in enumerate(graph.nodes):
        moved = replace(item, inputs={name: _moved(socket, place) for name, socket in item.inputs.items()})
        if _needs_neighbours(moved):
            height = moved.inputs["Height"]
            width = moved.inputs["Filter Width"].value if "Filter Width" in moved.inputs else None
            width = float(width or DEFAULT_WIDTH)
            moved.props = {**item.props, "width": width}
            for axis, name in enumerate(("Height dx", "Height dy")):
                moved.inputs[name] = replace(height, node=_copy(nodes, height.node, (axis, width)))
        place[old] = len(nodes)
        nodes.append(moved)
    sockets = {name: getattr(graph, name) for name in ("surface", "volume", "displacement")}
    return Graph(nodes, **{name: None if s is None else _moved(s, place) for name, s in sockets.items()})


def _needs_neighbours(item: Node) -> bool:
    """Whether a node is a Bump with something to differentiate."""
    return item.type == BUMP and "Height" in item.inputs and item.inputs["Height"].node >= 0


def _moved(socket: Socket, place: dict[int, int]) -> Socket:
    """The socket with its link renumbered."""
    return replace(socket, node=place[socket.node]) if socket.node >= 0 else socket


def _copy(nodes: list[Node], top: int, shift: tuple[int, float]) -> int:
    """Append copies of a node and all it depends on, marked with the shift; out: where the copy of `top` is."""
    wanted: set[int] = set()
    todo = [top]
    while todo:
        index = todo.pop()
        if index not in wanted:
            wanted.add(index)
            todo.extend(socket.node for socket in nodes[index].inputs.values() if socket.node >= 0)
    place: dict[int, int] = {}
    for index in sorted(wanted):
        item = nodes[index]
        inputs = {name: _moved(socket, place) for name, socket in item.inputs.items()}
        place[index] = len(nodes)
        nodes.append(replace(item, inputs=inputs, props={**item.props, SHIFT: shift}))
    return place[top]


def displacement_normal(graph: Graph) -> Graph | None:
    """A graph whose surface is the normal (VECTOR) that the displacement, taken as a bump, gives; None without one."""
    if graph.displacement is None or graph.displacement.node < 0:
        return None
    n = len(graph.nodes)
    height = Node(HEIGHT, "Displacement", {}, {"Displacement": replace(graph.displacement, kind="VECTOR")},
                  {"Height": "VALUE"})  # fmt: skip
    constants = {"Strength": 1.0, "Distance": 1.0, "Filter Width": DEFAULT_WIDTH}
    inputs = {name: Socket(value) for name, value in constants.items()}
    inputs["Height"] = Socket(0.0, n, "Height")
    inputs["Normal"] = Socket(None, kind="VECTOR")
    bump = Node(BUMP, "Displacement", {}, inputs, {"Normal": "VECTOR"})
    return Graph([*graph.nodes, height, bump], Socket(None, n + 1, "Normal", "VECTOR"))
