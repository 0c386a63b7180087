import numpy as np
import pytest

from ...issues import IssueLog, RenderError
from ...scene.data import Graph, Instance, Material, Node, SceneData, Socket
from ..checks import check_picture, check_scene, is_lit
from .fake import triangle_scene


def dark_scene():
    scene = triangle_scene()
    scene.lights = []
    return scene


def emitter(kind="ShaderNodeEmission", prefix="", strength=1.0, color=(1.0, 1.0, 1.0, 1.0), link=-1):
    names = {"ShaderNodeEmission": ("Strength", "Color")}.get(kind, ("Emission Strength", "Emission Color"))
    inputs = {names[0]: Socket(strength, node=link), names[1]: Socket(list(color), kind="RGBA")}
    return Material("M", Graph([Node(kind, "Node", inputs=inputs)], Socket(node=0)))


@pytest.mark.parametrize(
    "frame", [{"width": 0, "x1": 0}, {"height": 0, "y1": 0}, {"x1": 0}, {"y0": 6}], ids=["w", "h", "x", "y"]
)
def test_no_pixels_stop_the_render(frame):
    scene = triangle_scene()
    for name, value in frame.items():
        setattr(scene.frame, name, value)
    with pytest.raises(RenderError, match=r"resolution|border"):
        check_scene(scene, IssueLog())


def test_an_empty_scene_stops_unless_the_world_is_seen():
    with pytest.raises(RenderError, match="nothing to render"):
        check_scene(SceneData(), IssueLog())
    scene = SceneData()
    scene.world.color = (0.1, 0.0, 0.0)
    issues = IssueLog()
    check_scene(scene, issues)
    assert len(issues) == 0


def test_no_light_is_a_warning():
    issues = IssueLog()
    check_scene(dark_scene(), issues)
    assert ["no light" in issue.message for issue in issues] == [True]
    issues = IssueLog()
    check_scene(triangle_scene(), issues)
    assert len(issues) == 0


@pytest.mark.parametrize(("scene", "level", "told"), [
    (triangle_scene(), 0.0, True), (triangle_scene(), 1e-6, False), (dark_scene(), 0.0, False),
])  # fmt: skip
def test_a_black_picture_of_a_lit_scene_is_told(scene, level, told):
    """As from inside a wall; without any light `check_scene` has said so."""
    issues = IssueLog()
    picture = np.zeros((4, 6, 4), np.float32)
    picture[..., 3] = 1.0
    picture[2, 3, 1] = level
    check_picture(scene, picture, issues)
    assert [issue.object for issue in issues] == ([scene.camera.name] if told else [])


@pytest.mark.parametrize("kind", ["ShaderNodeEmission", "ShaderNodeBsdfPrincipled"])
@pytest.mark.parametrize(
    "changes, lit",
    [({}, True), ({"strength": 0.0}, False), ({"strength": 0.0, "link": 0}, True), ({"color": (0, 0, 0, 1)}, False)],
)
def test_emissive_materials_count_when_used(kind, changes, lit):
    scene = dark_scene()
    scene.materials = [emitter(kind, **changes)]
    assert not is_lit(scene)  # no face has it
    scene.instances.append(Instance(0, scene.instances[0].matrix, [0], "Lamp"))
    assert is_lit(scene) is lit
