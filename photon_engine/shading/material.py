"""A material's program: its surface, displacement shown as bump, and what its inside absorbs."""

from __future__ import annotations

from ..issues import IssueLog
from ..scene.data import Image, Material
from .absorption import absorption_of, with_surface
from .program import Program, compile_graph
from .relief import displacement_normal


def compile_material(material: Material, images: list[Image], issues: IssueLog) -> Program:
    """A material's program; nodes that are not supported are reported once by material and node name."""
    program = compile_graph(with_surface(material.graph), material.name, images, issues)
    program.absorption = absorption_of(material, images, issues)
    bump = displacement_normal(material.graph) if material.displacement in ("BUMP", "BOTH") else None
    if bump is not None and program.surface is not None:
        program.relief = compile_graph(bump, material.name, images, issues, "VECTOR")
        program.needs = program.needs | program.relief.needs
        program.constant = False
    return program
