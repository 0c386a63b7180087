"""Only what depends on a change is made anew, and every picture is that of a fresh render, to the bit."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from ...geometry.kept import Kept
from ...issues import IssueLog
from ...scene.data import Graph, Material, Node, Socket
from ...settings import Settings
from ..renderer import Renderer
from .plan_scenes import LAMPS, place, scene

FEW = Settings(caustic_photons=400, diffuse_photons=400, light_samples=2, threads=1)
ALL = {
    "triangles", "tree", "node rays", "material 0", "material 1", "emitters", "sky", "lights", "casters", "targets",
    "media",
}  # fmt: skip


def pictures(data, kept=None):
    """Pass 0 of a scene."""
    renderer = Renderer(data, FEW, IssueLog(), kept=kept)
    try:
        renderer.prepare(lambda _text: None)
        return renderer.render_pass(0, lambda: False)
    finally:
        renderer.close()


def made(kept):
    """How often each thing was made so far."""
    names = {name: name if isinstance(name, str) else " ".join(map(str, name)) for name in kept.memo.made}
    return {"triangles": kept.flattened, "tree": kept.built, **{names[key]: n for key, n in kept.memo.made.items()}}


def glow(strength):
    """An emission of this strength: a number, or a node with its output."""
    if isinstance(strength, float):
        nodes, socket = [], Socket(strength)
    else:
        nodes, socket = [strength[0]], Socket(None, 0, strength[1])
    inputs = {"Color": Socket([1.0, 0.8, 0.6, 1.0], kind="RGBA"), "Strength": socket}
    nodes.append(Node("ShaderNodeEmission", "Emission", {}, inputs, {"Emission": "SHADER"}))
    return Material("Glow", Graph(nodes, Socket(None, len(nodes) - 1, "Emission", "SHADER")))


def sky():
    """A world that varies: Nishita's would do, a gradient is quicker."""
    coordinate = Node("ShaderNodeTexCoord", "Way", {}, {}, {"Generated": "VECTOR"})
    inputs = {"Color": Socket(None, 0, "Generated", "RGBA"), "Strength": Socket(0.3)}
    background = Node("ShaderNodeBackground", "Background", {}, inputs, {"Background": "SHADER"})
    return Graph([coordinate, background], Socket(None, 1, "Background", "SHADER"))


def frame(pane="Glass", strength=2.0, **more):
    """A glass or glowing pane over matte squares, a lamp, a varying sky; every object is a new one."""
    data = deepcopy(scene(pane=pane, lamps=("Bulb",), **more))
    data.world.graph = sky()
    if pane == "Glow":
        data.materials[-1] = glow(strength)
    return data


def test_a_moving_camera_makes_nothing_anew():
    kept = Kept()
    for x in (0.0, 0.2, 0.3):
        data = frame()
        data.camera.matrix = place(x, 0.0, 4.0)
        one, fresh = pictures(data, kept), pictures(data)
        for name, picture in fresh.items():
            np.testing.assert_array_equal(one[name], picture, err_msg=name)
        assert made(kept) == dict.fromkeys(ALL, 1)
    assert fresh["Caustic"].any() and fresh["Environment"].any()


def moved_pane(data):
    """Within the sphere round everything, whose middle stays."""
    data.instances[2].matrix[0, 3] += 0.1


def brighter_lamp(data):
    data.lights[0] = replace(data.lights[0], strength=(60.0, 40.0, 60.0))


def repainted(data):
    data.materials[0] = Material("Matte", data.materials[0].graph)
    data.materials[0].graph.nodes[0].inputs["Color"].value[0] = 0.1


def another_sky(data):
    data.world.graph.nodes[1].inputs["Strength"].value = 0.4


def one_more_lamp(data):
    data.lights.append(deepcopy(LAMPS["Spot"]))


CHANGES = [
    (moved_pane, {"triangles", "tree", "node rays", "casters", "targets", "media"}),
    (brighter_lamp, {"lights", "targets"}),
    (one_more_lamp, {"lights", "targets", "media"}),
    (repainted, {"material 0"}),
    (another_sky, {"sky", "lights", "targets"}),
]


