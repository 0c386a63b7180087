"""Photon Map: a progressive photon mapping renderer for Blender scenes. Importing it loads no dependency."""

from importlib import import_module

__version__ = "0.1.0"


def register() -> None:
    """Make the engine known to Blender."""
    _blender().register()


def unregister() -> None:
    """Take the engine out of Blender."""
    _blender().unregister()


def _blender():
    # by name: importing the package needs neither bpy nor numba, and no layer reaches Blender through its root
    return import_module(".blender", __package__)
