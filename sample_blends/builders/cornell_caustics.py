"""The Cornell box with a ball of glass and one of mirror under a small lamp: caustics on floor, wall and ceiling."""

from __future__ import annotations

from . import common, materials

POWER = 20.0  # W
GAP = 0.005  # of the lamp below the ceiling [m]


def build(light_size: float = 0.1):
    """A box of 2 m, open in front; a square lamp of `light_size` [m] with the same power whatever its size."""
    scene = common.new_scene("cornell_caustics")
    white = materials.diffuse("White", (0.76, 0.75, 0.72))
    red = materials.diffuse("Red", (0.62, 0.06, 0.05))
    green = materials.diffuse("Green", (0.12, 0.46, 0.10))
    common.quad(scene, "Floor", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], white)
    common.quad(scene, "Ceiling", [(-1, 1, 2), (1, 1, 2), (1, -1, 2), (-1, -1, 2)], white)
    common.quad(scene, "Back", [(-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)], white)
    common.quad(scene, "Left", [(-1, -1, 0), (-1, 1, 0), (-1, 1, 2), (-1, -1, 2)], red)
    common.quad(scene, "Right", [(1, 1, 0), (1, -1, 0), (1, -1, 2), (1, 1, 2)], green)

    ball = common.unit_ball("Ball")  # one mesh, the material belongs to each object
    ball.materials.append(None)
    for name, radius, place, material in (
        ("Mirror Ball", 0.40, (-0.46, 0.36), materials.glossy("Mirror", (0.95, 0.93, 0.88))),
        ("Glass Ball", 0.34, (0.44, -0.28), materials.glass("Glass")),
    ):
        item = common.link(scene, name, ball, (*place, radius + 0.001))
        item.scale = (radius,) * 3
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = material

    common.add_light(
        scene, "AREA", "Lamp", (0, 0, 2 - GAP), (0, 0, 0), POWER, shape="SQUARE", size=light_size,
        color=(1.0, 0.93, 0.82),
    )
    common.add_camera(scene, (0, -4.35, 1.0), (0, 0, 1.0), 33.2)
    return scene
