"""What the engine costs Blender before it renders: enabling the extension, reading a large mesh. Prints JSON."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import bpy


def enabling() -> float:
    """Seconds to import and register the extension."""
    start = time.perf_counter()
    import photon_engine

    photon_engine.register()
    return time.perf_counter() - start


def million_triangles() -> dict[str, float]:
    """Seconds to read a million triangles with normals, UVs and slots, first and again."""
    from photon_engine.blender.meshes import MeshNeeds, extract_mesh
    from photon_engine.issues import IssueLog

    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708)
    bpy.ops.object.shade_smooth()
    mesh = bpy.context.object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    seconds = {}
    for name in ("cold", "warm"):
        start = time.perf_counter()
        extract_mesh(mesh, "Grid", MeshNeeds(uvs=frozenset({""})), IssueLog())
        seconds[name] = time.perf_counter() - start
    return seconds


if __name__ == "__main__":
    print(json.dumps({"enabling_seconds": enabling(), "million_triangles_seconds": million_triangles()}))
    sys.stdout.flush()
    os._exit(0)  # Blender as a module can hang while the interpreter shuts down
