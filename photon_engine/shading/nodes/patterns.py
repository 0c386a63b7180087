"""Regular textures: Checker, Gradient, Wave, Magic, Brick."""

from __future__ import annotations

import numpy as np

from ..procedural.perlin import FBM, noise_rows
from ..registry import f32, node
from .coordinates import texture_needs, texture_varies, texture_vector
from .procedural import NO_COLOR, gather_rows, spread
from .scalars import smoothstep
from .vectors import dot

ONE, HALF, TWO_PI = f32(1.0), f32(0.5), f32(2.0 * np.pi)
looks = {"varies": texture_varies, "needs": texture_needs}


def nudged(v):
    """A place moved a little, so that whole numbers fall on one side of an edge."""
    return (v + f32(1e-6)) * f32(0.999999)


def grey(f):
    """A number as colour and factor."""
    return {"Fac": f, "Color": np.broadcast_to(f, (3, len(f)))}


@node("ShaderNodeTexChecker", **looks)
def checker(x, props, points):
    """Cubes of two colours."""
    cell = np.floor(nudged(texture_vector(x, props, points) * x["Scale"]))
    i, j, k = np.abs(cell) % 2.0 == 1.0
    first = (i == j) == k
    return {"Color": np.where(first, x["Color1"], x["Color2"]), "Fac": first.astype(f32)}


@node("ShaderNodeTexGradient", **looks)
def gradient(x, props, points):
    """A ramp from 0 to 1."""
    v, kind = texture_vector(x, props, points), props.get("gradient_type", "LINEAR")
    a, b = v[0], v[1]
    if kind == "LINEAR":
        f = a
    elif kind == "QUADRATIC":
        f = np.maximum(a, 0.0) ** 2
    elif kind == "EASING":
        f = smoothstep(np.clip(a, 0.0, 1.0))
    elif kind == "DIAGONAL":
        f = (a + b) * HALF
    elif kind == "RADIAL":
        f = np.arctan2(b, a) * f32(0.5 / np.pi) + HALF
    else:
        r = np.maximum(f32(0.999999) - np.sqrt(dot(v, v)), 0.0)
        f = r * r if kind == "QUADRATIC_SPHERE" else r
    return grey(np.clip(f, 0.0, 1.0))


def wave_phase(p, props):
    """Phase [rad] of the bands or rings at p (3, n)."""
    if props.get("wave_type", "BANDS") == "BANDS":
        direction = props.get("bands_direction", "X")
        if direction == "DIAGONAL":
            return (p[0] + p[1] + p[2]) * f32(10.0)
        return p["XYZ".index(direction)] * f32(20.0)
    direction = props.get("rings_direction", "X")
    used = [p[k] for k in range(3) if "XYZ"[k] != direction]
    return np.sqrt(sum(c * c for c in used)) * f32(20.0)


@node("ShaderNodeTexWave", **looks)
def wave(x, props, points):
    """Bands or rings, bent by noise."""
    p = nudged(texture_vector(x, props, points) * x["Scale"])
    phase = wave_phase(p, props) + x["Phase Offset"]
    if x["Distortion"].any():
        parameters = gather_rows([x["Detail"], x["Detail Roughness"], np.full(1, 2.0, f32), None, None, None])
        places = spread(gather_rows([*(p * x["Detail Scale"]), None]), parameters)
        bend = np.empty(places.shape[1], f32)
        noise_rows(places, parameters, FBM, 3, True, bend, NO_COLOR)
        phase = phase + x["Distortion"] * (bend * 2.0 - ONE)
    profile = props.get("wave_profile", "SIN")
    if profile == "SIN":
        return grey(HALF + HALF * np.sin(phase - f32(0.5 * np.pi)))
    turns = phase / TWO_PI
    if profile == "SAW":
        return grey(turns - np.floor(turns))
    return grey(np.abs(turns - np.floor(turns + HALF)) * f32(2.0))


