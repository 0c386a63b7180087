"""One module a sample: ``build(...)`` makes the scene in the current Blender file."""

SAMPLES = ("cornell_caustics", "ring_cardioid", "pool", "wine_glass", "diffuse_room", "material_shelf")
