import numpy as np
import pytest

from ...bsdf import layout
from ...issues import IssueLog
from ...scene.data import Graph, Image, Material, Node, Socket
from ..fallback import NOT_SUPPORTED
from ..material import compile_material, may_refract
from ..points import ShadePoints, probe_points
from ..program import constant_background
from ..registry import LUMINANCE, convert


class Builder:
    """A graph made node by node."""

    def __init__(self):
        self.nodes = []
        self.issues = IssueLog()

    def add(self, kind, outputs, props=None, **inputs):
        """A node; inputs (underscores for spaces) are (kind, value) or (kind, node, output); gives its index."""
        sockets = {}
        for name, (socket, *value) in inputs.items():
            link = Socket(None, value[0], value[1], socket) if len(value) == 2 else Socket(value[0], kind=socket)
            sockets[name.replace("_", " ") if name not in ("Shader_001", "Value_001") else name] = link
        self.nodes.append(Node(kind, f"{kind} {len(self.nodes)}", props or {}, sockets, outputs))
        return len(self.nodes) - 1

    def diffuse(self, color=("RGBA", [0.5, 0.6, 0.7, 1.0])):
        """A Diffuse BSDF."""
        return self.add("ShaderNodeBsdfDiffuse", {"BSDF": "SHADER"}, Color=color, Roughness=("VALUE", 0.0))

    def glossy(self, roughness=("VALUE", 0.2)):
        """A Glossy BSDF."""
        return self.add("ShaderNodeBsdfAnisotropic", {"BSDF": "SHADER"}, Color=("RGBA", [1.0, 1.0, 1.0, 1.0]),
                        Roughness=roughness)

    def emission(self, strength=("VALUE", 2.0)):
        """An Emission."""
        return self.add("ShaderNodeEmission", {"Emission": "SHADER"}, Color=("RGBA", [1.0, 0.5, 0.25, 1.0]),
                        Strength=strength)

    def mix(self, factor, first, second):
        """A Mix Shader of two nodes."""
        outputs = [next(iter(self.nodes[k].output_kinds)) for k in (first, second)]
        return self.add("ShaderNodeMixShader", {"Shader": "SHADER"}, Fac=factor, Shader=("SHADER", first, outputs[0]),
                        Shader_001=("SHADER", second, outputs[1]))

    def u(self):
        """The first UV coordinate."""
        uv = self.add("ShaderNodeUVMap", {"UV": "VECTOR"}, {"uv_map": "Map"})
        parts = {"X": "VALUE", "Y": "VALUE", "Z": "VALUE"}
        return self.add("ShaderNodeSeparateXYZ", parts, Vector=("VECTOR", uv, "UV"))

    def program(self, images=()):
        """The program of the last node's first output."""
        output = next(iter(self.nodes[-1].output_kinds))
        graph = Graph(self.nodes, Socket(None, len(self.nodes) - 1, output, "SHADER"))
        return compile_material(Material("Test", graph), list(images), self.issues)


def points_at(u):
    """Points with these first coordinates in the layer Map."""
    points = probe_points(len(u), frozenset({"uv:Map"}))
    points.uvs["Map"][:, 0] = u
    return points


def test_constant_material():
    b = Builder()
    b.mix(("VALUE", 0.25), b.diffuse(), b.glossy())
    program = b.program()
    assert program.constant and program.slots == 2 and program.needs == frozenset()
    diffuse, glossy = program.lobes()
    np.testing.assert_allclose(diffuse.weight, [[0.375, 0.45, 0.525]], rtol=1e-6)
    np.testing.assert_allclose(glossy.weight, [[0.25, 0.25, 0.25]], rtol=1e-6)
    assert program.has_sharp(0.3) and not program.has_sharp(0.1) and program.has_rough
    assert not program.emits and not program.has_null


