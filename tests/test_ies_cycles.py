"""IES Texture against Cycles: photometric files of all types, with and without symmetry."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import LIFT, SIZE, Patch, feed, new, ramp  # noqa: E402


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("ies"))


def ies(vertical, horizontal, kind=1, tilt="TILT=NONE", factor=900.0) -> str:
    """A file's text with made-up candelas."""
    rng = np.random.default_rng(len(vertical) + 10 * len(horizontal))
    values = rng.uniform(0.2, 1.0, (len(horizontal), len(vertical)))
    values[:] *= np.linspace(1.0, 0.5, len(vertical))
    rows = "\n".join(", ".join(f"{v:.4f}" for v in row) for row in values)
    head = f"1 1000 {factor} {len(vertical)} {len(horizontal)} {kind} 2 0.1 0.1 0.1\n0.9 1.0 60"
    angles = "\n".join(" ".join(str(a) for a in part) for part in (vertical, horizontal))
    return f"IESNA:LM-63-1995\n[TEST] made up\n{tilt}\n{head}\n{angles}\n{rows}\n"


EVEN = list(range(0, 181, 20))
FILES = {
    "round": ies(EVEN, [0]),
    "quadrant": ies(EVEN, [0, 30, 60, 90]),
    "half": ies(EVEN, [0, 60, 120, 180]),
    "half_turned": ies(EVEN, [90, 150, 210, 270]),
    "whole": ies(EVEN, [0, 45, 90, 180, 270, 360]),
    "unclosed": ies(EVEN, [0, 60, 120, 180, 240, 300]),
    "downward": ies([0, 15, 40, 90], [0, 90]),
    "upward": ies([90, 120, 180], [0, 120, 240, 360]),
    "type_b": ies([0, 20, 45, 90], [0, 30, 90], kind=2),
    "type_b_whole": ies([-90, -30, 0, 50, 90], [-90, 0, 45, 90], kind=2),
    "type_a": ies([-90, -30, 0, 50, 90], [0, 30, 60, 90], kind=3),
    "tilted": ies(EVEN, [0, 30, 90], tilt="TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8"),
    "broken": "IESNA\nTILT=NONE\n1 1000 1 3",
    "no_tilt": "IESNA\n1 2 3",
}


def texture(tree, name, strength=0.1):
    """The node with a file as text, and its output."""
    text = bpy.data.texts.get(name) or bpy.data.texts.new(name)
    text.from_string(FILES[name])
    node = feed(tree, new(tree, "ShaderNodeTexIES", mode="INTERNAL", ies=text), Strength=strength)
    return node, node.outputs[0]


@pytest.mark.parametrize("name", FILES)
def test_file(patch, name):
    """Directions all over the sphere; a few samples lie on the edge of the range."""
    def build(tree):
        node, out = texture(tree, name)
        feed(tree, node, Vector=ramp(tree, (-1.0, -0.8, -0.9), (0.8, 1.0, 1.2)))
        return out

    issues = patch.compare(build, outliers=4, flat=name in ("broken", "no_tilt"))
    assert [("cannot be read" in str(issue)) for issue in issues] == [True] * (name in ("broken", "no_tilt"))


def test_without_a_vector_it_sees_the_viewer(patch):
    """In the object's space, which is turned."""
    patch.compare_engine(lambda tree: texture(tree, "whole")[1])


def test_files_beside_the_blend(patch, tmp_path):
    """External files are read, missing ones named."""
    path = tmp_path / "lamp.ies"
    path.write_text(FILES["quadrant"])

    def build(where):
        def made(tree):
            node = feed(tree, new(tree, "ShaderNodeTexIES", mode="EXTERNAL", filepath=str(where)), Strength=0.1)
            return feed(tree, node, Vector=ramp(tree)).outputs[0]

        return made

    assert not len(patch.compare(build(path), outliers=4))
    issues = patch.compare(build(tmp_path / "none.ies"), flat=True)
    assert ["there is none" in str(issue) for issue in issues] == [True]


def lit_floor(patch, kind, file, **settings):
    """The patch as a white floor under a lamp whose strength is a photometric file; the lamp is turned and scaled."""
    tree = patch.material.node_tree
    tree.nodes.clear()
    output, floor = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(floor.outputs[0], output.inputs["Surface"])
    data = bpy.data.lights.new("Lamp", kind)
    data.energy, data.use_nodes = 20.0, True
    for name, value in settings.items():
        setattr(data, name, value)
    strength = data.node_tree.nodes["Emission"].inputs["Strength"]
    data.node_tree.links.new(texture(data.node_tree, file, 1.0)[1], strength)
    lamp = bpy.data.objects.new("Lamp", data)
    lamp.location, lamp.rotation_euler, lamp.scale = (0.2, -0.1, 0.7), (0.3, -0.2, 0.8), (1.5, 1.5, 1.5)
    patch.scene.collection.objects.link(lamp)
    return lamp


@pytest.mark.parametrize("file", ["whole", "downward", "type_b"])
@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_lamp(patch, kind, file):
    """The floor under a point of light: the same in every pixel but at the edge of the file's range."""
    lamp = lit_floor(patch, kind, file, shadow_soft_size=0.0)
    try:
        theirs = (patch.cycles() / 4.0 + LIFT).reshape(-1, 3)
        ours, issues = patch.rendered("Direct")
        error = np.abs(ours - theirs).max(axis=1) / max(theirs.max(), 1e-30)
        assert not len(issues) and theirs.max() > 0.05
        # the map's points are 0.35 and 1.4 degrees apart, where the file has cubics between knots
        assert (error > 5e-3).sum() <= 2 * SIZE, f"{(error > 5e-3).sum()} pixels differ, worst by {error.max():.3f}"
        assert np.quantile(error, 0.5) < 1e-3
    finally:
        bpy.data.lights.remove(lamp.data)
