"""A material's program: its surface, displacement shown as bump, and what its inside absorbs."""

from __future__ import annotations

from ..issues import IssueLog
from ..scene.data import Graph, Image, Material, SceneData
from .absorption import absorption_of, with_surface
from .fallback import report_counts, report_falloff
from .program import Program, compile_graph
from .relief import displacement_normal


def compile_material(material: Material, images: list[Image], issues: IssueLog) -> Program:
    """A material's program; nodes that are not supported are reported once by material and node name."""
    program = compile_graph(with_surface(material.graph), material.name, images, issues)
    program.absorption = absorption_of(material, images, issues)
    report_falloff(material.graph, material.name, issues)
    if program.emits:
        report_counts(material.graph, material.name, issues)
    bump = displacement_normal(material.graph) if material.displacement in ("BUMP", "BOTH") else None
    if bump is not None and program.surface is not None:
        program.relief = compile_graph(bump, material.name, images, issues, "VECTOR")
        program.needs = program.needs | program.relief.needs
        program.constant = False
    if (offset := offset_program(material, images, issues)) is not None:
        program.needs = program.needs | offset.needs
    return program


def offset_program(material: Material, images: list[Image], issues: IssueLog) -> Program | None:
    """The program whose value is the displacement (3, n) of vertices in the world [m]; None: they stay."""
    graph = material.graph
    if material.displacement == "BUMP" or graph.displacement is None or graph.displacement.node < 0:
        return None
    return compile_graph(Graph(graph.nodes, graph.displacement), material.name, images, issues, "VECTOR")


def refracting_materials(scene: SceneData) -> frozenset[int]:
    """Indices of the materials that may refract, by their nodes: a material too many does no harm."""
    return frozenset(i for i, material in enumerate(scene.materials) if may_refract(material.graph))


def may_refract(graph: Graph) -> bool:
    """Whether a graph has a node that refracts; a Principled BSDF does where its transmission is not 0."""
    for node in graph.nodes:
        if node.type in ("ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"):
            return True
        weight = node.inputs.get("Transmission Weight")
        if node.type == "ShaderNodeBsdfPrincipled" and weight is not None and (weight.node >= 0 or weight.value):
            return True
    return False
