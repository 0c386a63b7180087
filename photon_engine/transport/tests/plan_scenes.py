"""Small scenes of every kind of surface and light, for what a plan may leave out."""

import numpy as np

from ...scene.data import Camera, Frame, Graph, Instance, Light, Material, Mesh, Node, SceneData, Socket, World


def shader(kind, color=(0.8, 0.7, 0.6), **values):
    """A material of one shader node."""
    output = "Emission" if kind == "Emission" else "BSDF"
    node = "ShaderNodeEmission" if kind == "Emission" else f"ShaderNodeBsdf{kind}"
    key = "Base Color" if kind == "Principled" else "Color"
    inputs = {key: Socket([*color, 1.0], kind="RGBA")}
    inputs |= {name.replace("_", " "): Socket(value) for name, value in values.items()}
    return Graph([Node(node, kind, {}, inputs, {output: "SHADER"})], Socket(None, 0, output, "SHADER"))


def mixed(a, b, share=0.5):
    """Two one-node materials mixed."""
    first, second = a.nodes[0], b.nodes[0]
    inputs = {
        "Fac": Socket(share), "Shader": Socket(None, 0, a.surface.output, "SHADER"),
        "Shader_001": Socket(None, 1, b.surface.output, "SHADER"),
    }  # fmt: skip
    mix = Node("ShaderNodeMixShader", "Mix", {}, inputs, {"Shader": "SHADER"})
    return Graph([first, second, mix], Socket(None, 2, "Shader", "SHADER"))


def textured():
    """A colour that follows the UVs."""
    uv = Node("ShaderNodeTexCoord", "UV", {}, {}, {"UV": "VECTOR"})
    inputs = {"Color": Socket(None, 0, "UV", "RGBA"), "Roughness": Socket(0.0)}
    diffuse = Node("ShaderNodeBsdfDiffuse", "Diffuse", {}, inputs, {"BSDF": "SHADER"})
    return Graph([uv, diffuse], Socket(None, 1, "BSDF", "SHADER"))


def inked():
    """Clear glass whose inside absorbs."""
    graph = shader("Glass", Roughness=0.0, IOR=1.5)
    inputs = {"Color": Socket([0.2, 0.4, 0.9, 1.0], kind="RGBA"), "Density": Socket(2.0)}
    graph.nodes.append(Node("ShaderNodeVolumeAbsorption", "Ink", {}, inputs, {"Volume": "SHADER"}))
    graph.volume = Socket(None, 1, "Volume", "SHADER")
    return graph


def sheltered(kind):
    """A colour, or a normal, that rays of the node's own find out."""
    if kind == "Bevel":
        inputs = {"Radius": Socket(0.1), "Normal": Socket(None, kind="VECTOR")}
        near = Node("ShaderNodeBevel", kind, {"samples": 2}, inputs, {"Normal": "VECTOR"})
        inputs = {"Color": Socket([0.7, 0.8, 0.6, 1.0], kind="RGBA"), "Roughness": Socket(0.0),
                  "Normal": Socket(None, 0, "Normal", "VECTOR")}  # fmt: skip
    else:
        inputs = {"Color": Socket([0.9, 0.8, 0.7, 1.0], kind="RGBA"), "Distance": Socket(1.0),
                  "Normal": Socket(None, kind="VECTOR")}  # fmt: skip
        props = {"samples": 2, "inside": False, "only_local": False}
        near = Node("ShaderNodeAmbientOcclusion", kind, props, inputs, {"Color": "RGBA", "AO": "VALUE"})
        inputs = {"Color": Socket(None, 0, "Color", "RGBA"), "Roughness": Socket(0.0)}
    diffuse = Node("ShaderNodeBsdfDiffuse", "Diffuse", {}, inputs, {"BSDF": "SHADER"})
    return Graph([near, diffuse], Socket(None, 1, "BSDF", "SHADER"))


MATTE = shader("Diffuse", Roughness=0.0)
MATERIALS = {
    "Matte": MATTE,
    "Black": shader("Diffuse", (0.0, 0.0, 0.0), Roughness=0.0),
    "Mirror": shader("Glossy", Roughness=0.0),
    "Polished": shader("Glossy", Roughness=0.2),
    "Satin": shader("Glossy", Roughness=0.7),
    "Glass": shader("Glass", Roughness=0.0, IOR=1.5),
    "Frosted": shader("Glass", Roughness=0.3, IOR=1.5),
    "Plastic": shader("Principled", Roughness=0.1),
    "Clear": shader("Transparent"),
    "Bubble": shader("Glass", Roughness=0.0, IOR=1.0, Thin_Film_Thickness=400.0, Thin_Film_IOR=1.4),
    "Wall": shader("Principled", Roughness=0.0, Transmission_Weight=1.0, IOR=1.5, Thin_Wall=True),
    "Blind": shader("Principled", Roughness=0.4, Transmission_Weight=0.7, IOR=1.5, Thin_Wall=True),
    "Half": mixed(MATTE, shader("Transparent")),
    "Hidden": mixed(MATTE, shader("Glossy", Roughness=0.0), 0.0),
    "Glow": shader("Emission", Strength=2.0),
    "Dark Glow": shader("Emission", Strength=0.0),
    "Painted": textured(),
    "Sooty": sheltered("Ambient Occlusion"),
    "Worn": sheltered("Bevel"),
    "Ink": inked(),
    "Wax": shader("Principled", Roughness=0.4, Subsurface_Weight=1.0, Subsurface_Scale=0.5),
    "Glazed": shader("Principled", Roughness=0.0, Subsurface_Weight=0.7, Subsurface_Scale=0.2),
}


