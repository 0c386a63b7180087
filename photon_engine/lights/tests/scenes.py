"""Lamps of every kind, each in a table of its own."""

import numpy as np

from ...scene.data import Light, SceneData, World
from ..sky import make_map
from ..table import Emitters, build_lights

CENTER = np.zeros(3)
RADIUS = 5.0


def frame(position=(0.0, 0.0, 2.0), towards=(0.0, 0.0, 0.0), scale=(1.0, 1.0, 1.0), roll=0.0):
    """Matrix of an object at `position` whose -Z looks at `towards`."""
    z = np.subtract(position, towards).astype(float)
    z /= np.linalg.norm(z)
    x = np.cross((0.3, 1.0, 0.2), z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = np.cos(roll), np.sin(roll)
    m = np.eye(4)
    m[:3, :3] = np.stack([c * x + s * y, c * y - s * x, z], 1) * scale
    m[:3, 3] = position
    return m


TILTED = frame((0.6, -0.4, 2.0), (0.1, 0.2, 0.0), roll=0.4)
RGB = (10.0, 6.0, 3.0)


def lamp(kind, matrix=TILTED, **options):
    return Light(kind.lower(), kind, matrix, options.pop("strength", RGB), **options)


# a map of directions with colours, and a ring that is dark
SHARES = np.random.default_rng(8).uniform(0.3, 1.0, (17, 8, 3)).astype(np.float32)
SHARES[10] = 0.0

LAMPS = {
    "mapped point": lamp("POINT", beam=SHARES),
    "mapped soft point": lamp("POINT", radius=0.4, beam=SHARES),
    "mapped spot": lamp("SPOT", spot_size=1.2, spot_blend=0.5, radius=0.2, soft_falloff=False, beam=SHARES),
    "mapped square": lamp("AREA", size=(0.8, 9.0), beam=SHARES),
    "mapped spread": lamp("AREA", frame((0.2, 0.1, 1.5)), size=(1.0, 1.0), spread=1.2, beam=SHARES),
    "mapped sun": lamp("SUN", angle=0.3, beam=SHARES),
    "point": lamp("POINT"),
    "sphere": lamp("POINT", radius=0.4, soft_falloff=False),
    "sphere not normalised": lamp("POINT", radius=0.4, soft_falloff=False, normalize=False),
    "soft point": lamp("POINT", radius=0.5),
    "spot": lamp("SPOT", spot_size=0.8, spot_blend=0.5),
    "spot sphere": lamp("SPOT", spot_size=1.0, spot_blend=0.3, radius=0.2, soft_falloff=False),
    "soft spot": lamp("SPOT", spot_size=1.2, spot_blend=0.2, radius=0.4),
    "scaled spot": lamp(
        "SPOT", frame((0.6, -0.4, 2.0), (0.1, 0.2, 0.0), (1.0, 2.0, 0.7)), spot_size=0.8, spot_blend=0.7
    ),
    "sharp spot": lamp("SPOT", spot_size=0.9, spot_blend=0.0),
    "square": lamp("AREA", size=(0.8, 9.0)),
    "rectangle": lamp(
        "AREA", frame((0.3, 0.1, 0.5), (0.0, 0.1, 0.0), (1.0, 2.0, 3.0)), shape="RECTANGLE", size=(1.5, 0.4)
    ),
    "disk": lamp("AREA", shape="DISK", size=(0.8, 9.0)),
    "ellipse": lamp("AREA", frame((0.1, 0.0, 0.4)), shape="ELLIPSE", size=(1.5, 0.7)),
    "far ellipse": lamp("AREA", frame((1.0, 0.5, 4.0)), shape="ELLIPSE", size=(0.5, 0.7)),
    "spread square": lamp("AREA", frame((0.2, 0.1, 1.5)), size=(1.0, 1.0), spread=0.6),
    "spread ellipse": lamp("AREA", frame((0.2, 0.1, 1.0)), shape="ELLIPSE", size=(1.6, 1.0), spread=1.5),
    "wide spread": lamp("AREA", size=(0.7, 0.7), spread=3.0),
    "beam": lamp("AREA", frame((0.2, 0.1, 1.5)), size=(1.0, 1.0), spread=0.0),
    "sun": lamp("SUN"),
    "sun disk": lamp("SUN", angle=0.3),
    "sun not normalised": lamp("SUN", angle=1.0, normalize=False),
}
DELTAS = {"point", "mapped point", "spot", "scaled spot", "sharp spot", "beam", "sun"}

TRIANGLES = np.array(
    [[[0.5, -1.0, 1.0], [1.5, 0.5, 1.5], [0.3, 0.4, 1.8]], [[-1.0, 0.0, 1.0], [-1.2, 1.0, 1.4], [-0.4, 0.2, 0.9]]],
    np.float32,
)
EMITTERS = Emitters(
    np.array([5, 2], np.int32),
    TRIANGLES[:, 0],
    TRIANGLES[:, 1],
    TRIANGLES[:, 2],
    np.array([[3.0, 2.0, 1.0], [1.0, 4.0, 9.0]], np.float32),
)
NO_EMITTERS = Emitters(np.zeros(0, np.int32), *(np.zeros((0, 3), np.float32) for _ in range(4)))
WORLD = World(color=(0.5, 0.4, 0.2))


def sky_map():
    """A small sky: dim, with a broad glow, a sun of two texels and a black band."""
    rng = np.random.default_rng(4)
    radiance = rng.uniform(0.1, 0.4, (16, 32, 3))
    radiance[2:6, 4:10] += (2.0, 1.5, 1.0)
    radiance[5, 20:22] = (90.0, 80.0, 60.0)
    radiance[12] = 0.0
    return make_map(radiance.astype(np.float32))


def table(lamps=(), emitters=NO_EMITTERS, world=None, **options):
    scene = SceneData(lights=list(lamps), world=world or World())
    options = {"center": CENTER, "radius": RADIUS, "origin": np.zeros(3)} | options
    return build_lights(scene, emitters, 8, **options)


# every light as the only one of its scene
SINGLE = {name: (lambda item=item: table([item])) for name, item in LAMPS.items()} | {
    "mesh": lambda: table(emitters=EMITTERS),
    "world": lambda: table(world=WORLD),
    "sky": lambda: table(sky=sky_map()),
}
