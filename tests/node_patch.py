"""A node's output in Cycles and in ours: it shines from a flat patch, one sample at each pixel's centre.

The patch is 2 m wide, seen from 2 m above by a perspective camera that it fills, so that view directions vary.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
oiio = pytest.importorskip("OpenImageIO")

from photon_engine.blender.extract import extract_scene  # noqa: E402
from photon_engine.blender.images import ImageTable  # noqa: E402
from photon_engine.blender.node_trees import material_graph  # noqa: E402
from photon_engine.issues import IssueLog  # noqa: E402
from photon_engine.scene.data import Material  # noqa: E402
from photon_engine.settings import Settings  # noqa: E402
from photon_engine.shading.material import compile_material  # noqa: E402
from photon_engine.shading.points import ObjectTable, ShadePoints  # noqa: E402
from photon_engine.shading.trail import CAMERA  # noqa: E402
from photon_engine.transport.renderer import Renderer  # noqa: E402
from tests.oracle.cycles import write_float_exr  # noqa: E402

SIZE = 32
# Cycles' filter of 0.01 px shifts samples by up to 0.005 px, which is measured once; half-float tables and float32
# arithmetic remain; through the whole engine, whose samples lie within 0.0005 px of Cycles', what slopes make of it
TOLERANCE = 1e-3
# pixels in which rounding may decide on which side of a jump a sample is: over all tests 3 at most, of Wireframe
EDGES = 4
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
        write_float_exr(scene.render.image_settings)
        camera = bpy.data.cameras.new("Camera")
        camera.angle = 2.0 * math.atan(0.5)
        self.camera = bpy.data.objects.new("Camera", camera)
        self.camera.location = (0.0, 0.0, 2.0)
        scene.collection.objects.link(self.camera)
        scene.camera = self.camera
        self.material = bpy.data.materials.new("Patch")
        self.material.use_nodes = True
        self._mesh()
        self.places = self._measured_places()

    def _measured_places(self) -> np.ndarray:
        """Where Cycles' sample of each pixel lies on the patch, (SIZE * SIZE, 2) f32 in [-1, 1], for all nodes."""
        self.wire(lambda tree: out(tree.nodes.new("ShaderNodeUVMap"), "UV"))
        return (2.0 * self.cycles()[:, :2] - 1.0).astype(np.float32)

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
        """The points that Cycles' samples see."""
        x, y = self.places.T
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
            camera=to_camera.astype(np.float32), window=(-0.5, 0.5, -0.5, 0.5, 1.0),
            trail=np.full(n, CAMERA, np.int64),
        )

    def ours(self, back: bool = False) -> tuple[np.ndarray, IssueLog]:
        """Our picture, (SIZE * SIZE, 3), and what was reported."""
        issues = IssueLog()
        table = ImageTable(issues)
        graph = material_graph(self.material, table, issues)
        program = compile_material(Material("Patch", graph), table.images, issues)
        value = 4.0 * (program.emission(self.points(back)) - LIFT)
        return np.broadcast_to(value, (SIZE * SIZE, 3)), issues

    def engine(self) -> np.ndarray:
        """The whole engine's picture of what shines, (SIZE * SIZE, 3), brought back to the node's value."""
        return 4.0 * (self.rendered("Emission")[0] - LIFT)

    def rendered(self, name: str) -> tuple[np.ndarray, IssueLog]:
        """A pass of the whole engine, (SIZE * SIZE, 3), and what was reported."""
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        issues = IssueLog()
        scene = extract_scene(graph, issues)
        scene.frame.filter_width = 1e-4  # Blender's own boxes are a pixel wide, and Cycles' one sample is in the middle
        renderer = Renderer(scene, Settings(caustic_photons=0, diffuse_photons=0), issues)
        renderer.prepare(lambda text: None)
        picture = renderer.render_pass(0, lambda: False)[name]
        renderer.close()
        return np.asarray(picture).reshape(-1, 3), issues

    def compare_engine(self, build, tolerance: float = TOLERANCE, outliers: int = 0, flat: bool | None = False) -> None:
        """As `compare`, but through extraction and the eye pass; black pixels (nothing there) count too."""
        self.wire(build)
        self._judge(self.engine(), np.maximum(self.cycles(), -4.0 * LIFT), (tolerance, outliers, flat))

    def compare(self, build, tolerance: float = TOLERANCE, outliers: int = 0, flat: bool = False) -> IssueLog:
        """Assert that ours and Cycles' pictures agree but for some pixels on edges; flat: no variation is expected."""
        self.wire(build)
        theirs = np.maximum(self.cycles(), -4.0 * LIFT)
        ours, issues = self.ours()
        self._judge(ours, theirs, (tolerance, outliers, flat))
        return issues

    @staticmethod
    def _judge(ours: np.ndarray, theirs: np.ndarray, limits: tuple[float, int, bool | None]) -> None:
        """Assert that two pictures agree; limits: tolerance, pixels that may differ, whether flat (None: either)."""
        tolerance, outliers, flat = limits
        error = np.abs(ours - theirs) / np.maximum(1.0, np.abs(theirs))
        bad = (error.max(axis=1) > tolerance).sum()
        worst = error.max(axis=1).argmax()
        assert bad <= outliers, f"{bad} pixels differ; worst: ours {ours[worst]}, Cycles {theirs[worst]}"
        assert flat is None or flat == (np.ptp(theirs, axis=0).max() < 1e-5)


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
