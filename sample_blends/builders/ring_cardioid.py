"""A polished ring on a table beside a small lamp: the nephroid, the caustic of a coffee cup."""

from __future__ import annotations

from . import common, materials

RADIUS = 0.5  # inner [m]
THICKNESS = 0.03
HEIGHT = 0.22
SEGMENTS = 360


def ring_mesh(radius: float, thickness: float, height: float, segments: int):
    """A flat-topped ring, its walls smooth, its edges sharp (each strip has vertices of its own)."""
    outer = radius + thickness
    bevel = 0.006
    strips = [
        [(radius, height - bevel), (radius, 0.0)],
        [(outer, 0.0), (outer, height - bevel)],
        [(outer, height - bevel), (outer - bevel, height)],
        [(outer - bevel, height), (radius + bevel, height)],
        [(radius + bevel, height), (radius, height - bevel)],
    ]
    positions, faces = [], []
    for strip in strips:
        points, quads, _ = common.lathe(strip, segments)
        faces += [[index + len(positions) for index in face] for face in quads]
        positions += points
    return common.mesh_data("Ring", positions, faces, smooth=True)


def build(lamp_radius: float = 0.02):
    """A gold ring on a white table, lit from the side by a small sphere (of the same power whatever its size)."""
    scene = common.new_scene("ring_cardioid")
    common.set_world(scene, (0.55, 0.7, 1.0), 0.05)
    table = materials.diffuse("Table", (0.72, 0.68, 0.62))
    common.quad(scene, "Table", [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], table)
    mesh = ring_mesh(RADIUS, THICKNESS, HEIGHT, SEGMENTS)
    mesh.materials.append(materials.principled("Gold", Base_Color=(1.0, 0.77, 0.34), Metallic=1.0, Roughness=0.0))
    common.link(scene, "Ring", mesh, (0, 0, 0.0005))
    common.add_light(
        scene, "POINT", "Lamp", (1.15, -0.75, 0.95), (0, 0, 0), 80.0, shadow_soft_size=lamp_radius,
        use_soft_falloff=False, color=(1.0, 0.95, 0.88),
    )
    common.add_camera(scene, (0.0, -1.45, 2.05), (0.0, -0.02, 0.03), 34.0)
    return scene
