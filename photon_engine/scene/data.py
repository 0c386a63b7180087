"""SceneData: all that a render needs to know of a scene, as plain records and arrays.

Lengths in metres, powers in watts, colours linear Rec. 709, angles in radians, matrices row-major 4x4 double that
map local column vectors to the world (``p_world = M[:3, :3] @ p + M[:3, 3]``).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

IDENTITY = np.eye(4)


@dataclass
class Mesh:
    """One mesh data-block, in its own space; shared by its instances."""

    name: str
    positions: np.ndarray  # (V, 3) f32, local
    triangles: np.ndarray  # (T, 3) i32, indices into positions
    normals: np.ndarray | None  # (T, 3, 3) f32, unit, local, per corner; None: every face is flat
    material_index: np.ndarray | None  # (T,) i32, slot of each triangle; None: all slot 0
    uvs: dict[str, np.ndarray] = field(default_factory=dict)  # layer -> (T, 3, 2) f32
    active_uv: str = ""  # the layer that nodes use when they name none (active for render)
    generated: np.ndarray | None = None  # (V, 3) f32, Generated coordinates; None: from bounds of positions
    attributes: dict[str, np.ndarray] = field(default_factory=dict)  # name -> (T, 3, C) f32, per corner
    island_random: np.ndarray | None = None  # (T,) f32, Geometry > Random Per Island
    tangents: dict[str, np.ndarray] = field(default_factory=dict)  # uv layer -> (T, 3, 4) f32: tangent xyz, sign


@dataclass
class Instance:
    """One visible occurrence of a mesh."""

    mesh: int  # index into SceneData.meshes
    matrix: np.ndarray  # (4, 4) f64, local to world; a negative determinant mirrors
    materials: list[int]  # slot -> index into SceneData.materials; -1: no material (default grey diffuse 0.8);
    # never empty, and every slot that a triangle names is there
    name: str = ""  # the object, for messages
    object_matrix: np.ndarray | None = None  # (4, 4) f64 for Texture Coordinate > Object; None: same as matrix
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    pass_index: int = 0
    random: float = 0.0  # Object Info > Random, in [0, 1)
    attributes: dict[str, tuple[float, ...]] = field(default_factory=dict)  # "OBJECT:name", "INSTANCER:name" -> rgba
    # index, age, lifetime, size, location, velocity, angular velocity (13 numbers); None: it is no particle
    particle: tuple[float, ...] | None = None
    holdout: bool = False  # a hole in the picture: black, alpha 0
    visible_camera: bool = True  # Ray Visibility > Camera
    visible_shadow: bool = True  # Ray Visibility > Shadow
    terminator_offset: float = 0.1  # Shadow Terminator > Geometry Offset: see geometry/terminator.py


@dataclass
class Socket:
    """A node's input: a link when ``node`` >= 0, else a constant value."""

    value: Any = None  # float, [r, g, b], [r, g, b, a] or None (e.g. an unlinked normal: use the surface's)
    node: int = -1  # index into Graph.nodes
    output: str = ""  # identifier of that node's output socket
    kind: str = "VALUE"  # Blender's socket type: VALUE, INT, BOOLEAN, VECTOR, RGBA, SHADER


@dataclass
class Node:
    """A shader node with groups, reroutes and muting already resolved."""

    type: str  # Blender's bl_idname, e.g. "ShaderNodeBsdfPrincipled"
    name: str  # as the user sees it (group path included: "Group/Node"), for messages
    props: dict[str, Any] = field(default_factory=dict)  # enums, flags, image index under "image", ...
    inputs: dict[str, Socket] = field(default_factory=dict)  # by socket *identifier*
    output_kinds: dict[str, str] = field(default_factory=dict)  # output identifier -> Blender's socket type


@dataclass
class Graph:
    """The nodes that a material's (or world's, light's) output reaches, in topological order (inputs first)."""

    nodes: list[Node] = field(default_factory=list)
    surface: Socket | None = None  # what is linked to the Surface input; None: nothing (black)
    volume: Socket | None = None
    displacement: Socket | None = None


@dataclass
class Material:
    """A material: its graph, or no nodes and the viewport colour as a diffuse."""

    name: str
    graph: Graph
    displacement: str = "BUMP"  # BUMP, DISPLACEMENT or BOTH: what the graph's displacement does