@pytest.mark.parametrize(("factor", "kind"), [(0.0, layout.DIFFUSE), (1.0, layout.REFLECT), (-3.0, layout.DIFFUSE)])
def test_hidden_branch_is_dropped(factor, kind):
    """What a constant factor hides is neither computed nor asked for."""
    b = Builder()
    u = b.u()
    rough = ("VALUE", u, "X")
    first = b.diffuse() if kind == layout.DIFFUSE else b.glossy(rough)
    second = b.glossy() if kind == layout.REFLECT else b.glossy(rough)
    b.mix(("VALUE", factor), first, second)
    program = b.program()
    assert program.constant and program.needs == frozenset()
    assert [lobe.kind for lobe in program.lobes()] == [kind]


def test_varying_material():
    b = Builder()
    u = b.u()
    b.mix(("VALUE", u, "X"), b.diffuse(), b.emission())
    program = b.program()
    assert not program.constant and program.needs == {"uv:Map"} and program.slots == 2 and program.emits
    points = points_at(np.array([0.0, 0.25, 1.0, 0.5, 0.125], np.float32))
    diffuse, light = program.lobes(points)
    np.testing.assert_allclose(diffuse.weight[:, 0], 0.5 * np.array([1.0, 0.75, 0.0, 0.5, 0.875]), rtol=1e-6)
    np.testing.assert_allclose(program.emission(points), light.weight)
    np.testing.assert_allclose(light.weight[1], [0.5, 0.25, 0.125], rtol=1e-6)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_small_batches(n):
    """As many hits as a colour has channels are still hits."""
    b = Builder()
    u = b.u()
    principled = b.add("ShaderNodeBsdfPrincipled", {"BSDF": "SHADER"}, {"distribution": "GGX"},
                       Base_Color=("RGBA", [0.8, 0.4, 0.2, 1.0]), Metallic=("VALUE", u, "X"), Alpha=("VALUE", u, "X"),
                       Coat_Weight=("VALUE", u, "X"), Transmission_Weight=("VALUE", u, "X"))
    b.mix(("VALUE", u, "X"), principled, b.diffuse())
    program = b.program()
    u = np.linspace(0.1, 0.7, 5, dtype=np.float32)
    whole = layout.pack(program.lobes(points_at(u)), 5, program.slots)
    part = layout.pack(program.lobes(points_at(u[:n])), n, program.slots)
    np.testing.assert_array_equal(whole.kind[:n], part.kind)
    keep = [k for k in range(layout.N_FIELDS) if k != layout.GROUP]  # group numbers only have to differ
    np.testing.assert_array_equal(whole.params[:n][..., keep], part.params[..., keep])


def test_lobe_that_weighs_nothing_here_keeps_its_slot():
    """A batch where the factor is 0 everywhere must not shrink the bounds."""
    b = Builder()
    u = b.u()
    b.mix(("VALUE", u, "X"), b.diffuse(), b.glossy(("VALUE", u, "Y")))
    program = b.program()
    assert program.slots == 2 and program.has_sharp(0.05)
    lobes = program.lobes(points_at(np.zeros(3, np.float32)))
    assert len(lobes) <= program.slots


def test_unknown_shader_is_reported_once():
    b = Builder()
    unknown = b.add("ShaderNodeBsdfHair", {"BSDF": "SHADER"}, Color=("RGBA", [0.1, 0.2, 0.3, 1.0]))
    b.mix(("VALUE", 0.5), unknown, b.emission())
    program = b.program()
    b.program()
    messages = [str(issue) for issue in b.issues]
    assert len(messages) == 1 and "Test > ShaderNodeBsdfHair 0" in messages[0] and "diffuse" in messages[0]
    diffuse, light = program.lobes()
    np.testing.assert_allclose(diffuse.weight, [[0.05, 0.1, 0.15]], rtol=1e-6)
    np.testing.assert_allclose(light.weight, [[1.0, 0.5, 0.25]], rtol=1e-6)


def test_unknown_texture_is_middle_grey():
    b = Builder()
    noise = b.add("ShaderNodeTexUnknown", {"Color": "RGBA", "Fac": "VALUE"})
    b.diffuse(("RGBA", noise, "Color"))
    np.testing.assert_allclose(b.program().lobes()[0].weight, [[0.5, 0.5, 0.5]])
    assert len(b.issues) == 1


