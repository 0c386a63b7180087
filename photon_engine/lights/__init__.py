"""How lamps, emissive meshes and the world emit, are sampled, and are hit."""
