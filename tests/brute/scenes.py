"""Scenes built from arrays: constant materials, simple shapes, boxes of one unit."""

import numpy as np

from photon_engine.scene.data import (
    Camera,
    Frame,
    Graph,
    Instance,
    Light,
    Material,
    Mesh,
    Node,
    SceneData,
    Socket,
    World,
)


def material(kind, color=(0.8, 0.8, 0.8), name="", **values):
    """A Material of one closure node (`kind` without "ShaderNode") with a constant colour and values."""
    inputs = {"Color": Socket((*np.broadcast_to(color, 3).tolist(), 1.0), kind="RGBA")}
    inputs.update({key: Socket(float(value)) for key, value in values.items()})
    node = closure(kind, inputs)
    return Material(name or kind, Graph([node], Socket(node=0, output=node_output(kind), kind="SHADER")))


def node_output(kind):
    """Identifier of a closure node's output."""
    return {"Emission": "Emission", "Background": "Background"}.get(kind, "Shader" if "Mix" in kind else "BSDF")


def closure(kind, inputs):
    """A node with one shader output, and the properties that Blender gives it."""
    props = {"distribution": "MULTI_GGX"} if kind in ("BsdfGlass", "BsdfAnisotropic") else {}
    return Node("ShaderNode" + kind, kind, props, inputs, {node_output(kind): "SHADER"})


def diffuse(color=0.5):
    """Lambert."""
    return material("BsdfDiffuse", color, Roughness=0.0)


def mirror(color=0.9):
    """Glossy without roughness."""
    return material("BsdfAnisotropic", color, Roughness=0.0)


def glass(ior=1.5, color=1.0):
    """Smooth dielectric."""
    return material("BsdfGlass", color, Roughness=0.0, IOR=ior)


def transparent(color=1.0):
    """Straight through."""
    return material("BsdfTransparent", color)


def emitter(radiance=1.0, color=1.0):
    """Radiates on both sides."""
    return material("Emission", color, Strength=radiance)


def mixed(first, second, factor=0.5, add=False):
    """Mix (or Add) of two one-closure materials."""
    nodes = [*first.graph.nodes, *second.graph.nodes]
    names = [m.graph.surface.output for m in (first, second)]
    kind = "AddShader" if add else "MixShader"
    inputs = {} if add else {"Fac": Socket(float(factor))}
    inputs["Shader"] = Socket(node=0, output=names[0], kind="SHADER")
    inputs["Shader_001"] = Socket(node=1, output=names[1], kind="SHADER")
    nodes.append(Node("ShaderNode" + kind, kind, {}, inputs, {"Shader": "SHADER"}))
    return Material(f"{first.name} + {second.name}", Graph(nodes, Socket(node=2, output="Shader", kind="SHADER")))


def mesh(positions, triangles, normals=None, name="mesh"):
    """A Mesh in float32."""
    normals = None if normals is None else np.asarray(normals, np.float32)
    return Mesh(name, np.asarray(positions, np.float32), np.asarray(triangles, np.int32), normals, None)


def quad(centre, x, y, name="quad"):
    """A parallelogram with half axes x and y; its front faces x cross y."""
    c, x, y = (np.asarray(v, float) for v in (centre, x, y))
    return mesh([c - x - y, c + x - y, c + x + y, c - x + y], [[0, 1, 2], [0, 2, 3]], name=name)


def sphere(centre, radius, segments=48, smooth=True, name="sphere"):
    """A latitude-longitude ball with `segments` around and half as many from pole to pole."""
    rings = segments // 2
    theta = np.linspace(0, np.pi, rings + 1)[1:-1, None]
    phi = np.linspace(0, 2 * np.pi, segments, endpoint=False)[None]
    xyz = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi], -1)
    unit = np.concatenate([[[0, 0, 1]], xyz.reshape(-1, 3), [[0, 0, -1]]])
    at = 1 + np.arange((rings - 1) * segments).reshape(rings - 1, segments)
    right = np.roll(at, -1, axis=1)
    south = np.full_like(at[0], len(unit) - 1)
    parts = [np.stack([0 * at[0], at[0], right[0]], -1), np.stack([south, right[-1], at[-1]], -1)]
    for a, b, c, d in zip(at[:-1], at[1:], right[1:], right[:-1], strict=True):
        parts += [np.stack([a, b, c], -1), np.stack([a, c, d], -1)]
    triangles = np.concatenate(parts)
    return mesh(np.asarray(centre) + radius * unit, triangles, unit[triangles] if smooth else None, name)


def box(lo, hi, inward=False, name="box"):
    """A closed box of 12 triangles that faces outward, or inward."""
    lo, hi = np.asarray(lo, float), np.asarray(hi, float)
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (hi - lo) + lo
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    return mesh(corners, triangles[:, ::-1] if inward else triangles, name=name)


def look_at(eye, target, up=(0.0, 0.0, 1.0)):
    """Matrix of an object at `eye` whose local -Z points to `target`."""
    eye = np.asarray(eye, float)
    z = eye - np.asarray(target, float)
    z /= np.linalg.norm(z)
    x = np.cross(up, z)
    x = np.cross((0.0, 1.0, 0.0), z) if np.linalg.norm(x) < 1e-9 else x
    x /= np.linalg.norm(x)
    m = np.eye(4)
    m[:3, :4] = np.stack([x, np.cross(z, x), z, eye], axis=1)
    return m


