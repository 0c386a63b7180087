"""Triangles flattened for Embree, ray queries, surface points and safe ray offsets."""
