"""SceneData: plain arrays and records, the seam between Blender and everything else."""
