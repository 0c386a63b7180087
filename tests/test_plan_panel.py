"""After a render in Blender the panel tells what ran, what was left out, and so why a pass is black."""

from types import SimpleNamespace

import bpy
import pytest

import photon_engine
from photon_engine.blender import ui
from photon_engine.plan import LABELS


@pytest.fixture
def scene():
    """A matte cube under a lamp, rendered once by the extension."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    photon_engine.register()
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.light_add(type="POINT", location=(0.0, 0.0, 4.0))
    bpy.ops.object.camera_add(location=(0.0, 0.0, 6.0))
    scene.camera = bpy.context.object
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.engine = "PHOTON_MAP"
    scene.photon_map.passes, scene.photon_map.diffuse_photons = 1, 500
    yield scene
    photon_engine.unregister()


def drawn() -> list[tuple[str, str]]:
    """Text and icon of the panel's labels."""
    labels = []
    column = SimpleNamespace(label=lambda text, icon="NONE": labels.append((text, icon)))
    ui.PHOTON_MAP_PT_plan.draw(SimpleNamespace(layout=SimpleNamespace(column=lambda align: column)), None)
    return labels


def test_the_panel_says_why_a_pass_is_black(scene):
    bpy.ops.render.render()
    labels = drawn()
    assert [text for text, _ in labels[::2]] == list(LABELS.values())
    at = labels.index((LABELS["caustic_map"], "X"))
    assert labels[at + 1] == ("no specular surface", "BLANK1")
    at = labels.index((LABELS["direct"], "CHECKMARK"))
    assert labels[at + 1][0].startswith("Point on ")
