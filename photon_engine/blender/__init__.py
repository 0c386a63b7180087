"""The only layer that imports bpy: depsgraph to SceneData, and pictures back into Blender's render result."""


def register() -> None:
    """Add the engine, its properties and panels to Blender; again is no harm."""
    import bpy

    if hasattr(bpy.types, "PhotonMapEngine"):
        return
    from . import engine, properties, ui

    properties.register()
    engine.register()
    ui.register()


def unregister() -> None:
    """Remove them again."""
    import bpy

    if not hasattr(bpy.types, "PhotonMapEngine"):
        return
    from . import engine, properties, ui

    ui.unregister()
    engine.unregister()
    properties.unregister()
