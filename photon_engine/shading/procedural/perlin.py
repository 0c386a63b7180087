"""Perlin's gradient noise in one to four dimensions, on Blender's lattice, and the fractals made of it.

A place is four doubles (x, y, z, w); in one dimension only w counts, in two x and y, in three x, y and z.
"""

from __future__ import annotations

import math

from ...jit import kernel
from .hashing import hash1, hash2, hash3, hash4, random1, random2, word

FBM, MULTIFRACTAL, HETERO_TERRAIN, HYBRID_MULTIFRACTAL, RIDGED_MULTIFRACTAL = range(5)
PERIOD = 100000.0  # the lattice repeats, before float32 runs out of digits
FAR = 1000000.0
# rows of the parameters of `noise_rows`
DETAIL, ROUGHNESS, LACUNARITY, OFFSET, GAIN, DISTORTION = range(6)
N_PARAMETERS = 6


@kernel
def fade(t):
    """6 t^5 - 15 t^4 + 10 t^3."""
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


@kernel
def lerp(a, b, t):
    """(1 - t) a + t b."""
    return (1.0 - t) * a + t * b


@kernel
def signed(value, flag):
    """The value, negated when the flag is set."""
    return -value if flag else value


@kernel
def grad1(h, x):
    """Slope of +-1 to 8 times x."""
    return signed(1.0 + (h & 7), h & 8) * x


@kernel
def grad2(h, x, y):
    """One of eight gradients times (x, y)."""
    u, v = (x, y) if h & 7 < 4 else (y, x)
    return signed(u, h & 1) + signed(2.0 * v, h & 2)


@kernel
def grad3(h, x, y, z):
    """One of sixteen gradients times (x, y, z)."""
    k = h & 15
    u = x if k < 8 else y
    v = y if k < 4 else (x if k in (12, 14) else z)
    return signed(u, h & 1) + signed(v, h & 2)


@kernel
def grad4(h, x, y, z, w):
    """One of thirty-two gradients times (x, y, z, w)."""
    k = h & 31
    u = x if k < 24 else y
    v = y if k < 16 else z
    s = z if k < 8 else w
    return signed(u, h & 1) + signed(v, h & 2) + signed(s, h & 4)


@kernel
def perlin1(x):
    """Gradient noise on the line."""
    i = math.floor(x)
    f = x - i
    return lerp(grad1(hash1(word(i)), f), grad1(hash1(word(i + 1)), f - 1.0), fade(f))


@kernel
def perlin2(x, y):
    """Gradient noise in the plane."""
    fx, fy = x - math.floor(x), y - math.floor(y)
    i, j = math.floor(x), math.floor(y)
    i0, i1, j0, j1 = word(i), word(i + 1), word(j), word(j + 1)
    u = fade(fx)
    low = lerp(grad2(hash2(i0, j0), fx, fy), grad2(hash2(i1, j0), fx - 1.0, fy), u)
    high = lerp(grad2(hash2(i0, j1), fx, fy - 1.0), grad2(hash2(i1, j1), fx - 1.0, fy - 1.0), u)
    return lerp(low, high, fade(fy))


@kernel
def edge3(i0, i1, j, k, f, u):
    """Noise between two corners of a cube's edge along x; f: place relative to the first, u: fade(f[0])."""
    a = grad3(hash3(i0, j, k), f[0], f[1], f[2])
    return lerp(a, grad3(hash3(i1, j, k), f[0] - 1.0, f[1], f[2]), u)


@kernel
def perlin3(x, y, z):
    """Gradient noise in space."""
    fx, fy, fz = x - math.floor(x), y - math.floor(y), z - math.floor(z)
    i, j, k = math.floor(x), math.floor(y), math.floor(z)
    i0, i1, j0, j1, k0, k1 = word(i), word(i + 1), word(j), word(j + 1), word(k), word(k + 1)
    u, v = fade(fx), fade(fy)
    near = lerp(edge3(i0, i1, j0, k0, (fx, fy, fz), u), edge3(i0, i1, j1, k0, (fx, fy - 1.0, fz), u), v)
    far_f = fz - 1.0
    far = lerp(edge3(i0, i1, j0, k1, (fx, fy, far_f), u), edge3(i0, i1, j1, k1, (fx, fy - 1.0, far_f), u), v)
    return lerp(near, far, fade(fz))


@kernel
def edge4(i, j, k, m, f, u):
    """Noise between two corners of a hypercube's edge along x; i: both words of x."""
    a = grad4(hash4(i[0], j, k, m), f[0], f[1], f[2], f[3])
    return lerp(a, grad4(hash4(i[1], j, k, m), f[0] - 1.0, f[1], f[2], f[3]), u)