@pytest.mark.parametrize(("change", "anew"), CHANGES, ids=lambda item: getattr(item, "__name__", ""))
def test_only_what_depends_on_the_change_is_made_anew(change, anew):
    kept = Kept()
    pictures(frame(), kept)
    data = frame()
    change(data)
    one, fresh = pictures(data, kept), pictures(data)
    assert {name for name, count in made(kept).items() if count > 1} == anew
    for name, picture in fresh.items():
        np.testing.assert_array_equal(one[name], picture, err_msg=name)


def test_glowing_meshes_are_looked_at_again_only_when_they_or_the_view_change():
    depth = Node("ShaderNodeCameraData", "Depth", {}, {}, {"View Z Depth": "VALUE"})
    for strength, anew in ((2.0, set()), ((depth, "View Z Depth"), {"emitters", "lights"})):
        kept = Kept()
        pictures(frame("Glow", strength), kept)
        data = frame("Glow", strength)
        data.camera.matrix = place(0.3, 0.0, 5.0)
        one, fresh = pictures(data, kept), pictures(data)
        assert {name for name, count in made(kept).items() if count > 1} == anew
        np.testing.assert_array_equal(one["Direct"], fresh["Direct"])
        data = frame("Glow", strength)
        moved_pane(data)
        one, fresh = pictures(data, kept), pictures(data)
        np.testing.assert_array_equal(one["Direct"], fresh["Direct"])
        assert kept.memo.made["emitters"] == 2 + len(anew) // 2 and fresh["Direct"].any()


def test_a_glow_that_looks_around_is_looked_at_again_when_something_near_moves():
    inputs = {"Color": Socket([1.0] * 4, kind="RGBA"), "Distance": Socket(2.0), "Normal": Socket(None, kind="VECTOR")}
    around = Node("ShaderNodeAmbientOcclusion", "Around", {"samples": 8}, inputs, {"Color": "RGBA", "AO": "VALUE"})
    for strength, count in ((2.0, 1), ((around, "AO"), 2)):
        kept = Kept()
        pictures(frame("Glow", deepcopy(strength)), kept)
        data = frame("Glow", deepcopy(strength))
        data.instances[1].matrix[1, 3] -= 0.1  # the wall
        one, fresh = pictures(data, kept), pictures(data)
        assert kept.flattened == 2 and kept.memo.made["emitters"] == count
        np.testing.assert_array_equal(one["Direct"], fresh["Direct"])


def bumpy(data):
    """The floor's vertices move by a displacement."""
    inputs = {"Height": Socket(0.6), "Midlevel": Socket(0.5), "Scale": Socket(0.1)}
    inputs["Normal"] = Socket(None, kind="VECTOR")
    node = Node("ShaderNodeDisplacement", "Displacement", {"space": "OBJECT"}, inputs, {"Displacement": "VECTOR"})
    graph = data.materials[0].graph
    graph.nodes.append(node)
    graph.displacement = Socket(None, len(graph.nodes) - 1, "Displacement", "VECTOR")
    data.materials[0] = Material("Bumpy", graph, "DISPLACEMENT")
    data.instances[1].materials = [1]
    return data


def test_a_displaced_mesh_is_moved_once_whatever_else_moves():
    kept = Kept()
    first = pictures(bumpy(frame()), kept)
    data = bumpy(frame())
    moved_pane(data)
    one, fresh = pictures(data, kept), pictures(data)
    assert kept.memo.made[("displaced", 0)] == 1 and kept.flattened == 2
    np.testing.assert_array_equal(one["Direct"], fresh["Direct"])
    assert not np.array_equal(first["Direct"], fresh["Direct"])
    data.instances[0].matrix = 0.5 * np.eye(4)  # the floor itself
    pictures(data, kept)
    assert kept.memo.made[("displaced", 0)] == 2
