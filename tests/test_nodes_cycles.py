"""Nodes on numbers, colours and vectors against Cycles."""

from __future__ import annotations

import pytest

pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")

from tests.node_patch import EDGES, TOLERANCE, Patch, channel, enum, feed, new, out, ramp


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


# outputs that jump are met where a pixel's centre lies on the edge to within the filter's width: at most a row
JUMPS = {
    "MODULO", "FLOORED_MODULO", "SNAP", "WRAP", "ROUND", "FLOOR", "CEIL", "TRUNC", "FRACT", "SIGN", "LESS_THAN",
    "COMPARE", "GREATER_THAN", "DIVIDE", "LOGARITHM", "ARCTAN2", "POWER", "TANGENT", "PINGPONG", "FRACTION",
    "FACEFORWARD", "PROJECT", "REFLECT",
}
# slopes beyond 3 near the ends of their domains
STEEP = {"SQRT", "INVERSE_SQRT", "ARCSINE", "ARCCOSINE", "DEGREES"}


@pytest.mark.parametrize("operation", enum("ShaderNodeMath", "operation"))
def test_math(patch, operation):
    def build(tree):
        v = ramp(tree)
        node = new(tree, "ShaderNodeMath", operation=operation)
        feed(tree, node, Value=channel(tree, v, 0), Value_001=channel(tree, v, 1))
        if not node.inputs[2].is_unavailable:
            feed(tree, node, Value_002=0.3)
        # steep or jumping results: squash with arctan so that errors stay comparable
        squash = new(tree, "ShaderNodeMath", operation="ARCTANGENT")
        return feed(tree, squash, Value=node.outputs[0]).outputs[0]

    steep = 3.0 if operation in STEEP else 1.0
    patch.compare(build, steep * TOLERANCE, EDGES if operation in JUMPS else 0)


@pytest.mark.parametrize("operation", enum("ShaderNodeVectorMath", "operation"))
def test_vector_math(patch, operation):
    def build(tree):
        node = new(tree, "ShaderNodeVectorMath", operation=operation)
        feed(tree, node, Vector=ramp(tree))
        constants = {"Vector_001": (0.4, -0.3, 0.8), "Vector_002": (-0.2, 0.1, 1.3), "Scale": 0.7}
        for name, value in constants.items():
            socket = next((s for s in node.inputs if s.identifier == name and not s.is_unavailable), None)
            if socket is not None:
                socket.default_value = value
        result = next(s for s in node.outputs if not s.is_unavailable)
        return result

    patch.compare(build, outliers=EDGES if operation in JUMPS else 0)


def colors(tree):
    """Two colours that vary over the patch, some channels outside [0, 1]."""
    return ramp(tree, (0.0, 0.9, -0.1), (1.1, 0.1, 0.8)), ramp(tree, (0.7, 0.2, 1.2), (-0.05, 0.6, 0.3))


@pytest.mark.parametrize("mode", enum("ShaderNodeMix", "blend_type"))
@pytest.mark.parametrize("clamp", [False, True])
def test_mix_color(patch, mode, clamp):
    def build(tree):
        node = new(tree, "ShaderNodeMix", data_type="RGBA", blend_type=mode, clamp_result=clamp)
        a, b = colors(tree)
        return out(feed(tree, node, Factor_Float=0.6, A_Color=a, B_Color=b), "Result_Color")

    # hue jumps where two channels are equal; burning and dodging jump at white and black
    jumps = mode in ("HUE", "SATURATION", "COLOR", "VALUE", "BURN", "DODGE", "DIVIDE")
    patch.compare(build, outliers=EDGES if jumps else 0)


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize("kind", ["FLOAT", "VECTOR", "NON_UNIFORM", "RGBA"])
def test_mix_factor(patch, kind, clamp):
    """Factors beyond [0, 1] extrapolate unless clamped."""
    def build(tree):
        data, v = "VECTOR" if kind == "NON_UNIFORM" else kind, ramp(tree)
        node = new(tree, "ShaderNodeMix", data_type=data, clamp_factor=clamp)
        if kind == "FLOAT":
            return out(feed(tree, node, Factor_Float=channel(tree, v, 0), A_Float=0.3, B_Float=0.8), "Result_Float")
        if kind == "RGBA":
            feed(tree, node, A_Color=(0.1, 0.5, 0.9, 1.0), B_Color=(0.8, 0.4, 0.2, 1.0))
            return out(feed(tree, node, Factor_Float=channel(tree, v, 0)), "Result_Color")
        feed(tree, node, A_Vector=(0.1, 0.5, 0.9), B_Vector=(0.8, 0.4, 0.2))
        if kind == "NON_UNIFORM":
            node.factor_mode = "NON_UNIFORM"
            return out(feed(tree, node, Factor_Vector=v), "Result_Vector")
        return out(feed(tree, node, Factor_Float=channel(tree, v, 0)), "Result_Vector")

    patch.compare(build)


