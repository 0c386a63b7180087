"""Every node against Cycles: its output shines from a flat patch, one sample at each pixel's centre.

The patch is 2 m wide, seen from 2 m above by a perspective camera that it fills, so that view directions vary.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
oiio = pytest.importorskip("OpenImageIO")

from photon_engine.blender.images import ImageTable  # noqa: E402
from photon_engine.blender.node_trees import material_graph, world_graph  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.scene.data import Material  # noqa: E402
from photon_engine.shading.points import ObjectTable, ShadePoints  # noqa: E402
from photon_engine.shading.program import compile_material, constant_background  # noqa: E402

SIZE = 32
# Cycles' filter of 0.01 px shifts samples by up to 0.005 px, 1.6e-4 of the patch; half-float tables and float32
# arithmetic stay below that, so smooth outputs of slope <= 3 agree within 1e-3
TOLERANCE = 1e-3
LIFT = 2.0  # added to a quarter of the output
CORNER_COLORS = [(0.1, 0.2, 0.9, 0.3), (0.8, 0.3, 0.5, 0.4), (0.9, 0.9, 0.4, 0.6), (0.2, 0.8, 0.8, 0.5)]
ROTATION = (0.3, -0.2, 0.7)  # of the patch's object, for coordinates that are not the world's


class Patch:
    """The scene, and what its points are to us."""

    def __init__(self, folder: Path) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.folder = folder
        self.scene = bpy.context.scene
        scene = self.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = SIZE
        scene.cycles.samples = 1
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.use_denoising = False
        scene.cycles.pixel_filter_type = "BOX"
        scene.cycles.filter_width = 0.01
        scene.render.threads_mode, scene.render.threads = "FIXED", 1
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
        camera = bpy.data.cameras.new("Camera")
        camera.angle = 2.0 * math.atan(0.5)
        self.camera = bpy.data.objects.new("Camera", camera)
        self.camera.location = (0.0, 0.0, 2.0)
        scene.collection.objects.link(self.camera)
        scene.camera = self.camera
        self.material = bpy.data.materials.new("Patch")
        self.material.use_nodes = True
        self._mesh()

    def _mesh(self) -> None:
        """A square in the world's xy plane whose object is turned; uv 0 .. 1."""
        from mathutils import Euler

        self.matrix = Euler(ROTATION).to_matrix().to_4x4()
        corners = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
        mesh = bpy.data.meshes.new("Patch")
        from mathutils import Vector

        inverse = self.matrix.inverted()
        mesh.from_pydata([inverse @ Vector(c) for c in corners], [], [(0, 1, 2, 3)])
        layer = mesh.uv_layers.new(name="UVMap")
        other = mesh.uv_layers.new(name="Other")
        for k, uv in enumerate([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]):
            layer.data[k].uv = uv
            other.data[k].uv = (2.0 * uv[1] - 0.5, 1.5 * uv[0])
        paint = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "CORNER")
        for k in range(4):
            paint.data[k].color = CORNER_COLORS[k]
        mesh.materials.append(self.material)
        self.object = bpy.data.objects.new("Patch", mesh)
        self.object.matrix_world = self.matrix
        self.object.color = (0.2, 0.5, 0.7, 0.6)
        self.object.pass_index = 3
        self.scene.collection.objects.link(self.object)

    def wire(self, build) -> None:
        """Wire build(tree)'s output socket to the emission of the material."""
        tree = self.material.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        emission = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
        lift = tree.nodes.new("ShaderNodeVectorMath")  # we let nothing shine negatively
        lift.operation = "MULTIPLY_ADD"
        lift.inputs[1].default_value, lift.inputs[2].default_value = (0.25,) * 3, (LIFT,) * 3
        tree.links.new(build(tree), lift.inputs[0])
        tree.links.new(lift.outputs[0], emission.inputs["Color"])

    def cycles(self) -> np.ndarray:
        """Cycles' picture, (SIZE * SIZE, 3), bottom row first."""
        path = self.folder / "patch.exr"
        self.scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        picture = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[:, :, :3]
        return 4.0 * (picture[::-1].reshape(-1, 3) - LIFT)

    def points(self, back: bool = False) -> ShadePoints:
        """The points that the pixels' centres see."""
        at = ((np.arange(SIZE) + 0.5) / SIZE * 2.0 - 1.0).astype(np.float32)
        x, y = (grid.ravel() for grid in np.meshgrid(at, at))
        n = len(x)
        zero = np.zeros(n, np.float32)
        eye = np.array(self.camera.location, np.float32)
        p = np.stack([x, y, zero], axis=1)
        if back:
            p[:, 0] = -x
        wo = eye - p
        wo /= np.linalg.norm(wo, axis=1, keepdims=True)
        up = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (n, 1))
        u, v = 0.5 * (p[:, 0] + 1.0), 0.5 * (p[:, 1] + 1.0)
        inverse = np.array(self.matrix.inverted())
        local = (p @ inverse[:3, :3].T).astype(np.float32)
        corners = np.array([vertex.co for vertex in self.object.data.vertices])
        low, high = corners.min(axis=0), corners.max(axis=0)
        matrix = np.array(self.matrix)[None, :3, :3]
        table = ObjectTable(
            matrix.astype(np.float32), inverse[None, :3, :3].astype(np.float32), np.zeros((1, 3), np.float32),
            np.array([self.object.color], np.float32), np.array([3.0], np.float32), np.zeros(1, np.float32),
        )
        # the square's triangles are (0, 1, 2) and (0, 2, 3), parted by u = v
        a, b, c, d = np.array(CORNER_COLORS, np.float32)
        s, t = u[:, None], v[:, None]
        paint = np.where(s > t, a + s * (b - a) + t * (c - b), a + t * (d - a) + s * (c - d))
        tangent = np.append(inverse[:3, :3] @ np.array([1.0, 0.0, 0.0]), 1.0).astype(np.float32)
        to_camera = np.diag([1.0, 1.0, -1.0, 1.0]) @ np.linalg.inv(np.array(self.camera.matrix_world))
        return ShadePoints(
            p=p, ng=up, ns=up, wo=wo.astype(np.float32), backfacing=np.full(n, back),
            uvs={"": np.stack([u, v], axis=1), "UVMap": np.stack([u, v], axis=1),
                 "Other": np.stack([2.0 * v - 0.5, 1.5 * u], axis=1).astype(np.float32)},
            generated=((local - low) / np.where(high > low, high - low, 1.0)).astype(np.float32), object=local,
            normal_local=np.tile((inverse[:3, :3] @ np.array([0.0, 0.0, 1.0])).astype(np.float32), (n, 1)),
            tangents={"": np.tile(tangent, (n, 1))}, attributes={"Paint": paint, "": paint},
            instance=np.zeros(n, np.int32), objects=table,
            camera=to_camera.astype(np.float32), is_camera=True,
        )

    def ours(self, back: bool = False) -> tuple[np.ndarray, IssueLog]:
        """Our picture, (SIZE * SIZE, 3), and what was reported."""
        issues = IssueLog()
        table = ImageTable(issues)
        graph = material_graph(self.material, table, issues)
        program = compile_material(Material("Patch", graph), table.images, issues)
        value = 4.0 * (program.emission(self.points(back)) - LIFT)
        return np.broadcast_to(value, (SIZE * SIZE, 3)), issues

    def compare(self, build, tolerance: float = TOLERANCE, outliers: int = 0, flat: bool = False) -> IssueLog:
        """Assert that ours and Cycles' pictures agree but for some pixels on edges; flat: no variation is expected."""
        self.wire(build)
        theirs = np.maximum(self.cycles(), -4.0 * LIFT)
        ours, issues = self.ours()
        error = np.abs(ours - theirs) / np.maximum(1.0, np.abs(theirs))
        bad = (error.max(axis=1) > tolerance).sum()
        worst = error.max(axis=1).argmax()
        assert bad <= outliers, f"{bad} pixels differ; worst: ours {ours[worst]}, Cycles {theirs[worst]}"
        assert flat == (np.ptp(theirs, axis=0).max() < 1e-5)
        return issues