@dataclass
class Image:
    """An image data-block: pixels, or where to find them."""

    name: str
    # (H, W, 4) f32, or u8 with 255 for 1; bottom row first, linear scene colour unless `encoded` or Non-Color
    pixels: np.ndarray | None = None
    colorspace: str = "sRGB"  # Blender's name of the space the file was in
    alpha_mode: str = "STRAIGHT"  # pixels here are as Cycles sees them: premultiplied unless CHANNEL_PACKED/NONE
    encoded: bool = False  # the sRGB curve is still on: lookups interpolate first and decode afterwards, as Cycles does
    tiles: dict[int, int] = field(default_factory=dict)  # UDIM: tile number -> index into SceneData.images


BEAM = (513, 256, 3)  # shape of a lamp's map: 0.35 degrees from pole to pole


@dataclass
class Light:
    """A lamp in Cycles' units (see lights/ for the laws)."""

    name: str
    kind: str  # POINT, SPOT, SUN, AREA
    matrix: np.ndarray  # (4, 4) f64, shines along local -Z; columns include the object's scale
    strength: tuple[float, float, float]  # S = energy 2^exposure color temperature_color, linear RGB [W, sun: W/m^2]
    radius: float = 0.0  # POINT, SPOT [m]
    soft_falloff: bool = True  # POINT, SPOT: a disk that faces the shading point instead of a sphere
    spot_size: float = 0.0  # SPOT, full cone [rad]
    spot_blend: float = 0.0  # SPOT, [0, 1]
    angle: float = 0.0  # SUN, full angle of the disk [rad]
    shape: str = "SQUARE"  # AREA: SQUARE, RECTANGLE, DISK, ELLIPSE
    size: tuple[float, float] = (1.0, 1.0)  # AREA, before the object's scale [m]
    spread: float = np.pi  # AREA [rad], pi: no focusing
    normalize: bool = True
    beam: np.ndarray | None = None  # BEAM f32 in [0, 1], times the strength, by direction: lights/beams.py
    graph: Graph | None = None  # nodes whose emission multiplies every sample of the strength: lights/nodes.py
    cast_shadow: bool = True
    visible_camera: bool = True


@dataclass
class World:
    """Light from infinity."""

    name: str = "World"
    graph: Graph | None = None
    color: tuple[float, float, float] = (0.0, 0.0, 0.0)  # colour times strength when the graph is constant


@dataclass
class Camera:
    """A pinhole or thin lens, or parallel rays; looks along local -Z."""

    name: str = "Camera"
    kind: str = "PERSP"  # PERSP, ORTHO
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))  # scale removed
    # the window on the plane at distance 1 (PERSP) or in metres (ORTHO) that the full frame covers, sensor fit and
    # shift and pixel aspect applied: left, right, bottom, top
    window: tuple[float, float, float, float] = (-1.0, 1.0, -1.0, 1.0)
    clip_start: float = 0.1  # along the view axis [m]
    clip_end: float = 1000.0
    aperture_radius: float = 0.0  # [m]; 0: no depth of field
    focus_distance: float = 10.0  # along the view axis [m]
    blades: int = 0  # fewer than 3: a round aperture
    blade_rotation: float = 0.0  # [rad]
    aperture_ratio: float = 1.0  # horizontal over vertical, as Blender's "Ratio"

    def from_world(self) -> np.ndarray:
        """World to camera, (4, 4) f64, with z along the view axis."""
        to_camera = np.linalg.inv(self.matrix)
        to_camera[2] = -to_camera[2]
        return to_camera


@dataclass
class Frame:
    """What part of the picture is wanted, and how it is filtered."""

    width: int = 64  # of the full frame, after resolution percentage [px]
    height: int = 64
    x0: int = 0  # the render border; pictures have the size (y1 - y0, x1 - x0), bottom row first
    y0: int = 0
    x1: int = 64
    y1: int = 64
    crop: bool = False  # whether the border crops the written image
    filter: str = "BLACKMAN_HARRIS"  # BOX, GAUSSIAN, BLACKMAN_HARRIS
    filter_width: float = 1.5  # [px]
    exposure: float = 1.0  # multiplies linear radiance (Film > Exposure)
    transparent: bool = False  # the world is not seen by the camera: alpha 0
    transparent_glass: bool = False


@dataclass
class SceneData:
    """Everything that is rendered, in one frame, through one camera."""

    name: str = "Scene"
    frame_number: int = 1
    meshes: list[Mesh] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    world: World = field(default_factory=World)
    camera: Camera = field(default_factory=Camera)
    frame: Frame = field(default_factory=Frame)