@pytest.mark.parametrize("clamp", [False, True])
def test_old_mix(patch, clamp):
    def build(tree):
        node = new(tree, "ShaderNodeMixRGB", blend_type="ADD", use_clamp=clamp)
        a, b = colors(tree)
        return feed(tree, node, Fac=channel(tree, ramp(tree), 0), Color1=a, Color2=b).outputs[0]

    patch.compare(build)


SIMPLE = {
    "invert": ("ShaderNodeInvert", {"Fac": 0.7}),
    "gamma": ("ShaderNodeGamma", {"Gamma": 2.2}),
    "gamma 0": ("ShaderNodeGamma", {"Gamma": 0.0}),
    "bright": ("ShaderNodeBrightContrast", {"Bright": 0.2, "Contrast": -0.4}),
    "contrast": ("ShaderNodeBrightContrast", {"Bright": -0.3, "Contrast": 0.8}),
    "hue": ("ShaderNodeHueSaturation", {"Hue": 0.8, "Saturation": 1.4, "Value": 0.7, "Fac": 0.9}),
    "saturation": ("ShaderNodeHueSaturation", {"Hue": 0.5, "Saturation": 0.3, "Value": 1.7, "Fac": 1.0}),
    "bw": ("ShaderNodeRGBToBW", {}),
}


@pytest.mark.parametrize("case", SIMPLE)
def test_color_nodes(patch, case):
    kind, values = SIMPLE[case]

    def build(tree):
        return feed(tree, tree.nodes.new(kind), Color=colors(tree)[0], **values).outputs[0]

    # hue jumps where two channels are equal
    patch.compare(build, outliers=EDGES if case in ("hue", "saturation") else 0, flat=case == "gamma 0")


@pytest.mark.parametrize("mode", ["RGB", "HSV", "HSL"])
def test_separate_combine_color(patch, mode):
    """Channels exchanged on the way, so that neither half can hide the other's error."""
    def build(tree):
        color = ramp(tree, (0.1, 0.8, 0.2), (0.9, 0.3, 0.6))
        split = feed(tree, new(tree, "ShaderNodeSeparateColor", mode=mode), Color=color)
        join = new(tree, "ShaderNodeCombineColor", mode=mode)
        return feed(tree, join, Red=split.outputs[1], Green=split.outputs[2], Blue=split.outputs[0]).outputs[0]

    patch.compare(build, outliers=0 if mode == "RGB" else EDGES)


@pytest.mark.parametrize("kind", enum("ShaderNodeMapping", "vector_type"))
def test_mapping(patch, kind):
    def build(tree):
        node = new(tree, "ShaderNodeMapping", vector_type=kind)
        feed(tree, node, Vector=ramp(tree), Rotation=(0.3, -1.1, 2.0), Scale=(1.5, 0.6, -0.8))
        if kind in ("POINT", "TEXTURE"):
            feed(tree, node, Location=(0.2, 0.4, -0.3))
        return node.outputs[0]

    patch.compare(build)


def test_mapping_varying_rotation(patch):
    def build(tree):
        return feed(tree, tree.nodes.new("ShaderNodeMapping"), Vector=(0.4, 0.7, 0.5), Rotation=ramp(tree)).outputs[0]

    patch.compare(build)


