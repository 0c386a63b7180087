"""From an evaluated Blender scene to ``SceneData``."""

from __future__ import annotations

from typing import Any

from ..issues import IssueLog
from ..scene.data import Graph, Instance, Material, Mesh, Node, SceneData, Socket
from ..shading.material import compile_material
from ..shading.owners import asks_owner, with_owner
from .attributes import instance_attribute, particle_of, view_layer_attribute, wanted_attributes
from .cameras import extract_camera, extract_frame
from .compat import DEFAULT_PRINCIPLED
from .images import ImageTable
from .instances import Occurrence, make_instance, object_facts, slot_materials, visible_occurrences
from .keep import Keep
from .lights import extract_light
from .meshes import MeshNeeds, worn_slots
from .needs import merge_needs, needs_of
from .node_trees import light_graph, material_graph, world_graph
from .places import Places
from .unsupported import report_material, report_scene
from .visibility import FLAGS, grey_graph, hidden_rays, report_hidden, see_through
from .world import extract_world

NO_MATERIAL = 0  # no data-block has this address


def extract_scene(
    depsgraph: Any, issues: IssueLog, *, view_layer: Any = None, camera: Any = None, keep: Keep | None = None
) -> SceneData:
    """All that a render needs of the evaluated scene, as plain records.

    ``view_layer`` (evaluated) defaults to the depsgraph's; ``camera`` is an object used instead of the scene's. What
    ``keep`` knows parts of the last extraction and is given those of this one. What cannot be rendered is reported in
    ``issues``; a RenderError is raised when nothing can be (no camera).
    """
    scene = depsgraph.scene_eval
    layer = view_layer if view_layer is not None else depsgraph.view_layer_eval
    data = SceneData(name=scene.name, frame_number=scene.frame_current)
    places = Places()
    data.camera = extract_camera(scene, depsgraph, places, issues, camera)
    data.frame = extract_frame(scene)
    report_scene(scene, layer, issues)
    extraction = _Extraction(data, scene, layer, issues, keep or Keep())
    for item in visible_occurrences(depsgraph, places, issues):
        extraction.add(item)
    extraction.read_meshes()
    extraction.read_world()
    data.images = extraction.images.images
    return data


