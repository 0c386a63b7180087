"""The story of one pass: photons out, eye paths in, direct light, gather."""
