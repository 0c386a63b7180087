"""Photon batches, the maps, the gather kernels and the radius schedule."""
