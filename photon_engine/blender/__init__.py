"""The only layer that imports bpy: depsgraph to SceneData, and pictures back into Blender's render result."""


def register() -> None:
    """Add the engine, its properties and panels to Blender; again is no harm."""
    from . import engine, keep, properties, ui

    if engine.PhotonMapEngine.is_registered:
        return
    properties.register()
    engine.register()
    ui.register()
    keep.register()


def unregister() -> None:
    """Remove them again."""
    from . import engine, keep, properties, ui

    if not engine.PhotonMapEngine.is_registered:
        return
    keep.unregister()
    ui.unregister()
    engine.unregister()
    properties.unregister()