@pytest.fixture(scope="module")
def patch(tmp_path_factory):
    """One scene for all tests."""
    return Patch(tmp_path_factory.mktemp("nodes"))


def new(tree, kind: str, **settings):
    """A node with settings and constants: names with capitals are input identifiers."""
    node = tree.nodes.new(kind)
    for name, value in settings.items():
        setattr(node, name, value)
    return node


def feed(tree, node, **sources):
    """Set inputs by identifier (spaces as underscores): a socket is linked, anything else is a constant."""
    for name, value in sources.items():
        socket = next(s for s in node.inputs if s.identifier in (name, name.replace("_", " ")))
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node


def out(node, identifier: str):
    """An output by identifier."""
    return next(s for s in node.outputs if s.identifier == identifier)


def ramp(tree, low=(-0.5, -0.4, 0.1), high=(1.5, 1.2, 0.9)):
    """A vector that goes from low to high over the patch: (x, y, x + y) in the uv square."""
    uv = tree.nodes.new("ShaderNodeUVMap")
    split = feed(tree, tree.nodes.new("ShaderNodeSeparateXYZ"), Vector=out(uv, "UV"))
    add = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=split.outputs[0], Value_001=split.outputs[1])
    half = feed(tree, new(tree, "ShaderNodeMath", operation="MULTIPLY"), Value=add.outputs[0], Value_001=0.5)
    join = feed(tree, tree.nodes.new("ShaderNodeCombineXYZ"), X=split.outputs[0], Y=split.outputs[1], Z=half.outputs[0])
    scale = feed(tree, new(tree, "ShaderNodeVectorMath", operation="MULTIPLY_ADD"), Vector=join.outputs[0],
                 Vector_001=[b - a for a, b in zip(low, high, strict=True)], Vector_002=low)
    return out(scale, "Vector")