def camera(eye, target, half_width=0.5, **changes):
    """A pinhole whose square window at distance 1 has the given half width; half_width in metres when ORTHO."""
    w = half_width
    return Camera("Camera", matrix=look_at(eye, target), window=(-w, w, -w, w), **{"clip_start": 1e-3, **changes})


def frame(size=32, **changes):
    """A square picture with a box filter."""
    whole = {"x0": 0, "y0": 0, "x1": size, "y1": size, "filter": "BOX", "filter_width": 1.0}
    return Frame(size, size, **{**whole, **changes})


def build(parts, lights=(), view=None, world=(0.0, 0.0, 0.0), picture=None):
    """SceneData of (mesh, material) pairs, each an instance in place."""
    scene = SceneData("Test", lights=list(lights), world=World(color=world), camera=view or Camera())
    scene.frame = picture or frame()
    for i, (shape, stuff) in enumerate(parts):
        scene.meshes.append(shape)
        scene.materials.append(stuff)
        scene.instances.append(Instance(i, np.eye(4), [i], name=f"{shape.name} {i}"))
    return scene


def area_lamp(eye, target, size, power, shape="SQUARE", **changes):
    """An area lamp at `eye` that faces `target` [W]."""
    size = tuple(np.broadcast_to(size, 2).astype(float).tolist())
    strength = tuple(np.broadcast_to(power, 3).astype(float).tolist())
    return Light("Area", "AREA", look_at(eye, target), strength, shape=shape, size=size, **changes)


def point_lamp(at, radius, power, soft=False, **changes):
    """A ball (soft: a facing disk), or a point [W]."""
    strength = tuple(np.broadcast_to(power, 3).astype(float).tolist())
    return Light("Point", "POINT", look_at(at, np.add(at, (0, 0, -1))), strength, radius, soft, **changes)


def sun_lamp(toward, angle, irradiance):
    """A sun that shines along the vector `toward` [W/m^2]."""
    strength = tuple(np.broadcast_to(irradiance, 3).astype(float).tolist())
    return Light("Sun", "SUN", look_at((0, 0, 0), toward), strength, angle=angle)


WHITE, RED, GREEN = (0.7, 0.7, 0.7), (0.65, 0.1, 0.08), (0.12, 0.45, 0.1)


def room(back=True):
    """Floor, ceiling and walls of [-1, 1]^3, open toward -y where the camera stands."""
    parts = [
        (quad((0, 0, -1), (1, 0, 0), (0, 1, 0), "floor"), diffuse(WHITE)),
        (quad((0, 0, 1), (0, 1, 0), (1, 0, 0), "ceiling"), diffuse(WHITE)),
        (quad((-1, 0, 0), (0, 1, 0), (0, 0, 1), "left"), diffuse(RED)),
        (quad((1, 0, 0), (0, 0, 1), (0, 1, 0), "right"), diffuse(GREEN)),
    ]
    if back:
        parts.append((quad((0, 1, 0), (1, 0, 0), (0, 0, 1), "back"), diffuse(WHITE)))
    return parts


def cornell(variant="lamp", size=32):
    """A small room with a glass ball and a mirror ball, 4 units before the camera.

    variant : "lamp" (0.5 area lamp), "mesh" (the same light as an emissive mesh), "world" (constant light from the
    open front and back), "panel" (lamp behind a tinted see-through sheet), "mirror" (a mirror for a back wall),
    "sphere" (ball lamp), "sun" (through the front).
    """
    parts = room(back=variant not in ("world", "mirror"))
    parts.append((sphere((0.4, -0.3, -0.6), 0.4, 64), glass(1.5)))
    parts.append((sphere((-0.45, 0.3, -0.55), 0.4, 64), mirror((0.9, 0.85, 0.7))))
    lights, world = [], (0.0, 0.0, 0.0)
    if variant == "mesh":
        parts.append((quad((0, 0, 0.95), (0, 0.25, 0), (0.25, 0, 0), "glow"), emitter(4.0)))
    elif variant == "world":
        world = (0.8, 0.9, 1.0)
    elif variant == "sphere":
        lights = [point_lamp((0, 0, 0.6), 0.2, 12.0)]
    elif variant == "sun":
        lights = [sun_lamp((0.3, 1.0, -0.7), 0.6, 3.0)]
    else:
        lights = [area_lamp((0, 0, 0.95), (0, 0, 0), 0.5, 4.0 * np.pi * 0.25)]
    if variant == "panel":
        parts.append((quad((0, 0, 0.4), (0.8, 0, 0), (0, 0.8, 0), "panel"), transparent((0.9, 0.6, 0.3))))
    if variant == "mirror":
        parts.append((quad((0, 1, 0), (1, 0, 0), (0, 0, 1), "back"), mirror(0.9)))
    return build(parts, lights, camera((0, -4, 0), (0, 0, 0), 0.34), world, frame(size))


VARIANTS = ("lamp", "mesh", "world", "panel", "mirror", "sphere", "sun")
