"""The only layer that imports bpy: depsgraph to SceneData, and pictures back into Blender's render result."""