@pytest.mark.parametrize("kind", enum("ShaderNodeVectorRotate", "rotation_type"))
@pytest.mark.parametrize("invert", [False, True])
def test_vector_rotate(patch, kind, invert):
    def build(tree):
        node = new(tree, "ShaderNodeVectorRotate", rotation_type=kind, invert=invert)
        feed(tree, node, Vector=ramp(tree), Center=(0.1, -0.2, 0.3))
        if kind == "EULER_XYZ":
            return feed(tree, node, Rotation=(0.3, 0.5, -0.9)).outputs[0]
        if kind == "AXIS_ANGLE":
            feed(tree, node, Axis=(0.3, 1.0, -0.4))
        return feed(tree, node, Angle=0.8).outputs[0]

    patch.compare(build)


@pytest.mark.parametrize("mode", enum("ShaderNodeMapRange", "interpolation_type"))
@pytest.mark.parametrize("data", ["FLOAT", "FLOAT_VECTOR"])
@pytest.mark.parametrize("flip", [False, True])
def test_map_range(patch, mode, data, flip):
    def build(tree):
        node = new(tree, "ShaderNodeMapRange", interpolation_type=mode, data_type=data, clamp=flip)
        low, high = (0.7, -0.1) if flip else (-0.1, 0.7)
        if data == "FLOAT":
            feed(tree, node, Value=channel(tree, ramp(tree), 0), From_Min=low, From_Max=high, To_Min=0.2, To_Max=0.9)
            if mode == "STEPPED":
                feed(tree, node, Steps=3.0)
            return node.outputs["Result"]
        feed(tree, node, Vector=ramp(tree), From_Min_FLOAT3=(low, low, -0.3), From_Max_FLOAT3=(high, high, 0.6),
             To_Min_FLOAT3=(0.2, 0.9, 0.1), To_Max_FLOAT3=(0.9, 0.2, 1.4))
        if mode == "STEPPED":
            feed(tree, node, Steps_FLOAT3=(3.0, 4.0, 2.5))
        return node.outputs["Vector"]

    patch.compare(build, outliers=EDGES if mode == "STEPPED" else 0)


@pytest.mark.parametrize("kind", enum("ShaderNodeClamp", "clamp_type"))
def test_clamp(patch, kind):
    def build(tree):
        node = new(tree, "ShaderNodeClamp", clamp_type=kind)
        return feed(tree, node, Value=channel(tree, ramp(tree), 0), Min=0.8, Max=0.2).outputs[0]

    patch.compare(build, flat=kind == "MINMAX")


@pytest.mark.parametrize("mode", ["LINEAR", "EASE", "CONSTANT", "CARDINAL", "B_SPLINE"])
@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_color_ramp(patch, mode, output):
    def build(tree):
        node = tree.nodes.new("ShaderNodeValToRGB")
        node.color_ramp.interpolation = mode
        for place, color in ((0.2, (0.8, 0.1, 0.3, 0.2)), (0.55, (0.1, 0.7, 0.9, 0.9))):
            node.color_ramp.elements.new(place).color = color
        return out(feed(tree, node, Fac=channel(tree, ramp(tree), 0)), output)

    patch.compare(build, outliers=EDGES if mode == "CONSTANT" else 0)


@pytest.mark.parametrize("extend", ["HORIZONTAL", "EXTRAPOLATED"])
@pytest.mark.parametrize("kind", ["ShaderNodeRGBCurve", "ShaderNodeVectorCurve", "ShaderNodeFloatCurve"])
def test_curves(patch, kind, extend):
    def build(tree):
        node = tree.nodes.new(kind)
        for k, curve in enumerate(node.mapping.curves):
            curve.points.new(0.3 + 0.1 * k, 0.6 - 0.15 * k)
        node.mapping.extend = extend
        node.mapping.update()
        if kind == "ShaderNodeFloatCurve":
            return feed(tree, node, Factor=0.8, Value=channel(tree, ramp(tree), 0)).outputs[0]
        name = "Color" if kind == "ShaderNodeRGBCurve" else "Vector"
        return feed(tree, node, Fac=0.8, **{name: ramp(tree)}).outputs[0]

    patch.compare(build)
