"""Which mesh data a material reads: what its compiled program looks up, so that nothing else is extracted."""

from __future__ import annotations

from collections.abc import Iterable

from ..issues import IssueLog
from ..scene.data import Image, Material
from ..shading.material import compile_material
from .meshes import MeshNeeds


def merge_needs(needs: Iterable[MeshNeeds]) -> MeshNeeds:
    """All that any of the materials needs."""
    out = MeshNeeds()
    for item in needs:
        out = MeshNeeds(
            out.generated or item.generated,
            out.attributes | item.attributes,
            out.tangents | item.tangents,
            out.uvs | item.uvs,
            out.islands or item.islands,
        )
    return out


def needs_of(material: Material, images: list[Image]) -> MeshNeeds:
    """What a material reads of a mesh beyond positions and normals; hidden branches of its graph read nothing."""
    program = compile_material(material, images, IssueLog())  # its issues are told when the render compiles it
    found: dict[str, set[str]] = {}
    for need in program.needs:
        kind, _, name = need.partition(":")
        found.setdefault(kind, set()).add(name)
    tangents = frozenset(found.get("tangent", ()))
    return MeshNeeds(
        "generated" in found, frozenset(found.get("attribute", ())), tangents,
        tangents | frozenset(found.get("uv", ())), "island" in found,
    )  # fmt: skip
