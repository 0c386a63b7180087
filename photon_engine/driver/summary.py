"""What a scene holds and what would run, for people and scripts, without rendering."""

from __future__ import annotations

from collections import Counter
from typing import Any

from ..film.passes import ALL_NAMES
from ..issues import IssueLog
from ..plan import Line, make_plan
from ..scene.data import SceneData
from ..settings import Settings
from ..shading.material import compile_material
from ..shading.program import Program
from ..shading.textures import texture_bytes
from ..survey import survey


def summarize(
    scene: SceneData, settings: Settings, issues: IssueLog, outputs: frozenset[str] = ALL_NAMES
) -> dict[str, Any]:
    """Plain values; compiles the materials, so that what they do not support comes into `issues`."""
    facts = survey(scene, settings.specular_threshold, compile_materials(scene, issues), settings.plan)
    plan = make_plan(scene, settings, outputs, facts)
    used = Counter(instance.mesh for instance in scene.instances)
    triangles = {i: len(mesh.triangles) for i, mesh in enumerate(scene.meshes)}
    frame, camera = scene.frame, scene.camera
    return {
        "scene": scene.name,
        "frame": scene.frame_number,
        "resolution": [frame.width, frame.height],
        "border": [frame.x0, frame.y0, frame.x1, frame.y1],
        "camera": f"{camera.name} ({camera.kind})",
        "meshes": len(scene.meshes),
        "instances": len(scene.instances),
        "triangles": sum(triangles[mesh] * n for mesh, n in used.items()),
        "materials": [material.name for material in scene.materials],
        "images": [image.name for image in scene.images],
        "image_mb": texture_bytes(scene.images) / 1e6,
        "nodes": dict(Counter(node.type for material in scene.materials for node in material.graph.nodes)),
        "lights": [f"{light.name} ({light.kind})" for light in scene.lights],
        "world": scene.world.name,
        "plan": [line._asdict() for line in plan.lines()],
        "settings": settings.to_dict(),
    }


def compile_materials(scene: SceneData, issues: IssueLog) -> list[Program]:
    """Compile each material as a render does, for its issues."""
    return [compile_material(material, scene.images, issues) for material in scene.materials]


def summary_text(record: dict[str, Any], issues: IssueLog) -> str:
    """The summary in lines."""
    width, height = record["resolution"]
    x0, y0, x1, y1 = record["border"]
    border = "" if (x1 - x0, y1 - y0) == (width, height) else f", border x {x0}-{x1}, y {y0}-{y1}"
    settings = record["settings"]
    budget = [f"{settings['passes']} passes"] if settings["passes"] else []
    budget += [f"{settings['seconds']:g} s"] if settings["seconds"] else []
    rows = {
        "scene": f"{record['scene']}, frame {record['frame']}",
        "picture": f"{width} x {height}{border}",
        "camera": record["camera"],
        "objects": f"{record['instances']} of {record['meshes']} meshes, {record['triangles']} triangles",
        "materials": ", ".join(record["materials"]) or "none",
        "images": f"{', '.join(record['images'])}: {record['image_mb']:.3g} MB" if record["images"] else "none",
        "lights": ", ".join(record["lights"]) or "none",
        "budget": " or ".join(budget) or "no limit",
        "photons": f"{settings['caustic_photons']} caustic, {settings['diffuse_photons']} diffuse in each pass",
    }
    lines = [f"{name + ':':<11}{text}" for name, text in rows.items()]
    lines.append("plan:")
    lines += [f"  {Line(**item)}" for item in record["plan"]]
    lines.append("issues:    " + ("none" if not len(issues) else ""))
    lines += [f"  {issue.severity.value}: {issue}" for issue in issues]
    return "\n".join(lines)
