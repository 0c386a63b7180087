"""Kernels of the procedural textures: hashes, Perlin noise and its fractals, Voronoi cells, Gabor noise."""
