"""Image Texture and Environment Texture."""

from __future__ import annotations

import numpy as np

from ..registry import f32, node, unlinked
from ..textures import (
    DECODE,
    EXTENSIONS,
    INTERPOLATIONS,
    LINEAR,
    REPEAT,
    UNPREMULTIPLY,
    sample_image,
)
from .coordinates import columns, mapped
from .geometry_inputs import to_object
from .vectors import dot, normalize

MISSING = (1.0, 0.0, 1.0, 1.0)  # magenta, as Cycles shows what it cannot find
FIRST_TILE = 1001  # of a UDIM image; ten to a row
ONE, HALF, INV_PI = f32(1.0), f32(0.5), f32(1.0 / np.pi)


def spherical(x, y, z):
    """Image coordinates of directions on a sphere."""
    radius2 = x * x + y * y
    u = np.where(radius2 > 0.0, HALF * (ONE - np.arctan2(x, y) * INV_PI), f32(0.0))
    size = np.sqrt(radius2 + z * z)
    v = ONE - np.arccos(np.clip(z / np.where(size > 0.0, size, ONE), -1.0, 1.0)) * INV_PI
    return np.stack([u, np.where(size > 0.0, v, f32(0.0))])


def place(vector, projection):
    """Image coordinates of a texture vector: flat, on a sphere or on a tube."""
    if projection not in ("SPHERE", "TUBE"):
        return vector[:2]
    x, y, z = 2.0 * vector - ONE
    if projection == "SPHERE":
        return spherical(x, y, z)
    u = np.where(x * x + y * y > 0.0, HALF * (ONE - np.arctan2(x, y) * INV_PI), f32(0.0))
    return np.stack([u, (z + ONE) * HALF])


def box_weights(n, blend):
    """Weights (3, n) of the sides of a box as a normal n (3, n) sees them; blend: how far two sides overlap, [0, 1].

    The normal's absolute components over their sum are barycentric coordinates in a triangle whose corners show one
    side, its edges two and its middle three.
    """
    a = np.abs(n) / np.abs(n).sum(axis=0)
    x, y, z = a
    limit = HALF * (ONE + f32(blend))
    if blend <= 0.0:
        alone = [(x > limit * (x + y)) & (x > limit * (x + z)), (y > limit * (x + y)) & (y > limit * (y + z)),
                 (z > limit * (x + z)) & (z > limit * (y + z))]
        none = ~(alone[0] | alone[1] | alone[2])
        return np.stack([alone[0] | none, alone[1], alone[2]]).astype(f32)

    def share(p, q):
        total = p + q
        part = np.where(total > 0.0, p / np.where(total > 0.0, total, ONE), f32(0.0))
        return np.clip((part - HALF * (ONE - f32(blend))) / f32(blend), 0.0, 1.0)

    zero = np.zeros_like(x)
    xy, yz, xz = share(x, y), share(y, z), share(x, z)
    sides = [((x > limit * (x + y)) & (x > limit * (x + z)), (ONE + zero, zero, zero)),
             ((y > limit * (x + y)) & (y > limit * (y + z)), (zero, ONE + zero, zero)),
             ((z > limit * (x + z)) & (z > limit * (y + z)), (zero, zero, ONE + zero)),
             (z < (ONE - limit) * (y + x), (xy, ONE - xy, zero)),
             (x < (ONE - limit) * (y + z), (zero, yz, ONE - yz)),
             (y < (ONE - limit) * (x + z), (xz, zero, ONE - xz))]  # fmt: skip
    where = [condition for condition, _ in sides]
    three = ((f32(2.0) - limit) * a + (limit - ONE)) / (f32(2.0) * limit - ONE)
    return np.stack([np.select(where, [side[k] for _, side in sides], three[k]) for k in range(3)])


def box_lookup(vector, points, props, look):
    """A lookup on each side of a box, blended by the object-space normal; look : (2, n) -> (4, n)."""
    n = to_object(points, columns(points.facing(points.ns)))
    weights = box_weights(n, float(props.get("projection_blend", 0.0)))
    x, y, z = np.broadcast_to(vector, n.shape)
    sides = (np.where(n[0] < 0.0, ONE - y, y), z), (np.where(n[1] > 0.0, ONE - x, x), z), (
        np.where(n[2] > 0.0, ONE - y, y), x
    )  # fmt: skip
    total = np.zeros((4, n.shape[1]), f32)
    for weight, uv in zip(weights, sides, strict=True):
        used = np.flatnonzero(weight > 0.0)
        if len(used):
            total[:, used] += weight[used] * look(np.stack([c[used] for c in uv]))
    return total


