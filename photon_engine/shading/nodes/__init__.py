"""The nodes, by subject; importing this package fills the registry."""

from . import (
    colors,
    curves,
    data_inputs,
    geometry_inputs,
    ies,
    image,
    light_path,
    patterns,
    procedural,
    relief,
    scalars,
    shaders,
    sky_texture,
    spectra,
    vectors,
    volumes,
)

__all__ = [
    "colors",
    "curves",
    "data_inputs",
    "geometry_inputs",
    "ies",
    "image",
    "light_path",
    "patterns",
    "procedural",
    "relief",
    "scalars",
    "shaders",
    "sky_texture",
    "spectra",
    "vectors",
    "volumes",
]