@kernel
def cube4(i, j, k, m, f, fades):
    """Noise in one of the two cubes of a hypercube; i, j, k: both words of x, y, z."""
    u, v, t = fades
    x, y, z, w = f
    near = lerp(edge4(i, j[0], k[0], m, f, u), edge4(i, j[1], k[0], m, (x, y - 1.0, z, w), u), v)
    z1 = z - 1.0
    far = lerp(edge4(i, j[0], k[1], m, (x, y, z1, w), u), edge4(i, j[1], k[1], m, (x, y - 1.0, z1, w), u), v)
    return lerp(near, far, t)


@kernel
def perlin4(x, y, z, w):
    """Gradient noise in four dimensions."""
    fx, fy, fz, fw = x - math.floor(x), y - math.floor(y), z - math.floor(z), w - math.floor(w)
    i, j, k, m = math.floor(x), math.floor(y), math.floor(z), math.floor(w)
    fades = (fade(fx), fade(fy), fade(fz))
    ii, jj, kk = (word(i), word(i + 1)), (word(j), word(j + 1)), (word(k), word(k + 1))
    low = cube4(ii, jj, kk, word(m), (fx, fy, fz, fw), fades)
    high = cube4(ii, jj, kk, word(m + 1), (fx, fy, fz, fw - 1.0), fades)
    return lerp(low, high, fade(fw))


@kernel
def wrapped(x):
    """A coordinate in the lattice's period; far away exactly, whatever its size."""
    size = abs(x)
    if size >= FAR:
        return math.copysign(size % PERIOD, x) + 0.5
    return math.copysign(size - PERIOD * math.floor(size / PERIOD), x)


@kernel
def snoise(dims, p):
    """Noise about 0 within [-1, 1]; not finite places give 0."""
    x, y, z, w = wrapped(p[0]), wrapped(p[1]), wrapped(p[2]), wrapped(p[3])
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z) and math.isfinite(w)):
        return 0.0
    if dims == 1:
        return 0.2500 * perlin1(w)
    if dims == 2:
        return 0.6616 * perlin2(x, y)
    if dims == 3:
        return 0.9820 * perlin3(x, y, z)
    return 0.8344 * perlin4(x, y, z, w)


@kernel
def scaled(p, s):
    """s p."""
    return (p[0] * s, p[1] * s, p[2] * s, p[3] * s)


@kernel
def moved(p, q):
    """p + q."""
    return (p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3])


@kernel
def fbm(dims, p, detail, roughness, lacunarity, normalize):
    """Fractional Brownian motion: octaves weighted roughness^i; normalized to [0, 1] about 0.5."""
    scale, weight, weights, total = 1.0, 1.0, 0.0, 0.0
    for _ in range(int(detail) + 1):
        total += snoise(dims, scaled(p, scale)) * weight
        weights += weight
        weight *= roughness
        scale *= lacunarity
    rest = detail - math.floor(detail)
    value = 0.5 * total / weights + 0.5 if normalize else total
    if rest == 0.0:
        return value
    total += snoise(dims, scaled(p, scale)) * weight
    return lerp(value, 0.5 * total / (weights + weight) + 0.5 if normalize else total, rest)


@kernel
def multifractal(dims, p, detail, roughness, lacunarity):
    """Product of octaves 1 + noise [Musgrave, Texturing and Modeling, chapter 16]."""
    value, weight = 1.0, 1.0
    for _ in range(int(detail) + 1):
        value *= weight * snoise(dims, p) + 1.0
        weight *= roughness
        p = scaled(p, lacunarity)
    rest = detail - math.floor(detail)
    return value * (rest * weight * snoise(dims, p) + 1.0) if rest != 0.0 else value


@kernel
def hetero_terrain(dims, p, shape):
    """Octaves scaled by the height so far [Musgrave]; shape: detail, roughness, lacunarity, offset, gain."""
    detail, roughness, lacunarity, offset, _ = shape
    value = offset + snoise(dims, p)
    weight = roughness
    p = scaled(p, lacunarity)
    for _ in range(1, int(detail) + 1):
        value += (snoise(dims, p) + offset) * weight * value
        weight *= roughness
        p = scaled(p, lacunarity)
    rest = detail - math.floor(detail)
    return value + rest * (snoise(dims, p) + offset) * weight * value if rest != 0.0 else value