SPARE = Material("Spare", textured())


def place(x, y, z):
    """A lamp there that looks down."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def lamp_graph(falloff=""):
    """Nodes of a lamp: its UVs as a colour, and a Light Falloff."""
    uv = Node("ShaderNodeTexCoord", "UV", {}, {}, {"UV": "VECTOR"})
    inputs = {"Strength": Socket(1.0), "Smooth": Socket(0.0)}
    fall = Node("ShaderNodeLightFalloff", "Falloff", {}, inputs, {"Linear": "VALUE"})
    strength = Socket(None, 1, falloff) if falloff else Socket(2.0)
    inputs = {"Color": Socket(None, 0, "UV", "RGBA"), "Strength": strength}
    shine = Node("ShaderNodeEmission", "Emission", {}, inputs, {"Emission": "SHADER"})
    return Graph([uv, fall, shine], Socket(None, 2, "Emission", "SHADER"))


LAMPS = {
    "Point": Light("Point", "POINT", place(0.5, 0.3, 2.5), (30.0, 30.0, 30.0)),
    "Bulb": Light("Bulb", "POINT", place(0.5, 0.3, 2.5), (30.0, 20.0, 30.0), radius=0.2),
    "Spot": Light("Spot", "SPOT", place(0.0, 0.0, 2.8), (40.0, 40.0, 40.0), spot_size=1.0, spot_blend=0.2),
    "Sun": Light("Sun", "SUN", place(0.0, 0.0, 0.0), (2.0, 2.0, 1.0)),
    "Soft Sun": Light("Soft Sun", "SUN", place(0.0, 0.0, 0.0), (2.0, 2.0, 1.0), angle=0.2),
    "Area": Light("Area", "AREA", place(0.2, 0.0, 2.6), (20.0, 20.0, 20.0), size=(0.4, 0.4)),
    "Beam": Light("Beam", "AREA", place(0.2, 0.0, 2.6), (9.0, 9.0, 9.0), size=(0.4, 0.4), spread=0.0),
    "Mapped": Light(
        "Mapped", "POINT", place(0.5, 0.3, 2.5), (30.0, 30.0, 30.0), radius=0.1,
        beam=np.random.default_rng(2).random((9, 8, 3)).astype(np.float32),
    ),
    "Picture": Light("Picture", "AREA", place(0.2, 0.0, 2.6), (20.0, 20.0, 20.0), size=(0.9, 0.6), graph=lamp_graph()),
    "Falloff": Light(
        "Falloff", "POINT", place(0.4, 0.2, 2.4), (9.0, 9.0, 9.0), radius=0.2, soft_falloff=False,
        graph=lamp_graph("Linear"),
    ),
    "Gobo": Light(
        "Gobo", "SPOT", place(0.0, 0.0, 2.8), (40.0, 40.0, 40.0), spot_size=1.0, cast_shadow=False, graph=lamp_graph(),
    ),
    "Dead": Light("Dead", "POINT", place(0.0, 0.0, 2.0), (0.0, 0.0, 0.0)),
    "Ghostly": Light("Ghostly", "AREA", place(0.2, 0.0, 2.6), (9.0, 9.0, 9.0), cast_shadow=False),
}


def square(smooth=False):
    """The square [-1, 1]^2, with UVs."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    normals = corners + np.float32([0.0, 0.0, 2.0])
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True))[triangles] if smooth else None
    uv = (0.5 * corners[:, :2] + 0.5)[triangles]
    return Mesh("Square", corners, triangles, normals, None, uvs={"UV": uv}, active_uv="UV")


def scene(floor="Matte", wall="Matte", pane="Glass", lamps=("Area",), sky=0.0, **more):
    """A floor and a wall, a tilted smooth pane between them and the lamps, seen from above; 12 x 12 pixels.

    more : aperture [m]; ghost: the pane casts no shadow; spare: there is a material that nothing wears.
    """
    names = list(dict.fromkeys((floor, wall, pane)))
    upright = np.array([[0, 0, -1, -1.0], [0, 1, 0, 0], [1, 0, 0, 1.0], [0, 0, 0, 1]])
    tilted = np.array([[0.5, 0, 0.1, 0.2], [0, 0.5, 0, 0], [-0.1, 0, 0.5, 1.0], [0, 0, 0, 1]])
    slot = [[names.index(name)] for name in (floor, wall, pane)]
    camera = Camera(matrix=place(0.0, 0.0, 4.0), window=(-0.35, 0.35, -0.35, 0.35))
    camera.aperture_radius = more.get("aperture", 0.0)
    return SceneData(
        meshes=[square(), square(smooth=True)],
        instances=[
            Instance(0, np.eye(4), slot[0], "Floor"), Instance(0, upright, slot[1], "Wall"),
            Instance(1, tilted, slot[2], "Pane", visible_shadow=not more.get("ghost", False)),
        ],
        materials=[Material(name, MATERIALS[name]) for name in names] + more.get("spare", False) * [SPARE],
        lights=[LAMPS[name] for name in lamps],
        world=World("Sky", color=(sky, sky, sky)),
        camera=camera,
        frame=Frame(12, 12, 0, 0, 12, 12),
    )  # fmt: skip
