"""Blender's node trees as Graphs: groups, reroutes, muted nodes and links resolved, only what the output reaches."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..issues import IssueLog
from ..scene.data import Graph, Node, Socket
from .compat import INLINED_TREES, resolved, uses_nodes
from .images import ImageTable
from .node_props import coerce, node_props, socket_value

GROUPS = {"GROUP", "CUSTOM GROUP"}  # an add-on's groups are entered too, as Cycles does


class Scope(NamedTuple):
    """A tree as it stands inside the group nodes that lead to it."""

    tree: Any  # bpy NodeTree
    links: dict[tuple[str, str], Any]  # (node name, input identifier) -> link
    path: tuple[str, ...]  # names of the group nodes, outermost first
    group: Any = None  # the group node in `parent`
    parent: Any = None  # Scope


class Origin(NamedTuple):
    """What feeds an input: an output of a real node, or (node None) a constant."""

    scope: Scope | None
    node: Any
    output: Any  # bpy output socket
    value: Any
    kind: str  # socket type the value has
    through: tuple[str, ...] = ()  # socket types of group interfaces and reroutes passed, nearest the input first


@dataclass
class Builder:
    """State while a tree is turned into a Graph."""

    owner: str  # the data-block, for messages
    images: ImageTable
    issues: IssueLog
    graph: Graph = field(default_factory=Graph)
    done: dict[tuple, int] = field(default_factory=dict)  # node key -> index in graph.nodes
    open: set[tuple] = field(default_factory=set)  # nodes being visited: meeting one again is a cycle


def material_graph(material: Any, images: ImageTable, issues: IssueLog) -> Graph:
    """The graph of a bpy material; without nodes a diffuse of the viewport colour."""
    if not uses_nodes(material):
        return diffuse_graph(tuple(material.diffuse_color)[:3])
    return block_graph(material, images, issues)


def world_graph(world: Any, images: ImageTable, issues: IssueLog) -> Graph:
    """The graph of a bpy world; without nodes its colour."""
    if not uses_nodes(world):
        return background_graph(tuple(world.color)[:3])
    return block_graph(world, images, issues)


def light_graph(light: Any, images: ImageTable, issues: IssueLog) -> Graph | None:
    """The graph of a bpy light, whose emission multiplies its strength; None: it has no nodes."""
    if not uses_nodes(light):
        return None
    return block_graph(light, images, issues)


def block_graph(block: Any, images: ImageTable, issues: IssueLog) -> Graph:
    """The graph of a data-block that uses nodes."""
    holder = resolved(block)
    graph = tree_graph(holder.node_tree, block.name, images, issues)
    if holder is not block:  # Blender numbers the nodes it resolves
        for node in graph.nodes:
            node.name = node.name.lstrip("0123456789").removeprefix("_") or node.name
    return graph


def diffuse_graph(color: tuple[float, float, float]) -> Graph:
    """A single Diffuse BSDF."""
    inputs = {"Color": Socket([*color, 1.0], kind="RGBA"), "Roughness": Socket(0.0)}
    node = Node("ShaderNodeBsdfDiffuse", "Viewport Color", {}, inputs, {"BSDF": "SHADER"})
    return Graph([node], Socket(None, 0, "BSDF", "SHADER"))


def background_graph(color: tuple[float, float, float]) -> Graph:
    """A single Background."""
    inputs = {"Color": Socket([*color, 1.0], kind="RGBA"), "Strength": Socket(1.0)}
    node = Node("ShaderNodeBackground", "World Color", {}, inputs, {"Background": "SHADER"})
    return Graph([node], Socket(None, 0, "Background", "SHADER"))


def tree_graph(tree: Any, owner: str, images: ImageTable, issues: IssueLog) -> Graph:
    """The graph that a tree's active output for Cycles reaches; no output: an empty graph."""
    builder = Builder(owner, images, issues)
    output = tree.get_output_node("CYCLES")
    if output is None:
        issues.warn(owner, "the node tree has no active output for Cycles or all renderers", "add an output node")
        return builder.graph
    scope = Scope(tree, input_links(tree, builder), ())
    for name in ("Surface", "Volume", "Displacement"):
        socket = output.inputs.get(name)
        if socket is None or (output.name, socket.identifier) not in scope.links:
            continue
        setattr(builder.graph, name.lower(), _resolve(builder, scope, output, socket))
    return builder.graph


