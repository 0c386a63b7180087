"""Small scenes, each for one thing that the renderer must get right; each function builds it in the current file."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

MODULES = ("lights", "materials", "textures", "cameras", "geometry", "relief", "below")


def all_scenes() -> dict[str, Callable[[], None]]:
    """Name -> builder, of every module (needs bpy)."""
    scenes: dict[str, Callable[[], None]] = {}
    for name in MODULES:
        for key, builder in import_module(f"{__name__}.{name}").SCENES.items():
            if key in scenes:
                raise ValueError(f"two scenes are called {key}")
            scenes[key] = builder
    return scenes


def build(name: str) -> None:
    """Build one scene by name."""
    all_scenes()[name]()