def unit(tree, vector):
    """A normalised vector."""
    return feed(tree, new(tree, "ShaderNodeVectorMath", operation="NORMALIZE"), Vector=vector).outputs[0]


def channel(tree, vector, k: int):
    """A component of a vector."""
    return feed(tree, tree.nodes.new("ShaderNodeSeparateXYZ"), Vector=vector).outputs[k]


def enum(kind: str, name: str) -> list[str]:
    """Values of a node's setting."""
    return [item.identifier for item in getattr(bpy.types, kind).bl_rna.properties[name].enum_items]


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
    patch.compare(build, steep * TOLERANCE, SIZE if operation in JUMPS else 0)


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

    patch.compare(build, outliers=2 * SIZE if operation in JUMPS else 0)


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
    patch.compare(build, outliers=SIZE if jumps else 0)


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
    patch.compare(build, outliers=SIZE if case in ("hue", "saturation") else 0, flat=case == "gamma 0")


@pytest.mark.parametrize("mode", ["RGB", "HSV", "HSL"])
def test_separate_combine_color(patch, mode):
    """Channels exchanged on the way, so that neither half can hide the other's error."""
    def build(tree):
        color = ramp(tree, (0.1, 0.8, 0.2), (0.9, 0.3, 0.6))
        split = feed(tree, new(tree, "ShaderNodeSeparateColor", mode=mode), Color=color)
        join = new(tree, "ShaderNodeCombineColor", mode=mode)
        return feed(tree, join, Red=split.outputs[1], Green=split.outputs[2], Blue=split.outputs[0]).outputs[0]

    patch.compare(build, outliers=0 if mode == "RGB" else SIZE)


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

    patch.compare(build, outliers=3 * SIZE if mode == "STEPPED" else 0)


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

    patch.compare(build, outliers=SIZE if mode == "CONSTANT" else 0)


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


@pytest.mark.parametrize("output", ["Generated", "Normal", "UV", "Object", "Camera", "Reflection"])
def test_texture_coordinate(patch, output):
    def build(tree):
        return out(tree.nodes.new("ShaderNodeTexCoord"), output)

    patch.compare(build, flat=output == "Normal")


def test_texture_coordinate_of_another_object(patch):
    other = bpy.data.objects.new("Other", None)
    other.location, other.scale, other.rotation_euler = (0.2, -0.3, 0.4), (2.0, 0.5, 1.0), (0.2, 0.5, 0.1)
    patch.scene.collection.objects.link(other)
    bpy.context.view_layer.update()

    def build(tree):
        return out(new(tree, "ShaderNodeTexCoord", object=other), "Object")

    patch.compare(build)


@pytest.mark.parametrize("layer", ["", "UVMap", "Other"])
def test_uv_map(patch, layer):
    patch.compare(lambda tree: new(tree, "ShaderNodeUVMap", uv_map=layer).outputs[0])


@pytest.mark.parametrize("output", ["Position", "Normal", "Tangent", "True Normal", "Incoming", "Backfacing"])
def test_geometry(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeNewGeometry"), output),
                  flat=output in ("Normal", "True Normal", "Backfacing"))