def input_links(tree: Any, builder: Builder) -> dict[tuple[str, str], Any]:
    """The link of each linked input; muted and invalid links are left out."""
    links = {}
    for link in tree.links:
        if link.is_muted or link.to_socket.is_unavailable or link.from_socket.is_unavailable:
            continue
        if not link.is_valid:
            text = f"the link from {link.from_node.name} to {link.to_node.name} is not valid (a cycle or wrong types)"
            builder.issues.warn(builder.owner, text, "it is ignored")
            continue
        links[(link.to_node.name, link.to_socket.identifier)] = link
    return links


def _resolve(builder: Builder, scope: Scope, node: Any, socket: Any) -> Socket:
    """The Socket of an input, with all nodes it depends on appended to the graph, inputs first."""
    results: list[Socket] = []
    frames = [_Frame(None, None, [(scope, node, socket)])]  # depth first without recursion
    while frames:
        frame = frames[-1]
        if frame.next < len(frame.todo):
            _step(builder, frames, frame)
            continue
        frames.pop()
        if frame.origin is None:
            results.append(frame.sockets[0][1])
        else:
            _close(builder, frames[-1], frame)
    return results[0]


@dataclass
class _Frame:
    """A node whose inputs are being resolved; origin None: the graph's own output."""

    key: tuple | None
    origin: Origin | None
    todo: list[tuple]  # (scope, node, socket)
    next: int = 0
    sockets: list[tuple[str, Socket]] = field(default_factory=list)


def _step(builder: Builder, frames: list[_Frame], frame: _Frame) -> None:
    """Resolve the next input of a frame, or open a frame for the node behind it."""
    scope, node, socket = frame.todo[frame.next]
    origin = trace(scope, node, socket)
    if origin.node is None:
        _take(builder, frame, origin)
        return
    key = (*origin.scope.path, origin.node.name)
    if key in builder.done:
        _take(builder, frame, origin)
    elif key in builder.open:
        text = f"the nodes around {'/'.join(key)} form a cycle"
        builder.issues.warn(builder.owner, text, "the input's own value is used")
        _take(builder, frame, _own_value(socket))
    else:
        builder.open.add(key)
        todo = [(origin.scope, origin.node, s) for s in origin.node.inputs if not s.is_unavailable]
        frames.append(_Frame(key, origin, todo))


def _take(builder: Builder, frame: _Frame, origin: Origin) -> None:
    """Store what feeds the frame's current input and go on to the next."""
    socket = frame.todo[frame.next][2]
    frame.sockets.append((socket.identifier, _to_socket(builder, origin, socket)))
    frame.next += 1


def _close(builder: Builder, parent: _Frame, frame: _Frame) -> None:
    """Append a node whose inputs are complete, then give it to the input that asked for it."""
    origin = frame.origin
    node = origin.node
    outputs = {s.identifier: s.type for s in node.outputs if not s.is_unavailable}
    name = "/".join((*origin.scope.path, node.name))
    props = node_props(node, builder.images)
    builder.graph.nodes.append(Node(node.bl_idname, name, props, dict(frame.sockets), outputs))
    builder.done[frame.key] = len(builder.graph.nodes) - 1
    builder.open.discard(frame.key)
    _take(builder, parent, origin)