def look_up(image, images, uv, settings):
    """Colour and alpha (4, n) of an image or its tiles; settings: interpolation, extension, whether alpha is read."""
    if not image.tiles:
        return sample(image, uv, settings)
    out = np.empty((4, uv.shape[1]), f32)
    out[:] = np.array(MISSING, f32)[:, None]
    column, row = np.trunc(uv[0]), np.trunc(uv[1])  # as Cycles: the first tile reaches down to -1
    number = np.where((column >= 0.0) & (column < 10.0) & (row >= 0.0), FIRST_TILE + column + 10.0 * row, 0.0)
    for tile, index in image.tiles.items():
        used = np.flatnonzero(number == tile)
        if len(used):
            corner = np.stack([column[used], row[used]])
            out[:, used] = sample(images[index], uv[:2, used] - corner, settings)
    return out


def sample(image, uv, settings):
    """Colour and alpha (4, n) of one image."""
    mode, extension, with_alpha = settings
    flags = DECODE if image.encoded else 0
    premultiplied = image.colorspace != "Non-Color" and image.alpha_mode not in ("CHANNEL_PACKED", "NONE")
    if premultiplied and with_alpha:  # Cycles gives straight colour only beside its alpha
        flags |= UNPREMULTIPLY
    return sample_image(image.pixels, uv, mode, extension, flags)


def image_varies(item, used) -> bool:
    """A box looks at the normal; without a vector UVs or the direction are read."""
    return unlinked("Vector")(item, used) or item.props.get("projection") == "BOX"


def image_needs(item, used):
    """UVs when no vector is linked; the object's matrix for a box."""
    needs = {"uv"} if unlinked("Vector")(item, used) else set()
    return needs | ({"objects"} if item.props.get("projection") == "BOX" else set())


@node("ShaderNodeTexImage", varies=image_varies, needs=image_needs)
def image_texture(x, props, points):
    """Colour and alpha of an image at the vector, or at the active UV layer."""
    index = props.get("image")
    if index is None:  # no image is chosen
        return {"Color": np.array(MISSING[:3], f32)[:, None], "Alpha": np.ones(1, f32)}
    images, projection = props["images"], props.get("projection", "FLAT")
    mode = INTERPOLATIONS.get(props.get("interpolation", "Linear"), LINEAR)
    settings = mode, EXTENSIONS[props.get("extension", "REPEAT")], "Alpha" in props["used"]
    vector = x.get("Vector")
    if vector is None:
        uv = points.uvs[""].T
        plain = projection == "FLAT" and props.get("texture_mapping") is None
        vector = uv if plain else np.concatenate([uv, np.zeros((1, uv.shape[1]), f32)])
    vector = mapped(vector, props)
    if projection == "BOX":
        out = box_lookup(vector, points, props, lambda uv: look_up(images[index], images, uv, settings))
    else:
        out = look_up(images[index], images, place(vector, projection), settings)
    return {"Color": out[:3], "Alpha": out[3]}


def mirror_ball(d):
    """Image coordinates of unit directions d (3, n) in a photograph of a mirroring ball."""
    x, y, z = d
    size = np.sqrt(np.maximum(HALF * (ONE - y), 0.0))
    half = np.where(size > 0.0, HALF / np.where(size > 0.0, size, ONE), ONE)
    return np.stack([HALF * (x * half + ONE), HALF * (z * half + ONE)])


def equirectangular(d):
    """Image coordinates of directions d (3, n): longitude and latitude."""
    size = np.sqrt(dot(d, d))
    v = ONE - np.arccos(np.clip(d[2] / np.where(size > 0.0, size, ONE), -1.0, 1.0)) * INV_PI
    u = HALF - np.arctan2(d[1], d[0]) * f32(0.5 / np.pi)
    return np.stack([np.where(size > 0.0, u, f32(0.0)), np.where(size > 0.0, v, f32(0.0))])


@node("ShaderNodeTexEnvironment", varies=unlinked("Vector"))
def environment_texture(x, props, points):
    """An image of all directions; without a vector the position, which for a world is the direction."""
    index = props.get("image")
    if index is None:
        return {"Color": np.array(MISSING[:3], f32)[:, None]}
    vector = x.get("Vector")
    d = normalize(mapped(columns(points.world()) if vector is None else vector, props))
    uv = mirror_ball(d) if props.get("projection") == "MIRROR_BALL" else equirectangular(d)
    mode = INTERPOLATIONS.get(props.get("interpolation", "Linear"), LINEAR)
    return {"Color": look_up(props["images"][index], props["images"], uv, (mode, REPEAT, False))[:3]}
