"""Root of the Blender extension "Photon Map". Lazy: test runners import this file too."""


def register():
    """Called by Blender when the extension is enabled."""
    from . import photon_engine

    photon_engine.register()


def unregister():
    """Called by Blender when the extension is disabled."""
    from . import photon_engine

    photon_engine.unregister()
