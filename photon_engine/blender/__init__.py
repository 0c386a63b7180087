"""The only layer that imports bpy: depsgraph to SceneData, and pictures back into Blender's render result."""


def register() -> None:
    """Add the engine, its properties and panels to Blender; again is no harm."""
    from . import engine, keep, properties, ui, warm

    if engine.PhotonMapEngine.is_registered:
        return
    properties.register()
    engine.register()
    ui.register()
    keep.register()
    warm.register()


def unregister() -> None:
    """Remove them again."""
    from . import engine, keep, properties, ui, warm

    if not engine.PhotonMapEngine.is_registered:
        return
    warm.unregister()
    keep.unregister()
    ui.unregister()
    engine.unregister()
    properties.unregister()