@pytest.mark.parametrize("output", ["View Vector", "View Z Depth", "View Distance"])
def test_camera_data(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeCameraData"), output), flat="Z" in output)


@pytest.mark.parametrize("output", ["Location", "Color", "Alpha", "Object Index"])
def test_object_info(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeObjectInfo"), output), flat=True)


@pytest.mark.parametrize("name", ["Paint", ""])
@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_vertex_color(patch, output, name):
    patch.compare(lambda tree: out(new(tree, "ShaderNodeVertexColor", layer_name=name), output))


def test_light_path(patch):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeLightPath"), "Is Camera Ray"), flat=True)


@pytest.mark.parametrize("linked", [False, True])
@pytest.mark.parametrize("case", [("ShaderNodeFresnel", "Fac", "IOR"), ("ShaderNodeLayerWeight", "Fresnel", "Blend"),
                                  ("ShaderNodeLayerWeight", "Facing", "Blend")])
def test_fresnel(patch, case, linked):
    kind, output, name = case

    def build(tree):
        node = tree.nodes.new(kind)
        # an index near 1 is left out: total reflection begins there with an infinite slope
        values = ramp(tree, (0.1, 1.1, 0.1), (0.9, 1.9, 0.8))
        feed(tree, node, **{name: channel(tree, values, 0 if name == "Blend" else 1)})
        if linked:
            feed(tree, node, Normal=unit(tree, (0.3, -0.2, 0.9)))
        return out(node, output)

    patch.compare(build)


@pytest.mark.parametrize("space", enum("ShaderNodeNormalMap", "space"))
@pytest.mark.parametrize("strength", [1.0, 0.4])
def test_normal_map(patch, space, strength):
    def build(tree):
        node = new(tree, "ShaderNodeNormalMap", space=space)
        return feed(tree, node, Color=ramp(tree, (0.2, 0.3, 0.7), (0.8, 0.9, 1.0)), Strength=strength).outputs[0]

    patch.compare(build)


@pytest.mark.parametrize("output", ["Color", "Fac"])
def test_checker(patch, output):
    def build(tree):
        node = tree.nodes.new("ShaderNodeTexChecker")
        feed(tree, node, Vector=ramp(tree, (-0.51, -0.43, 0.1), (0.49, 0.62, 0.12)), Scale=3.7)
        return out(feed(tree, node, Color1=(0.9, 0.1, 0.2, 1.0)), output)

    patch.compare(build, outliers=2)


@pytest.mark.parametrize("kind", enum("ShaderNodeTexGradient", "gradient_type"))
def test_gradient(patch, kind):
    def build(tree):
        return out(feed(tree, new(tree, "ShaderNodeTexGradient", gradient_type=kind), Vector=ramp(tree)), "Color")

    patch.compare(build, outliers=SIZE if kind == "RADIAL" else 0)


def test_checker_on_generated(patch):
    def build(tree):
        return feed(tree, tree.nodes.new("ShaderNodeTexChecker"), Scale=3.3).outputs[0]

    patch.compare(build, outliers=2 * SIZE)


def make_image(folder, kind: str, space: str = "", alpha: str = "STRAIGHT", channels: int = 4):
    """An 8 x 5 image of random texels: generated or written to a file by format name, then loaded."""
    rng = np.random.default_rng(7)
    texels = rng.random((5, 8, 4), np.float32)
    texels[..., 3] = np.where(rng.random((5, 8)) < 0.3, 1.0, 0.1 + 0.8 * texels[..., 3])
    if alpha == "PREMUL":
        texels[..., :3] *= texels[..., 3:4]
    if kind.startswith("GENERATED"):
        image = bpy.data.images.new("Texture", 8, 5, alpha=True, float_buffer="FLOAT" in kind)
        _settings(image, space, alpha)  # before the texels: a change of colour space makes them anew
        image.pixels.foreach_set(texels.ravel())
        image.update()
    else:
        extension, _, depth = kind.partition(" ")
        path = folder / f"texture_{len(bpy.data.images)}.{extension.lower()}"
        spec = oiio.ImageSpec(8, 5, channels, depth or "uint8")
        spec.attribute("oiio:UnassociatedAlpha", 1)
        file = oiio.ImageOutput.create(str(path))
        file.open(str(path), spec)
        file.write_image(np.ascontiguousarray(texels[::-1, :, :channels]))
        file.close()
        image = bpy.data.images.load(str(path))
        _settings(image, space, alpha)
    return image


def _settings(image, space: str, alpha: str) -> None:
    """Colour space and alpha mode."""
    if space:
        image.colorspace_settings.name = space
    image.alpha_mode = alpha


def texture(tree, image, vector=None, **settings):
    """An Image Texture node."""
    node = new(tree, "ShaderNodeTexImage", image=image, **settings)
    return node if vector is None else feed(tree, node, Vector=vector)


@pytest.mark.parametrize("extension", enum("ShaderNodeTexImage", "extension"))
@pytest.mark.parametrize("interpolation", enum("ShaderNodeTexImage", "interpolation"))
def test_image_lookup(patch, interpolation, extension):
    """Every interpolation and extension, well beyond the borders."""
    image = make_image(patch.folder, "GENERATED FLOAT", alpha="NONE")

    def build(tree):
        return texture(tree, image, ramp(tree, (-1.3, -2.4, 0.0), (2.2, 1.9, 0.0)), interpolation=interpolation,
                       extension=extension).outputs[0]

    # 28 x 21 texels over the patch: a texel is a pixel wide, so the filter's shift moves values by 0.005 of a step
    patch.compare(build, 5e-3, outliers=SIZE if interpolation == "Closest" or extension == "CLIP" else 0)


@pytest.mark.parametrize(("alpha", "output"), [("STRAIGHT", "Color"), ("STRAIGHT", "Alpha"), ("STRAIGHT", "both"),
                                               ("PREMUL", "both"), ("CHANNEL_PACKED", "both"), ("NONE", "both")])
@pytest.mark.parametrize("space", ["sRGB", "Non-Color", "Linear Rec.709", "Linear Rec.2020"])
@pytest.mark.parametrize("kind", ["GENERATED", "GENERATED FLOAT", "PNG", "PNG uint16", "EXR float", "packed PNG",
                                  "packed PNG uint16", "packed EXR float"])
def test_image_colors(patch, kind, space, alpha, output):
    """Colour spaces and alpha modes of byte and float images, read for colour, alpha, or both."""
    image = make_image(patch.folder, kind.removeprefix("packed "), space, alpha)
    if kind.startswith("packed"):
        image.pack()

    def build(tree):
        node = texture(tree, image, ramp(tree, (0.06, 0.1, 0.0), (0.96, 0.85, 0.0)))
        if output != "both":
            return out(node, output)
        mix = new(tree, "ShaderNodeMix", data_type="RGBA")
        feed(tree, mix, Factor_Float=0.5, A_Color=node.outputs["Color"], B_Color=node.outputs["Alpha"])
        return out(mix, "Result_Color")

    # texels differ by up to 1 within 4 pixels; converted colour spaces are kept as half floats by Cycles (5e-4)
    patch.compare(build, 2.0 * TOLERANCE)


def test_missing_file_is_magenta(patch):
    image = make_image(patch.folder, "PNG")
    image.filepath = str(patch.folder / "gone.png")
    image.reload()
    issues = patch.compare(lambda tree: texture(tree, image).outputs[0], flat=True)
    assert any("gone.png does not exist" in str(issue) for issue in issues)


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_no_image(patch, output):
    patch.compare(lambda tree: out(tree.nodes.new("ShaderNodeTexImage"), output), flat=True)


@pytest.mark.parametrize("output", ["Color", "Alpha"])
@pytest.mark.parametrize("channels", [1, 2, 3])
def test_channels(patch, channels, output):
    """Grey files, with alpha and without."""
    image = make_image(patch.folder, "PNG", channels=channels)
    opaque = output == "Alpha" and channels != 2
    patch.compare(lambda tree: out(texture(tree, image), output), 2.0 * TOLERANCE, flat=opaque)


@pytest.mark.parametrize("projection", ["SPHERE", "TUBE"])
def test_projection(patch, projection):
    image = make_image(patch.folder, "GENERATED FLOAT", alpha="NONE")

    def build(tree):
        return texture(tree, image, ramp(tree, (-0.4, 0.1, 0.2), (1.5, 1.2, 0.9)), projection=projection).outputs[0]

    patch.compare(build, 5e-3, outliers=SIZE)  # around the poles the angle changes fast


KINDS = {"VALUE": "NodeSocketFloat", "INT": "NodeSocketInt", "BOOLEAN": "NodeSocketBool", "VECTOR": "NodeSocketVector",
         "RGBA": "NodeSocketColor"}


def new_group(name: str, inputs: dict, outputs: dict):
    """A node group with sockets by name and kind, and its two ends."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    for direction, sockets in (("INPUT", inputs), ("OUTPUT", outputs)):
        for label, kind in sockets.items():
            group.interface.new_socket(name=label, in_out=direction, socket_type=KINDS[kind])
    return group, group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")


def place(tree, group):
    """A group node."""
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    return node


@pytest.mark.parametrize("inner", KINDS)
def test_group_converts(patch, inner):
    """A colour that passes a group's sockets of another kind is converted there."""
    group, start, end = new_group("Through", {"A": inner}, {"B": "RGBA"})
    group.links.new(start.outputs[0], end.inputs[0])

    def build(tree):
        node = place(tree, group)
        tree.links.new(ramp(tree, (0.0, 0.9, 0.2), (2.1, 1.1, 3.8)), node.inputs[0])
        return node.outputs[0]

    patch.compare(build, outliers=2 * SIZE if inner in ("INT", "BOOLEAN") else 0)


def test_nested_groups(patch):
    """Two instances of a group in a group, with their own values, two outputs, and unlinked ends."""
    low, start, end = new_group("Low", {"A": "VALUE", "B": "VALUE"}, {"Sum": "VALUE", "Own": "RGBA"})
    add = feed(low, new(low, "ShaderNodeMath", operation="ADD"), Value=start.outputs[0], Value_001=start.outputs[1])
    low.links.new(add.outputs[0], end.inputs[0])
    end.inputs[1].default_value = (0.3, 0.5, 0.7, 1.0)
    high, start, end = new_group("High", {"X": "VALUE"}, {"Y": "RGBA"})
    one, two = place(high, low), place(high, low)
    one.inputs[1].default_value, two.inputs[1].default_value = 0.25, -0.5
    high.links.new(start.outputs[0], one.inputs[0])
    high.links.new(one.outputs[0], two.inputs[0])
    mix = new(high, "ShaderNodeMix", data_type="RGBA", blend_type="ADD")
    feed(high, mix, Factor_Float=1.0, A_Color=two.outputs[0], B_Color=one.outputs[1])
    high.links.new(out(mix, "Result_Color"), end.inputs[0])

    def build(tree):
        first, second = place(tree, high), place(tree, high)
        tree.links.new(channel(tree, ramp(tree), 0), first.inputs[0])
        second.inputs[0].default_value = 0.4
        node = new(tree, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
        feed(tree, node, Factor_Float=0.8, A_Color=first.outputs[0], B_Color=second.outputs[0])
        return out(node, "Result_Color")

    patch.compare(build)


def test_reroutes(patch):
    def build(tree):
        first, second = tree.nodes.new("NodeReroute"), tree.nodes.new("NodeReroute")
        tree.links.new(ramp(tree), first.inputs[0])
        tree.links.new(first.outputs[0], second.inputs[0])
        return second.outputs[0]

    patch.compare(build)


def test_unlinked_reroute(patch):
    def build(tree):
        reroute = tree.nodes.new("NodeReroute")
        add = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=channel(tree, ramp(tree), 0))
        add.inputs[1].default_value = 0.7
        tree.links.new(reroute.outputs[0], add.inputs[1])
        return add.outputs[0]

    patch.compare(build)


@pytest.mark.parametrize("kind", ["ShaderNodeMath", "ShaderNodeMix", "ShaderNodeInvert", "ShaderNodeTexImage",
                                  "ShaderNodeTexChecker", "ShaderNodeGroup"])
def test_muted_node(patch, kind):
    """A muted node passes its matching input on; one without such an input gives nothing."""
    def build(tree):
        node = tree.nodes.new(kind)
        if kind == "ShaderNodeGroup":
            node.node_tree = new_group("Muted", {"A": "VECTOR"}, {"B": "VECTOR"})[0]
        if kind == "ShaderNodeMix":
            node.data_type = "RGBA"
        own = ("VALUE",) if kind == "ShaderNodeMath" else ("VECTOR", "RGBA")
        socket = next(s for s in node.inputs if not s.is_unavailable and s.type in own)
        tree.links.new(ramp(tree), socket)
        node.mute = True
        add = new(tree, "ShaderNodeVectorMath", operation="ADD")
        result = next(s for s in node.outputs if not s.is_unavailable)
        return feed(tree, add, Vector=result, Vector_001=ramp(tree, (0.0, 0.1, 0.2), (0.3, 0.2, 0.1))).outputs[0]

    patch.compare(build)


def test_muted_link(patch):
    def build(tree):
        add = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=channel(tree, ramp(tree), 0))
        add.inputs[1].default_value = 0.3
        tree.links.new(channel(tree, ramp(tree), 1), add.inputs[1]).is_muted = True
        return add.outputs[0]

    patch.compare(build)


def test_cycle_is_reported(patch):
    def build(tree):
        one = feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=channel(tree, ramp(tree), 0))
        two = feed(tree, new(tree, "ShaderNodeMath", operation="MULTIPLY"), Value=one.outputs[0], Value_001=0.25)
        tree.links.new(two.outputs[0], one.inputs[1])
        return one.outputs[0]

    patch.wire(build)
    value, issues = patch.ours()
    assert any("cycle" in str(issue) for issue in issues)
    assert np.ptp(value) > 0.5


