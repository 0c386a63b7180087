"""Noise-like textures: Noise, White Noise, Voronoi, Gabor."""

from __future__ import annotations

import numpy as np

from ..procedural import gabor, perlin, voronoi
from ..procedural.white import white_rows
from ..registry import f32, node
from .coordinates import texture_needs, texture_varies, texture_vector
from .vectors import normalize

FRACTALS = {"FBM": perlin.FBM, "MULTIFRACTAL": perlin.MULTIFRACTAL, "HETERO_TERRAIN": perlin.HETERO_TERRAIN,
            "HYBRID_MULTIFRACTAL": perlin.HYBRID_MULTIFRACTAL, "RIDGED_MULTIFRACTAL": perlin.RIDGED_MULTIFRACTAL}
METRICS = {"EUCLIDEAN": voronoi.EUCLIDEAN, "MANHATTAN": voronoi.MANHATTAN, "CHEBYCHEV": voronoi.CHEBYCHEV,
           "MINKOWSKI": voronoi.MINKOWSKI}
FEATURES = {"F1": voronoi.F1, "F2": voronoi.F2, "SMOOTH_F1": voronoi.SMOOTH_F1,
            "DISTANCE_TO_EDGE": voronoi.DISTANCE_TO_EDGE, "N_SPHERE_RADIUS": voronoi.N_SPHERE_RADIUS}
NO_COLOR = np.empty((3, 0), f32)


def gather_rows(values):
    """Numbers (n | 1,) as an array (len(values), n | 1); None counts as 0."""
    values = [np.zeros(1, f32) if value is None else value for value in values]
    out = np.empty((len(values), max(len(value) for value in values)), f32)
    for row, value in zip(out, values, strict=True):
        row[:] = value
    return out


def places_of(x, props, points, dims: int, scaled: bool = True):
    """Lattice places (4, n) of a texture's Vector and W, times its Scale."""
    vector = texture_vector(x, props, points) if dims != 1 else (None, None, None)
    w = x.get("W") if dims in (1, 4) else None
    places = gather_rows([*vector, w])
    return places * x["Scale"] if scaled else places


def spread(places, parameters):
    """The places repeated as often as there are parameters."""
    n = max(places.shape[1], parameters.shape[1])
    return places if places.shape[1] == n else np.repeat(places, n, axis=1)


def dimensions(props, name: str) -> int:
    """A node's number of dimensions."""
    return int(props.get(name, "3D")[0])


lattice = {"varies": texture_varies, "needs": texture_needs}


@node("ShaderNodeTexNoise", **lattice)
def noise(x, props, points):
    """Fractal Perlin noise, and two more of it for the colour."""
    dims = dimensions(props, "noise_dimensions")
    names = ("Detail", "Roughness", "Lacunarity", "Offset", "Gain", "Distortion")
    parameters = gather_rows([x.get(name) for name in names])
    places = spread(places_of(x, props, points, dims), parameters)
    value = np.empty(places.shape[1], f32)
    color = np.empty((3, len(value)), f32) if "Color" in props["used"] else NO_COLOR
    kind = FRACTALS[props.get("noise_type", "FBM")]
    perlin.noise_rows(places, parameters, kind, dims, bool(props.get("normalize", True)), value, color)
    return {"Fac": value, "Color": color}


@node("ShaderNodeTexWhiteNoise", **lattice)
def white_noise(x, props, points):
    """Hashes of the coordinates."""
    dims = dimensions(props, "noise_dimensions")
    places = places_of(x, props, points, dims, scaled=False)
    value, color = np.empty(places.shape[1], f32), np.empty((3, places.shape[1]), f32)
    white_rows(places, dims, value, color)
    return {"Value": value, "Color": color}


@node("ShaderNodeTexVoronoi", **lattice)
def voronoi_texture(x, props, points):
    """Cells around jittered points: distance, colour and place of the nearest or second, edges, radii."""
    dims = dimensions(props, "voronoi_dimensions")
    names = ("Scale", "Detail", "Roughness", "Lacunarity", "Smoothness", "Exponent", "Randomness")
    parameters = gather_rows([x.get(name) for name in names])
    places = spread(places_of(x, props, points, dims), parameters)
    switches = (
        FEATURES[props.get("feature", "F1")], METRICS[props.get("distance", "EUCLIDEAN")], dims,
        int(props.get("word_hash", True)), int(bool(props.get("normalize", False))),
    )
    out = np.zeros((voronoi.N_OUTPUTS, places.shape[1]), f32)
    voronoi.voronoi_rows(places, parameters, switches, out)
    return {"Distance": out[voronoi.DISTANCE], "Color": out[voronoi.RED : voronoi.RED + 3],
            "Position": out[voronoi.X : voronoi.X + 3], "W": out[voronoi.X + 3], "Radius": out[voronoi.RADIUS]}


@node("ShaderNodeTexGabor", **lattice)
def gabor_texture(x, props, points):
    """Interwoven waves of one frequency, in a plane or in space."""
    in_space = props.get("gabor_type", "2D") == "3D"
    isotropy = f32(1.0) - np.clip(x["Anisotropy"], 0.0, 1.0)
    axis = normalize(x["Orientation 3D"]) if in_space else (None, None, None)
    parameters = gather_rows([x["Frequency"], isotropy, None if in_space else x["Orientation 2D"], *axis])
    places = spread(places_of(x, props, points, 3), parameters)
    out = np.empty((3, places.shape[1]), f32)
    gabor.gabor_rows(places, parameters, in_space, out)
    return {"Value": out[0], "Phase": out[1], "Intensity": out[2]}
