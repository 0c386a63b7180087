"""What is visible in the evaluated scene: objects and instances, their place, slots and flags."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..issues import IssueLog
from ..scene.data import Instance
from .lights import report_light_linking
from .places import Places
from .unsupported import report_object

# geometry that does not become a mesh, as users know it
UNSUPPORTED = {
    "VOLUME": "volumes", "CURVES": "hair curves", "POINTCLOUD": "point clouds", "GREASEPENCIL": "grease pencil objects",
    "GPENCIL": "grease pencil objects",
}  # fmt: skip


class Occurrence(NamedTuple):
    """One object or instance: valid only while the depsgraph's iterator stands on it."""

    object: Any  # the evaluated object; of an instance: what is instanced
    parent: Any  # the instancer; the object itself when there is none
    matrix: np.ndarray  # (4, 4) f64, local to world
    random: float  # Object Info > Random, [0, 1)
    source: Any  # the depsgraph's object instance


def visible_occurrences(depsgraph: Any, places: Places, issues: IssueLog) -> Iterator[Occurrence]:
    """All that the evaluated scene shows, lamps and geometry alike, in Blender's order."""
    hidden = hidden_in_render(depsgraph) if depsgraph.mode == "VIEWPORT" else frozenset()
    for item in depsgraph.object_instances:
        ob = item.object
        parent = item.parent if item.is_instance else ob
        if parent.name_full in hidden:
            continue
        if item.show_particles and has_hair(ob):
            issues.warn(ob.name, "particle hair is not supported yet: it is not rendered")
        if not item.show_self:
            continue
        if ob.type in UNSUPPORTED:
            issues.warn(ob.name, f"{UNSUPPORTED[ob.type]} are not supported yet: it is not rendered")
            continue
        yield Occurrence(ob, parent, places.of_instance(item), random_number(item, ob), item)


def hidden_in_render(depsgraph: Any) -> frozenset[str]:
    """Names of objects that a final render would not show.

    Only a viewport depsgraph needs this: it holds what the viewport shows.
    """
    shown: set[str] = set()

    def visit(layer: Any) -> None:
        if layer.exclude or layer.collection.hide_render:
            return
        shown.update(ob.name_full for ob in layer.collection.objects if not ob.hide_render)
        for child in layer.children:
            visit(child)

    visit(depsgraph.view_layer.layer_collection)
    return frozenset(ob.name_full for ob in depsgraph.view_layer.objects) - shown


def has_hair(ob: Any) -> bool:
    """Whether the object has particle systems that Cycles would draw as strands."""
    return any(
        system.settings.type == "HAIR" and system.settings.render_type == "PATH" and system.settings.count > 0
        for system in ob.particle_systems
    )


def make_instance(
    item: Occurrence, mesh: int, materials: list[int], view_layer: Any, issues: IssueLog
) -> Instance | None:
    """The record of a visible mesh occurrence; None when no ray may see it."""
    ob, parent = item.object, item.parent
    name = ob.name if parent.name == ob.name else f"{parent.name}/{ob.name}"
    if not np.isfinite(item.matrix).all():
        issues.warn(name, "its transform is undefined: it is not rendered", "look for a broken driver or constraint")
        return None
    holdout = parent.holdout_get(view_layer=view_layer)
    indirect_only = not holdout and parent.indirect_only_get(view_layer=view_layer)
    visible = {
        ray: getattr(ob, f"visible_{ray}") and getattr(parent, f"visible_{ray}")
        for ray in ("camera", "diffuse", "glossy", "transmission", "shadow")
    }
    if indirect_only:
        visible["camera"] = False
    if not any(visible.values()):
        return None
    report_object(ob, name, issues)
    report_light_linking(ob, issues)
    instance = object_facts(item, mesh, materials, name)
    instance.holdout = holdout
    instance.visible_camera, instance.visible_shadow = visible["camera"], visible["shadow"]
    instance.terminator_offset = ob.shadow_terminator_geometry_offset
    return instance


def object_facts(item: Occurrence, mesh: int, materials: list[int], name: str) -> Instance:
    """What nodes may ask about an occurrence, lamps included (which have no mesh)."""
    ob = item.object
    color = tuple(float(c) for c in ob.color)
    return Instance(mesh, item.matrix, materials, name, color=color, pass_index=ob.pass_index, random=item.random)


def slot_materials(ob: Any, override: Any | None) -> list[Any | None]:
    """The material of each slot: the object's where the slot is linked to the object, else the mesh's."""
    mesh_slots = list(ob.data.materials)
    slots = ob.material_slots
    out = []
    for i in range(max(len(mesh_slots), len(slots))):
        if i < len(slots) and slots[i].link == "OBJECT":
            out.append(slots[i].material)
        else:
            out.append(mesh_slots[i] if i < len(mesh_slots) else None)
    return [override] * max(1, len(out)) if override is not None else out


def random_number(item: Any, ob: Any) -> float:
    """Object Info > Random as in Cycles: a hash of the name, or the instance's own number, over 2^32."""
    if item.is_instance:
        return (item.random_id & 0xFFFFFFFF) / 2.0**32
    return jenkins_hash(name_hash(ob.name), 0) / 2.0**32


def name_hash(name: str) -> int:
    """Hash of a string: h = 37 h + byte (unsigned, UTF-8), 32 bits."""
    h = 0
    for byte in name.encode():
        h = (h * 37 + byte) & 0xFFFFFFFF
    return h


def jenkins_hash(kx: int, ky: int) -> int:
    """Bob Jenkins' lookup3 hash of two 32-bit words, final mix [http://burtleburtle.net/bob/c/lookup3.c]."""
    mask = 0xFFFFFFFF

    def rot(x: int, k: int) -> int:
        return ((x << k) | (x >> (32 - k))) & mask

    start = (0xDEADBEEF + (2 << 2) + 13) & mask
    a, b, c = (start + kx) & mask, (start + ky) & mask, start
    c = ((c ^ b) - rot(b, 14)) & mask
    a = ((a ^ c) - rot(c, 11)) & mask
    b = ((b ^ a) - rot(a, 25)) & mask
    c = ((c ^ b) - rot(b, 16)) & mask
    a = ((a ^ c) - rot(c, 4)) & mask
    b = ((b ^ a) - rot(a, 14)) & mask
    return ((c ^ b) - rot(b, 24)) & mask
