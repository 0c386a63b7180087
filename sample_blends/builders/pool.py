"""A swimming pool in the sun, seen from above the water: caustics on a tiled floor."""

from __future__ import annotations

import math

import numpy as np

from . import common, materials

HALF = 2.0  # of the pool's side [m]
DEPTH = 1.3  # of the floor under the calm water [m]
RIM = 0.12  # of the deck above the water [m]
GRID = 150  # cells of the water along a side
TILES = 10  # along a wall
# amplitude [m], wave length [m], direction [degrees], phase [rad]
WAVES = (
    (0.0200, 1.50, 14.0, 0.3), (0.0150, 1.08, 83.0, 1.9), (0.0110, 0.77, -38.0, 4.1),
    (0.0070, 0.57, 139.0, 2.2), (0.0042, 0.43, 47.0, 5.2), (0.0026, 0.35, 175.0, 0.9),
)


def water_height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the water [m] over the calm level: a sum of plane waves."""
    z = np.zeros_like(x)
    for amplitude, length, degrees, phase in WAVES:
        along = x * math.cos(math.radians(degrees)) + y * math.sin(math.radians(degrees))
        z += amplitude * np.sin(2.0 * math.pi / length * along + phase)
    return z


def water_mesh():
    """An open sheet, its normals up (water below, air above), a little wider than the pool so that no light gets by."""
    side = np.linspace(-HALF - 0.02, HALF + 0.02, GRID + 1)
    x, y = np.meshgrid(side, side)
    positions = np.stack([x, y, water_height(x, y)], axis=-1).reshape(-1, 3)
    index = np.arange((GRID + 1) ** 2).reshape(GRID + 1, GRID + 1)
    faces = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1).reshape(-1, 4)
    return common.mesh_data("Water", positions, faces, smooth=True)


def tile_image():
    """One tile with its grout and a neighbour of another shade: 2x2 tiles in 64x64 pixels."""
    rng = np.random.default_rng(7)
    pixels = np.empty((64, 64, 3), np.float32)
    for row, column in np.ndindex(2, 2):
        shade = np.array([(0.70, 0.87, 0.92), (0.60, 0.82, 0.90)][(row + column) % 2])
        pixels[row * 32 : row * 32 + 32, column * 32 : column * 32 + 32] = shade
    pixels += rng.normal(0.0, 0.008, pixels.shape)
    edge = np.arange(64) % 32
    grout = (edge < 1) | (edge > 30)
    pixels[grout, :] = pixels[:, grout] = (0.90, 0.93, 0.92)
    return materials.add_image("Tiles", np.clip(pixels, 0.0, 1.0))


def add_walls(scene, tiles) -> None:
    """Floor and four walls, facing inward, the tiles of the same size everywhere."""
    h, low, high = HALF, -DEPTH, RIM
    count = TILES / 2  # an image holds two tiles
    rows = count * (high - low) / (2 * h)
    common.quad(scene, "Floor", [(-h, -h, low), (h, -h, low), (h, h, low), (-h, h, low)], tiles, (count, count))
    ring = [(-h, -h), (h, -h), (h, h), (-h, h)]
    for k, name in enumerate(("South", "East", "North", "West")):
        a, b = ring[(k + 1) % 4], ring[k]
        common.quad(scene, f"Wall {name}", [(*a, low), (*b, low), (*b, high), (*a, high)], tiles, (count, rows))


def add_deck(scene) -> None:
    """Four slabs of stone around the pool."""
    stone = materials.diffuse("Stone", (0.62, 0.55, 0.46))
    h, far = HALF, HALF + 3.0
    for name, (x0, x1, y0, y1) in {
        "South": (-far, far, -far, -h), "North": (-far, far, h, far), "West": (-far, -h, -h, h), "East": (h, far, -h, h)
    }.items():
        common.quad(scene, f"Deck {name}", [(x0, y0, RIM), (x1, y0, RIM), (x1, y1, RIM), (x0, y1, RIM)], stone)


def build(sun_angle: float = 0.00918):
    """The pool under a sun (of half a degree unless told otherwise, [rad]) and a blue sky of one colour."""
    scene = common.new_scene("pool")
    common.set_world(scene, (0.35, 0.56, 0.95), 0.35)
    add_walls(scene, materials.textured_diffuse("Pool Tiles", tile_image()))
    add_deck(scene)
    water = water_mesh()
    water.materials.append(materials.glass("Water", (0.97, 1.0, 1.0), ior=1.333))
    common.link(scene, "Water", water)
    common.add_light(scene, "SUN", "Sun", (1.6, 1.2, 3.4), (0, 0, 0), 4.0, angle=sun_angle, color=(1.0, 0.95, 0.86))
    common.add_camera(scene, (0.0, -4.0, 3.4), (0.0, -0.28, -0.5), 37.0)
    return scene