# each step of the Magic texture: which of x, y, z it replaces, by which function of which signed sum
MAGIC_STEPS = (
    (1, np.cos, -1.0, (1.0, -1.0, 1.0)), (0, np.cos, 1.0, (1.0, -1.0, -1.0)), (2, np.sin, 1.0, (-1.0, -1.0, -1.0)),
    (0, np.cos, -1.0, (-1.0, 1.0, -1.0)), (1, np.sin, -1.0, (-1.0, 1.0, 1.0)), (1, np.cos, -1.0, (-1.0, 1.0, 1.0)),
    (0, np.cos, 1.0, (1.0, 1.0, 1.0)), (2, np.sin, 1.0, (1.0, 1.0, -1.0)), (0, np.cos, -1.0, (-1.0, -1.0, 1.0)),
    (1, np.sin, -1.0, (1.0, -1.0, 1.0)),
)  # fmt: skip


@node("ShaderNodeTexMagic", **looks)
def magic(x, props, points):
    """Psychedelic colours: sines of sines."""
    p = np.fmod(texture_vector(x, props, points) * x["Scale"], TWO_PI)
    distortion, depth = x["Distortion"], int(props.get("turbulence_depth", 2))
    values = [
        np.sin((p[0] + p[1] + p[2]) * f32(5.0)), np.cos((-p[0] + p[1] - p[2]) * f32(5.0)),
        -np.cos((-p[0] - p[1] + p[2]) * f32(5.0)),
    ]  # fmt: skip
    if depth > 0:
        values = [value * distortion for value in values]
    for target, function, sign, signs in MAGIC_STEPS[:depth]:
        total = sum(f32(s) * value for s, value in zip(signs, values, strict=True))
        values[target] = f32(sign) * function(total) * distortion
    twice = np.where(distortion != 0.0, distortion * f32(2.0), ONE)
    color = np.stack([HALF - value / twice for value in values])
    return {"Color": color, "Fac": (color[0] + color[1] + color[2]) * f32(1.0 / 3.0)}


def brick_tint(row, brick, bias):
    """A number in [0, 1] for each brick, by an integer hash."""
    n = ((row.astype(np.int64) << 16) + (brick.astype(np.int64) & 0xFFFF)).astype(np.uint32)
    n = (n + np.uint32(1013)) & np.uint32(0x7FFFFFFF)
    n = (n >> np.uint32(13)) ^ n
    n = (n * (n * n * np.uint32(60493) + np.uint32(19990303)) + np.uint32(1376312589)) & np.uint32(0x7FFFFFFF)
    return np.clip(HALF * (n.astype(f32) / f32(1073741824.0)) + bias, 0.0, 1.0)


def remainder_of(row, frequency: int):
    """Row modulo the frequency, not 0 where C's remainder is not."""
    return np.fmod(row, f32(frequency)) != 0.0


@node("ShaderNodeTexBrick", **looks)
def brick(x, props, points):
    """Rows of bricks and mortar."""
    p = texture_vector(x, props, points) * x["Scale"]
    height, width = x["Row Height"], x["Brick Width"]
    row = np.floor(p[1] / height)
    offset = f32(0.0)
    every, squash_every = int(props.get("offset_frequency", 2)), int(props.get("squash_frequency", 2))
    if every and squash_every:
        width = width * np.where(remainder_of(row, squash_every), ONE, f32(props.get("squash", 1.0)))
        offset = np.where(remainder_of(row, every), f32(0.0), width * f32(props.get("offset", 0.5)))
    number = np.floor((p[0] + offset) / width)
    u, v = p[0] + offset - width * number, p[1] - height * row
    edge = np.minimum(np.minimum(u, v), np.minimum(width - u, height - v))
    size, smooth = x["Mortar Size"], x["Mortar Smooth"]
    with np.errstate(divide="ignore", invalid="ignore"):
        ramp = smoothstep(np.clip((ONE - edge / size) / np.where(smooth != 0.0, smooth, ONE), 0.0, 1.0))
    mortar = np.where(edge >= size, f32(0.0), np.where(smooth == 0.0, ONE, ramp))
    tint = np.where(mortar == 1.0, f32(0.0), brick_tint(row, number, x["Bias"]))
    color = (ONE - tint) * x["Color1"] + tint * x["Color2"]
    return {"Color": color * (ONE - mortar) + x["Mortar"] * mortar, "Fac": mortar}