class _Extraction:
    """Tables that grow while the occurrences are walked: each data-block is read once."""

    def __init__(self, data: SceneData, scene: Any, layer: Any, issues: IssueLog, keep: Keep) -> None:
        self.data = data
        self.scene = scene
        self.layer = layer
        self.issues = issues
        self.keep = keep
        self.images = ImageTable(issues, keep)
        self.images.frame = data.frame_number
        # address of the material, rays that do not see it -> index
        self._materials: dict[tuple[int, tuple[str, ...]], int] = {}
        self._unread: set[tuple[int, tuple[str, ...]]] = set()  # those that nothing wears so far
        self._glowing: set[int] = set()  # materials that should be hidden from some rays, and are not
        self._worn: dict[int, frozenset[int]] = {}  # address of the mesh -> slots that its faces name
        self._light_graphs: dict[int, Graph | None] = {}
        self._meshes: dict[int, int] = {}  # address of the mesh -> index into sources
        self._sources: list[tuple[Any, str, set[int]]] = []  # mesh, owner, materials on it

    def add(self, item: Occurrence) -> None:
        """Take in one lamp or mesh; other kinds of object hold no light or surface."""
        block = item.object.data
        if item.object.type == "LIGHT":
            self._add_light(item)
        elif self.layer.use_solid and block is not None and block.rna_type.identifier == "Mesh":
            self._add_mesh(item)

    def _add_light(self, item: Occurrence) -> None:
        block = item.object.data
        key = block.as_pointer()
        if key not in self._light_graphs:
            graph = self._light_graphs[key] = light_graph(block, self.images, self.issues)
            self._fill_in(graph)
        graph = self._light_graphs[key]
        if graph is not None and any(asks_owner(node) for node in graph.nodes):
            owner = object_facts(item, -1, [], item.object.name)
            self._add_properties(owner, [graph], item)
            graph = with_owner(graph, owner)
        light = extract_light(item.object, item.matrix, graph, self.issues, self.images.images)
        if light is not None:
            self.data.lights.append(light)

    def _add_mesh(self, item: Occurrence) -> None:
        block = item.object.data
        slots = slot_materials(item.object, self.layer.material_override) or [None]
        worn = self._worn_slots(block, len(slots))
        rays = hidden_rays(item.object, item.parent)
        hidden = tuple(ray for ray in rays if ray in FLAGS)
        materials = [self._material(material, slot in worn, hidden) for slot, material in enumerate(slots)]
        report_hidden(item.object.name, rays, not self._glowing.isdisjoint(materials), self.issues)
        # instances of one mesh share it whatever their materials; the mesh must serve the needs of all of them
        index = self._meshes.setdefault(block.as_pointer(), len(self._sources))
        if index == len(self._sources):
            self._sources.append((block, item.object.name, set()))
        self._sources[index][2].update(m for m in materials if m >= 0)
        instance = make_instance(item, index, materials, self.layer, self.issues)
        if instance is not None:
            self._add_properties(instance, [self.data.materials[m].graph for m in materials if m >= 0], item)
            self.data.instances.append(instance)

    def _add_properties(self, instance: Instance, graphs: list[Graph], item: Occurrence) -> None:
        """What the nodes of these graphs ask about the instance's object."""
        for kind, name in frozenset().union(*(wanted_attributes(graph) for graph in graphs)):
            instance.attributes[f"{kind}:{name}"] = instance_attribute(item.source, kind, name)
        if any(node.type == "ShaderNodeParticleInfo" for graph in graphs for node in graph.nodes):
            instance.particle = particle_of(item.source, float(self.data.frame_number))

    def _worn_slots(self, block: Any, count: int) -> frozenset[int]:
        """Which of `count` slots a mesh's faces wear; a number beyond the last is the last."""
        if count == 1:
            return frozenset({0})
        key = block.as_pointer()
        if key not in self._worn:
            self._worn[key] = worn_slots(block)
        return frozenset(min(slot, count - 1) for slot in self._worn[key])

    def _material(self, material: Any | None, worn: bool, hidden: tuple[str, ...]) -> int:
        """Index of a material's graph; for an empty slot that of Blender's default, -1 when it is grey Lambert.

        One that no face wears has its name only: neither its nodes nor its images are read. hidden : kinds of ray
        that do not see the object, to which it is transparent
        """
        if material is None:
            return self._default_material(hidden) if worn and (DEFAULT_PRINCIPLED or hidden) else -1
        key = material.as_pointer(), hidden
        if key not in self._materials:
            self._materials[key] = len(self.data.materials)
            self._unread.add(key)
            self.data.materials.append(Material(material.name, Graph()))
        if worn and key in self._unread:
            self._unread.remove(key)
            graph = material_graph(material, self.images, self.issues)
            self._fill_in(graph, material.pass_index)
            report_material(material, self.issues)
            method = getattr(material, "displacement_method", "BUMP")
            index = self._materials[key]
            self.data.materials[index] = Material(material.name, graph, method)
            if hidden and self._glows(index):
                self._glowing.add(index)
            else:
                self.data.materials[index] = Material(material.name, see_through(graph, hidden), method)
        return self._materials[key]

    def _glows(self, index: int) -> bool:
        """Whether a material may give light: what samples it has no kind of ray."""
        return compile_material(self.data.materials[index], self.images.images, IssueLog()).emits

    def _fill_in(self, graph: Graph | None, material_index: int = 0) -> None:
        """What nodes ask that is known here: properties of the view layer, the material's index."""
        for node in graph.nodes if graph is not None else ():
            if node.type == "ShaderNodeAttribute" and node.props.get("attribute_type") == "VIEW_LAYER":
                name = node.props.get("attribute_name", "")
                node.props["value"] = list(view_layer_attribute(self.scene, self.layer, name))
            elif node.type == "ShaderNodeObjectInfo":
                node.props["material_index"] = material_index

    def _default_material(self, hidden: tuple[str, ...]) -> int:
        """Index of a Principled BSDF with default values, of grey Lambert in Blender 4.5."""
        key = NO_MATERIAL, hidden
        if key not in self._materials:
            self._materials[key] = len(self.data.materials)
            node = Node("ShaderNodeBsdfPrincipled", "Principled BSDF", output_kinds={"BSDF": "SHADER"})
            graph = Graph([node], Socket(node=0, output="BSDF", kind="SHADER")) if DEFAULT_PRINCIPLED else grey_graph()
            self.data.materials.append(Material("(no material)", see_through(graph, hidden)))
        return self._materials[key]

    def read_world(self) -> None:
        """Read what lights the scene from infinity."""
        world = (self.layer.world_override or self.scene.world) if self.layer.use_sky else None
        graph = world_graph(world, self.images, self.issues) if world is not None else None
        self._fill_in(graph)
        self.data.world = extract_world(world, graph, self.issues)

    def read_meshes(self) -> None:
        """Read every mesh that an instance shows, and drop those without faces together with their instances."""
        used = {instance.mesh for instance in self.data.instances}
        needs = [needs_of(material, self.images.images) for material in self.data.materials]
        new_index: dict[int, int] = {}
        for i, (block, owner, materials) in enumerate(self._sources):
            if i not in used:
                continue
            wanted = merge_needs([MeshNeeds(), *(needs[m] for m in materials)])
            mesh = self.keep.mesh(block, owner, wanted, self.issues)
            if mesh is not None:
                new_index[i] = len(self.data.meshes)
                self.data.meshes.append(mesh)
        self.keep.end()
        self.data.instances = [instance for instance in self.data.instances if instance.mesh in new_index]
        for instance in self.data.instances:
            instance.mesh = new_index[instance.mesh]
            _pad_slots(instance, self.data.meshes[instance.mesh])


def _pad_slots(instance: Instance, mesh: Mesh) -> None:
    """Give every slot that a triangle names an entry: beyond the last slot the last one counts, as in Cycles."""
    slots = 1 if mesh.material_index is None else int(mesh.material_index.max()) + 1
    last = instance.materials[-1] if instance.materials else -1
    instance.materials = instance.materials + [last] * (slots - len(instance.materials))
