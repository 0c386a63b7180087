"""A furnished room without anything that shines, lit by sun and sky through a window: colour bleeding."""

from __future__ import annotations

from . import common, materials

WIDTH, DEPTH, HEIGHT = 4.0, 4.4, 2.6  # of the room [m]
WINDOW = (-0.6, 1.1, 0.75, 2.2)  # y0, y1, z0, z1 in the right wall
WALL = 0.18  # thickness [m]


def add_shell(scene) -> None:
    """Floor, ceiling and walls as boxes, so that no light comes in but through the window."""
    w, d, h, t = WIDTH / 2, DEPTH / 2, HEIGHT, WALL
    white = materials.diffuse("White", (0.80, 0.79, 0.76))
    red = materials.diffuse("Red", (0.66, 0.13, 0.08))
    wood = materials.diffuse("Wood", (0.46, 0.29, 0.16))
    common.box(scene, "Floor", (2 * w + 2 * t, 2 * d + 2 * t, t), (0, 0, -t), wood)
    common.box(scene, "Ceiling", (2 * w + 2 * t, 2 * d + 2 * t, t), (0, 0, h), white)
    common.box(scene, "Left Wall", (t, 2 * d, h), (-w - t / 2, 0, 0), red)
    common.box(scene, "Back Wall", (2 * w + 2 * t, t, h), (0, d + t / 2, 0), white)
    common.box(scene, "Front Wall", (2 * w + 2 * t, t, h), (0, -d - t / 2, 0), white)
    y0, y1, z0, z1 = WINDOW
    x = w + t / 2
    common.box(scene, "Right Wall Near", (t, y0 + d, h), (x, (y0 - d) / 2, 0), white)
    common.box(scene, "Right Wall Far", (t, d - y1, h), (x, (y1 + d) / 2, 0), white)
    common.box(scene, "Sill", (t, y1 - y0, z0), (x, (y0 + y1) / 2, 0), white)
    common.box(scene, "Lintel", (t, y1 - y0, h - z1), (x, (y0 + y1) / 2, z1), white)


def add_window_frame(scene) -> None:
    """A cross of wood in the window, for a shadow that can be read."""
    paint = materials.diffuse("Frame", (0.75, 0.74, 0.70))
    y0, y1, z0, z1 = WINDOW
    x = WIDTH / 2 + WALL * 0.6
    common.box(scene, "Mullion", (0.05, 0.05, z1 - z0), (x, (y0 + y1) / 2, z0), paint)
    common.box(scene, "Transom", (0.04, y1 - y0, 0.05), (x, (y0 + y1) / 2, z0 + 0.62 * (z1 - z0)), paint)


def add_furniture(scene) -> None:
    """A bench with cushions, a table with a vase, a rug, a picture."""
    blue = materials.diffuse("Blue", (0.10, 0.24, 0.52))
    cream = materials.diffuse("Cream", (0.78, 0.70, 0.55))
    oak = materials.diffuse("Oak", (0.55, 0.38, 0.21))
    clay = materials.diffuse("Clay", (0.72, 0.36, 0.20))
    green = materials.diffuse("Green", (0.18, 0.42, 0.16))
    common.box(scene, "Bench", (1.9, 0.7, 0.38), (-0.35, 1.75, 0), cream)
    common.box(scene, "Bench Back", (1.9, 0.16, 0.42), (-0.35, 2.04, 0.38), cream)
    common.box(scene, "Cushion Blue", (0.42, 0.16, 0.36), (-0.95, 1.85, 0.38), blue, 0.2)
    common.box(scene, "Cushion Green", (0.40, 0.16, 0.34), (0.28, 1.85, 0.38), green, -0.25)
    common.box(scene, "Rug", (2.0, 1.5, 0.015), (-0.2, 0.45, 0), blue, 0.12)
    common.box(scene, "Table Top", (0.8, 0.55, 0.04), (-0.15, 0.55, 0.40), oak, 0.3)
    for k, (x, y) in enumerate(((-0.30, -0.18), (0.30, -0.18), (0.30, 0.18), (-0.30, 0.18))):
        place = (-0.15 + 0.955 * x - 0.296 * y, 0.55 + 0.296 * x + 0.955 * y, 0)
        common.box(scene, f"Leg {k}", (0.05, 0.05, 0.40), place, oak, 0.3)
    vase = [(0.0, 0.0), (0.05, 0.0), (0.085, 0.06), (0.09, 0.10), (0.07, 0.16), (0.04, 0.20), (0.035, 0.235),
            (0.05, 0.26), (0.042, 0.262), (0.028, 0.235), (0.032, 0.20), (0.0, 0.02)]
    positions, faces, _ = common.lathe(vase, 48)
    mesh = common.mesh_data("Vase", positions, faces, smooth=True)
    mesh.materials.append(clay)
    common.link(scene, "Vase", mesh, (-0.05, 0.55, 0.44))
    ball = common.unit_ball("Ball", 5)
    ball.materials.append(clay)
    common.link(scene, "Ball", ball, (0.85, 0.35, 0.18)).scale = (0.18,) * 3
    common.box(scene, "Picture", (0.03, 1.0, 0.7), (-1.985, 0.75, 1.15), cream)
    common.box(scene, "Picture Inner", (0.02, 0.8, 0.5), (-1.965, 0.75, 1.25), green)


def build():
    """The room, the sun in the window, a sky of one colour, the camera inside."""
    scene = common.new_scene("diffuse_room")
    common.set_world(scene, (0.55, 0.75, 1.0), 2.0)
    add_shell(scene)
    add_window_frame(scene)
    add_furniture(scene)
    common.add_light(scene, "SUN", "Sun", (3.6, -1.1, 1.9), (0, 0, 0), 24.0, angle=0.02, color=(1.0, 0.92, 0.80))
    common.add_camera(scene, (0.75, -2.1, 1.45), (-0.28, 0.9, 0.92), 62.0)
    return scene