@pytest.mark.parametrize("kind", NOT_SUPPORTED)
def test_what_is_left_out_is_named_once(kind):
    """By material, node and type, with what is used instead: script nodes, rays while shading, other engines' nodes."""
    b = Builder()
    left_out = b.add(kind, {"Out": "RGBA", "More": "VALUE"})
    b.mix(("VALUE", left_out, "More"), b.diffuse(("RGBA", left_out, "Out")), b.emission())
    b.program()
    b.program()
    named = [f"Test > {kind} 0" in str(issue) and "its outputs are 0.5" in str(issue) for issue in b.issues]
    assert named == [True]


def test_a_thin_wall_passes_light_straight():
    """Its subsurface scattering is exact, not replaced; linked, it may be either."""
    b = Builder()
    b.add("ShaderNodeBsdfPrincipled", {"BSDF": "SHADER"}, {"distribution": "GGX"}, Thin_Wall=("INT", 1),
          Thin_Film_Thickness=("VALUE", 300.0), Subsurface_Weight=("VALUE", 0.5), Roughness=("VALUE", 0.0),
          Transmission_Weight=("VALUE", 0.5), IOR=("VALUE", 1.5))
    program = b.program()
    assert len(b.issues) == 0
    kinds = [lobe.kind for lobe in program.lobes()]
    assert kinds == [layout.REFLECT, layout.TRANSPARENT, layout.REFLECT, layout.DIFFUSE, layout.TRANSLUCENT,
                     layout.DIFFUSE]  # fmt: skip
    assert program.has_null and program.has_sharp(0.1)


@pytest.mark.parametrize("method", ["RANDOM_WALK", "RANDOM_WALK_SKIN", "RANDOM_WALK_LEGACY", "BURLEY"])
def test_subsurface_scattering_is_walked(method):
    """The profile of Christensen and Burley by a random walk, which is said."""
    b = Builder()
    props = {"distribution": "GGX", "subsurface_method": method}
    b.add("ShaderNodeBsdfPrincipled", {"BSDF": "SHADER"}, props, Subsurface_Weight=("VALUE", 0.5))
    program = b.program()
    assert program.has_deep and [lobe.kind for lobe in program.lobes()][-2:] == [layout.SUBSURFACE, layout.DIFFUSE]
    said = ["Christensen-Burley" in str(issue) for issue in b.issues]
    assert said == ([True] if method == "BURLEY" else [])


def test_no_output_is_black():
    program = compile_material(Material("Empty", Graph()), [], IssueLog())
    assert program.constant and program.lobes() == [] and program.slots == 1 and not program.emits


def test_texture_through_the_active_layer():
    b = Builder()
    image = Image("Checks", np.array([[[0, 0, 0, 255], [255, 128, 64, 255]]], np.uint8), colorspace="Non-Color")
    props = {"image": 0, "interpolation": "Closest", "extension": "REPEAT", "projection": "FLAT"}
    texture = b.add("ShaderNodeTexImage", {"Color": "RGBA", "Alpha": "VALUE"}, props, Vector=("VECTOR", None))
    b.diffuse(("RGBA", texture, "Color"))
    program = b.program([image])
    assert program.needs == {"uv"}
    points = probe_points(2, program.needs)
    points.uvs[""][:] = [[0.2, 0.5], [0.9, 0.5]]
    np.testing.assert_allclose(program.lobes(points)[0].weight, [[0, 0, 0], [1, 128 / 255, 64 / 255]], atol=1e-6)


def test_linked_normal_faces_outward():
    """Nodes see normals on the side that was hit; lobes get them back on the outside."""
    b = Builder()
    normal = b.add("ShaderNodeNewGeometry", {"Normal": "VECTOR"})
    diffuse = b.diffuse()
    b.nodes[diffuse].inputs["Normal"] = Socket(None, normal, "Normal", "VECTOR")
    points = probe_points(2)
    points.backfacing[1] = True
    points.wo[1] *= -1.0
    lobe = b.program().lobes(points)[0]
    np.testing.assert_allclose(lobe.fields[layout.NORMAL], [[0, 0, 1], [0, 0, 1]], atol=1e-6)


