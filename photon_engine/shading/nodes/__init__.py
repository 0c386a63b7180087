"""The nodes, by subject; importing this package fills the registry."""

from . import colors, curves, geometry_inputs, image, procedural, relief, scalars, shaders, vectors

__all__ = ["colors", "curves", "geometry_inputs", "image", "procedural", "relief", "scalars", "shaders", "vectors"]
