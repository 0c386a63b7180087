"""The nodes, by subject; importing this package fills the registry."""

from . import (
    colors,
    curves,
    geometry_inputs,
    image,
    patterns,
    procedural,
    relief,
    scalars,
    shaders,
    spectra,
    vectors,
    volumes,
)

__all__ = [
    "colors",
    "curves",
    "geometry_inputs",
    "image",
    "patterns",
    "procedural",
    "relief",
    "scalars",
    "shaders",
    "spectra",
    "vectors",
    "volumes",
]