def test_color_linked_to_a_shader_shines():
    b = Builder()
    b.add("ShaderNodeRGB", {"Color": "RGBA"}, {"value": [0.2, 0.4, 0.6, 1.0]})
    program = b.program()
    assert program.emits
    np.testing.assert_allclose(program.emission(), [[0.2, 0.4, 0.6]], rtol=1e-6)


def test_conversions():
    color = np.array([[0.2], [0.5], [0.9]], np.float32)
    np.testing.assert_allclose(convert(color, "RGBA", "VALUE"), [LUMINANCE @ color[:, 0]], rtol=1e-6)
    np.testing.assert_allclose(convert(color, "VECTOR", "VALUE"), [color.mean()], rtol=1e-6)
    np.testing.assert_allclose(convert(np.array([0.3], np.float32), "VALUE", "RGBA"), [[0.3]] * 3)
    assert convert(np.array([-1.7], np.float32), "VALUE", "INT") == [-1.0]


def test_constant_background():
    b = Builder()
    inputs = {"Color": ("RGBA", [0.1, 0.2, 0.3, 1.0]), "Strength": ("VALUE", 2.0)}
    b.add("ShaderNodeBackground", {"Background": "SHADER"}, **inputs)
    graph = Graph(b.nodes, Socket(None, 0, "Background", "SHADER"))
    np.testing.assert_allclose(constant_background(graph), (0.2, 0.4, 0.6), rtol=1e-6)
    assert constant_background(None) == (0.0, 0.0, 0.0)
    sky = b.add("ShaderNodeTexCoord", {"Generated": "VECTOR"})
    b.nodes[0].inputs["Color"] = Socket(None, 0, "Generated", "RGBA")
    varying = Graph([b.nodes[sky], b.nodes[0]], Socket(None, 1, "Background", "SHADER"))
    assert constant_background(varying) is None


def test_take_keeps_rows_together():
    points = points_at(np.arange(5, dtype=np.float32))
    picked = points.take(np.array([3, 1]))
    assert isinstance(picked, ShadePoints) and len(picked) == 2
    np.testing.assert_array_equal(picked.uvs["Map"][:, 0], [3.0, 1.0])
    assert picked.objects is points.objects and picked.camera is points.camera


def test_bump_of_a_constant_keeps_its_base_normal():
    b = Builder()
    bump = b.add("ShaderNodeBump", {"Normal": "VECTOR"}, Height=("VALUE", 0.3), Normal=("VECTOR", None))
    diffuse = b.diffuse()
    b.nodes[diffuse].inputs["Normal"] = Socket(None, bump, "Normal", "VECTOR")
    lobe = b.program().lobes(probe_points(2))[0]
    np.testing.assert_allclose(lobe.fields[layout.NORMAL], [[0, 0, 1], [0, 0, 1]])
    assert not list(b.issues)


def volume_program(**inputs):
    """A diffuse material around a Principled Volume."""
    b = Builder()
    smoke = b.add("ShaderNodeVolumePrincipled", {"Volume": "SHADER"}, **inputs)
    diffuse = b.diffuse()
    graph = Graph(b.nodes, Socket(None, diffuse, "BSDF", "SHADER"), Socket(None, smoke, "Volume", "SHADER"))
    return compile_material(Material("Smoke", graph), [], b.issues), [str(issue) for issue in b.issues]


ABSORBING = {"Density": ("VALUE", 2.0), "Absorption_Color": ("RGBA", [0.25, 1.0, 0.0, 1.0])}


def test_absorption_of_a_volume():
    """Density times (1 - colour) (1 - sqrt(absorption colour)); what scatters is reported."""
    program, said = volume_program(Color=("RGBA", [0.0, 0.0, 0.0, 1.0]), **ABSORBING)
    np.testing.assert_allclose(program.absorption, [1.0, 0.0, 2.0])
    assert not said
    program, said = volume_program(Color=("RGBA", [0.5, 0.5, 0.5, 1.0]), **ABSORBING)
    np.testing.assert_allclose(program.absorption, [0.5, 0.0, 1.0])
    assert len(said) == 1 and "scatters" in said[0] and "only its absorption" in said[0]
    assert [lobe.kind for lobe in program.lobes()] == [layout.DIFFUSE]