@pytest.mark.parametrize("source", ["VALUE", "VECTOR", "RGBA"])
@pytest.mark.parametrize("target", ["VALUE", "VECTOR", "RGBA"])
def test_implicit_conversion(patch, source, target):
    def build(tree):
        vector = ramp(tree)
        if source == "VALUE":
            vector = channel(tree, vector, 0)
        if source == "RGBA":
            vector = feed(tree, tree.nodes.new("ShaderNodeGamma"), Color=vector, Gamma=1.0).outputs[0]
        if target == "VALUE":
            return feed(tree, new(tree, "ShaderNodeMath", operation="ADD"), Value=vector, Value_001=0.1).outputs[0]
        if target == "VECTOR":
            node = new(tree, "ShaderNodeVectorMath", operation="ADD")
            return feed(tree, node, Vector=vector, Vector_001=(0.1, 0.2, 0.3)).outputs[0]
        return feed(tree, tree.nodes.new("ShaderNodeInvert"), Color=vector, Fac=0.7).outputs[0]

    patch.compare(build)


def test_output_for_cycles(patch):
    """Of several outputs the active one for Cycles counts, then the active one for all."""
    tree = patch.material.node_tree
    tree.nodes.clear()
    for target, strength in (("EEVEE", 1.0), ("ALL", 2.0), ("CYCLES", 3.0)):
        output, emission = new(tree, "ShaderNodeOutputMaterial", target=target), tree.nodes.new("ShaderNodeEmission")
        emission.inputs["Strength"].default_value = strength
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
    for expected in (3.0, 2.0):
        issues = IssueLog()
        graph = material_graph(patch.material, ImageTable(issues), issues)
        program = compile_material(Material("Patch", graph), [], issues)
        np.testing.assert_allclose(program.emission(), [[expected] * 3])
        ours = [node for node in tree.nodes if getattr(node, "target", "") == "CYCLES"]
        for node in ours:
            tree.nodes.remove(node)