def _to_socket(builder: Builder, origin: Origin, socket: Any) -> Socket:
    """A Socket from what feeds it, with the conversions of the interfaces in between."""
    if origin.node is None:
        value = origin.value
        kind = origin.kind
        for passed in (*_interfaces(origin), socket.type):
            value, kind = coerce(value, kind, passed), passed
        return Socket(value, kind=socket.type)
    index = builder.done[(*origin.scope.path, origin.node.name)]
    output, kind = origin.output.identifier, origin.output.type
    for passed in _interfaces(origin):
        if _loses(kind, passed):
            index, output, kind = _conversion(builder, index, output, kind, passed), "Value", passed
    return Socket(socket_value(socket), index, output, socket.type)


def _interfaces(origin: Origin) -> tuple[str, ...]:
    """Socket types on the way that convert the value; since 5.0 groups, reroutes and muted nodes do not."""
    return () if INLINED_TREES else tuple(reversed(origin.through))


def _loses(kind: str, passed: str) -> bool:
    """Whether a value changes by passing a socket of another type."""
    scalars = {"VALUE", "INT", "BOOLEAN"}
    return kind != passed and "SHADER" not in (kind, passed) and (passed in scalars or kind in scalars)


def _conversion(builder: Builder, index: int, output: str, kind: str, passed: str) -> int:
    """A node that only converts, for an interface of another type on the way."""
    key = ("", index, output, passed)
    if key not in builder.done:
        inputs = {"Value": Socket(None, index, output, passed)}
        name = f"{builder.graph.nodes[index].name} as {passed}"
        builder.graph.nodes.append(Node("PhotonConvert", name, {}, inputs, {"Value": passed}))
        builder.done[key] = len(builder.graph.nodes) - 1
    return builder.done[key]


def _own_value(socket: Any, through: tuple[str, ...] = ()) -> Origin:
    """An input's constant."""
    return Origin(None, None, None, socket_value(socket), socket.type, through)


def trace(scope: Scope, node: Any, socket: Any) -> Origin:
    """What feeds an input, through reroutes, muted nodes and group borders."""
    through: tuple[str, ...] = ()
    keeper, keeper_through = socket, through  # whose value holds when the way ends without a source
    while True:
        link = scope.links.get((node.name, socket.identifier))
        passes = node.type == "REROUTE" or node.mute
        if not passes:
            keeper, keeper_through = socket, through
        if link is None and passes and not INLINED_TREES:
            return Origin(None, None, None, 0.0, "VALUE", through)
        if link is None:
            return _own_value(keeper, keeper_through)
        source, output = link.from_node, link.from_socket
        entered = _enter(scope, source, output)
        if entered is None:
            return Origin(scope, source, output, None, output.type, through)
        scope, node, inner = entered
        if inner is None:
            return _own_value(keeper, keeper_through)
        socket = inner
        through = (*through, output.type)


def _enter(scope: Scope, node: Any, output: Any) -> tuple[Scope, Any, Any] | None:
    """The input behind an output of a node that only passes values on; None: a node that computes."""
    if node.mute:
        inner = next((link for link in node.internal_links if link.to_socket == output), None)
        return scope, node, inner.from_socket if inner else None
    if node.type == "REROUTE":
        return scope, node, node.inputs[0]
    if node.type == "GROUP_INPUT" and scope.group is not None:
        return scope.parent, scope.group, by_identifier(scope.group.inputs, output.identifier)
    if node.type in GROUPS:
        if node.node_tree is None:
            return scope, node, None
        inside = _inside(scope, node)
        end = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
        return inside, end, by_identifier(end.inputs, output.identifier) if end else None
    return None


def _inside(scope: Scope, group: Any) -> Scope:
    """The scope of a group's tree."""
    links = {}
    for link in group.node_tree.links:
        if link.is_valid and not (link.is_muted or link.to_socket.is_unavailable or link.from_socket.is_unavailable):
            links[(link.to_node.name, link.to_socket.identifier)] = link
    return Scope(group.node_tree, links, (*scope.path, group.name), group, scope)


def by_identifier(sockets: Any, identifier: str) -> Any:
    """The socket with that identifier, or None."""
    return next((socket for socket in sockets if socket.identifier == identifier), None)