def test_volume_without_surface_is_clear():
    b = Builder()
    glass = b.add("ShaderNodeVolumeAbsorption", {"Volume": "SHADER"}, Color=("RGBA", [0.2, 0.5, 1.0, 1.0]),
                  Density=("VALUE", 3.0))
    graph = Graph(b.nodes, None, Socket(None, glass, "Volume", "SHADER"))
    program = compile_material(Material("Air", graph), [], b.issues)
    np.testing.assert_allclose(program.absorption, [2.4, 1.5, 0.0], rtol=1e-6)
    assert [lobe.kind for lobe in program.lobes()] == [layout.TRANSPARENT]


def one_shader(kind, **inputs):
    """A material of one node with these numbers for inputs."""
    sockets = {name: Socket(value, kind="VALUE") for name, value in inputs.items()}
    sockets["Color"] = Socket([0.9, 0.8, 0.7, 1.0], kind="RGBA")
    node = Node(f"ShaderNode{kind}", kind, {"distribution": "GGX"}, sockets, {"BSDF": "SHADER"})
    return Material(kind, Graph([node], Socket(None, 0, "BSDF", "SHADER")))


@pytest.mark.parametrize("kind", ["BsdfGlass", "BsdfRefraction"])
@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_glass_that_bends_nothing_is_transparent(kind, roughness):
    program = compile_material(one_shader(kind, Roughness=roughness, IOR=1.00005), [], IssueLog())
    (lobe,) = program.lobes()
    assert lobe.kind == layout.TRANSPARENT and program.has_null and not program.has_sharp(0.1)
    np.testing.assert_allclose(lobe.weight, [[0.9, 0.8, 0.7]], rtol=1e-6)
    bent = compile_material(one_shader(kind, Roughness=roughness, IOR=1.001), [], IssueLog())
    assert bent.lobes()[0].kind != layout.TRANSPARENT and not bent.has_null


def test_smooth_lobes_are_sharp_at_any_threshold():
    """As for the kernels, which give a roughness up to 0.01 no width: the plan must know of both ways through glass."""
    for roughness, sharp in ((0.0, True), (0.005, True), (0.01, True), (0.011, False)):
        program = compile_material(one_shader("BsdfGlass", Roughness=roughness, IOR=1.5), [], IssueLog())
        assert program.has_sharp(0.0) == sharp and program.may_be_rough(0.0) != sharp
        assert program.may_be_narrow(0.0) != sharp


def test_may_refract():
    assert may_refract(one_shader("BsdfGlass").graph) and not may_refract(one_shader("BsdfDiffuse").graph)
    for weight, answer in ((0.0, False), (0.3, True)):
        graph = one_shader("BsdfPrincipled", **{"Transmission Weight": weight}).graph
        assert may_refract(graph) == answer


@pytest.mark.parametrize(("output", "smooth", "named"), [("Quadratic", 0.0, []), ("Quadratic", 0.5, ["Smooth"]),
                                                         ("Linear", 0.0, ["Linear"]),
                                                         ("Constant", 2.0, ["Constant", "Smooth"])])  # fmt: skip
def test_falloff_on_surfaces_is_quadratic_and_said_to_be(output, smooth, named):
    b = Builder()
    outputs = dict.fromkeys(("Quadratic", "Linear", "Constant"), "VALUE")
    falloff = b.add("ShaderNodeLightFalloff", outputs, Strength=("VALUE", 3.0), Smooth=("VALUE", smooth))
    b.emission(strength=("VALUE", falloff, output))
    np.testing.assert_allclose(b.program().emission(probe_points(1))[0], [3.0, 1.5, 0.75])
    said = [str(issue) for issue in b.issues]
    assert len(said) == len(named) and all(word in text for word, text in zip(named, said, strict=True))