def test_no_output(patch):
    patch.material.node_tree.nodes.clear()
    issues = IssueLog()
    assert material_graph(patch.material, ImageTable(issues), issues).surface is None
    assert "no active output" in str(next(iter(issues)))


def test_world_without_links():
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 2.0
    issues = IssueLog()
    graph = world_graph(world, ImageTable(issues), issues)
    np.testing.assert_allclose(constant_background(graph), (0.2, 0.4, 0.6), rtol=1e-6)


def test_back_side(patch):
    """From below: normals turn to the eye, Fresnel inverts the index."""
    def build(tree):
        fresnel = feed(tree, tree.nodes.new("ShaderNodeFresnel"), IOR=1.6)
        side = tree.nodes.new("ShaderNodeNewGeometry")
        split = feed(tree, tree.nodes.new("ShaderNodeSeparateXYZ"), Vector=out(side, "Normal"))
        node = tree.nodes.new("ShaderNodeCombineXYZ")
        return feed(tree, node, X=fresnel.outputs[0], Y=split.outputs[2], Z=out(side, "Backfacing")).outputs[0]

    patch.wire(build)
    patch.camera.location, patch.camera.rotation_euler = (0.0, 0.0, -2.0), (0.0, math.pi, 0.0)
    try:
        theirs = patch.cycles()
        ours, _ = patch.ours(back=True)
    finally:
        patch.camera.location, patch.camera.rotation_euler = (0.0, 0.0, 2.0), (0.0, 0.0, 0.0)
    assert np.abs(ours - theirs).max() < TOLERANCE