@kernel
def hybrid_multifractal(dims, p, shape):
    """Octaves weighted by the ones before [Musgrave, chapter 16]; shape as in hetero_terrain."""
    detail, roughness, lacunarity, offset, gain = shape
    value, share, weight = 0.0, 1.0, 1.0
    for _ in range(int(detail) + 1):
        if weight <= 0.001:
            break
        weight = min(weight, 1.0)
        signal = (snoise(dims, p) + offset) * share
        share *= roughness
        value += weight * signal
        weight *= gain * signal
        p = scaled(p, lacunarity)
    rest = detail - math.floor(detail)
    if rest != 0.0 and weight > 0.001:
        value += rest * min(weight, 1.0) * (snoise(dims, p) + offset) * share
    return value


@kernel
def ridged_multifractal(dims, p, shape):
    """Squared ridges offset - |noise|, weighted by the ones before [Musgrave, chapter 16]; shape as above."""
    detail, roughness, lacunarity, offset, gain = shape
    share = roughness
    signal = (offset - abs(snoise(dims, p))) ** 2
    value = signal
    for _ in range(1, int(detail) + 1):
        p = scaled(p, lacunarity)
        weight = min(max(signal * gain, 0.0), 1.0)
        signal = (offset - abs(snoise(dims, p))) ** 2 * weight
        value += signal * share
        share *= roughness
    return value


@kernel
def fractal(kind, dims, p, shape, normalize):
    """One of the five fractals; shape: detail, roughness, lacunarity, offset, gain."""
    if kind == FBM:
        return fbm(dims, p, shape[0], shape[1], shape[2], normalize)
    if kind == MULTIFRACTAL:
        return multifractal(dims, p, shape[0], shape[1], shape[2])
    if kind == HETERO_TERRAIN:
        return hetero_terrain(dims, p, shape)
    if kind == HYBRID_MULTIFRACTAL:
        return hybrid_multifractal(dims, p, shape)
    return ridged_multifractal(dims, p, shape)


@kernel
def random_offset(dims, seed):
    """A place 100 to 200 away along each axis, in place of a seed of the noise."""
    if dims == 1:
        return (0.0, 0.0, 0.0, 100.0 + 100.0 * random1(seed))
    x, y = 100.0 + 100.0 * random2(seed, 0.0), 100.0 + 100.0 * random2(seed, 1.0)
    z = 100.0 + 100.0 * random2(seed, 2.0) if dims > 2 else 0.0
    return (x, y, z, 100.0 + 100.0 * random2(seed, 3.0) if dims > 3 else 0.0)


@kernel
def distorted(dims, p, amount):
    """The place moved by noise of its own along each axis."""
    if dims == 1:
        return (0.0, 0.0, 0.0, p[3] + amount * snoise(1, moved(p, random_offset(1, 0.0))))
    x = amount * snoise(dims, moved(p, random_offset(dims, 0.0)))
    y = amount * snoise(dims, moved(p, random_offset(dims, 1.0)))
    z = amount * snoise(dims, moved(p, random_offset(dims, 2.0))) if dims > 2 else 0.0
    w = amount * snoise(dims, moved(p, random_offset(dims, 3.0))) if dims > 3 else 0.0
    return (p[0] + x, p[1] + y, p[2] + z, p[3] + w)


@kernel
def noise_rows(places, parameters, kind, dims, normalize, value, color):
    """Fractal noise of a batch.

    places : (4, n) f32;  parameters : (N_PARAMETERS, n | 1) f32;  value : (n,) f32;  color : (3, n) f32, or (3, 0)
    when it is not wanted
    """
    step = 0 if parameters.shape[1] == 1 else 1
    for i in range(places.shape[1]):
        k = i * step
        detail = min(max(float(parameters[DETAIL, k]), 0.0), 15.0)
        shape = (
            detail, max(float(parameters[ROUGHNESS, k]), 0.0), float(parameters[LACUNARITY, k]),
            float(parameters[OFFSET, k]), float(parameters[GAIN, k]),
        )
        p = (float(places[0, i]), float(places[1, i]), float(places[2, i]), float(places[3, i]))
        if parameters[DISTORTION, k] != 0.0:
            p = distorted(dims, p, float(parameters[DISTORTION, k]))
        first = fractal(kind, dims, p, shape, normalize)
        value[i] = first
        if color.shape[1]:
            color[0, i] = first
            color[1, i] = fractal(kind, dims, moved(p, random_offset(dims, float(dims))), shape, normalize)
            color[2, i] = fractal(kind, dims, moved(p, random_offset(dims, dims + 1.0)), shape, normalize)
