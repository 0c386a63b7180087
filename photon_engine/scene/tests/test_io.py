import dataclasses
import json
import zipfile

import numpy as np
import pytest

from photon_engine.issues import RenderError
from photon_engine.scene.data import Graph, Image, Instance, Light, Material, Mesh, Node, SceneData, Socket, World
from photon_engine.scene.io import TREE, load_scene, save_scene


def full_scene():
    """A scene in which every record and kind of value occurs."""
    rng = np.random.default_rng(5)
    mesh = Mesh(
        name="Würfel",
        positions=rng.random((4, 3), np.float32),
        triangles=np.array([[0, 1, 2], [1, 3, 2]], np.int32),
        normals=rng.random((2, 3, 3), np.float32),
        material_index=np.array([0, 1], np.int32),
        uvs={"UVMap": rng.random((2, 3, 2), np.float32), "": rng.random((2, 3, 2), np.float32)},
        active_uv="UVMap",
        generated=rng.random((4, 3), np.float32),
        attributes={"$": rng.random((2, 3, 4), np.float32)},
        tangents={"UVMap": rng.random((2, 3, 4), np.float32)},
    )
    nodes = [
        Node("ShaderNodeTexImage", "Image", {"image": 0, "interpolation": "Linear", "flag": True, "none": None},
             {"Vector": Socket(None, kind="VECTOR")}, {"Color": "RGBA"}),
        Node("ShaderNodeBsdfDiffuse", "Diffuse", {"matrix": np.eye(4), "mixed": [1, (2.5, "x"), {"a": [-1e-300]}]},
             {"Color": Socket([0.1, 0.2, 0.3, 1.0], 0, "Color", "RGBA"), "Roughness": Socket(1e-300)}),
    ]  # fmt: skip
    graph = Graph(nodes, Socket(node=1, output="BSDF", kind="SHADER"))
    return SceneData(
        name="Szene",
        meshes=[mesh],
        instances=[Instance(0, np.eye(4), [0, -1], "a", object_matrix=2.0 * np.eye(4), random=1 / 3, holdout=True)],
        materials=[Material("m", graph), Material("empty", Graph())],
        images=[Image("i", np.full((2, 3, 4), np.inf, np.float32)), Image("missing")],
        lights=[Light("l", "AREA", np.eye(4), (1.0, 2.0, 0.1), spread=1.0)],
        world=World("w", graph, (0.1, 0.2, 0.3)),
    )


def assert_same(a, b, where="scene"):
    """Equal in type and value, arrays bit for bit."""
    assert type(a) is type(b), where
    if isinstance(a, np.ndarray):
        assert a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes(), where
    elif dataclasses.is_dataclass(a):
        for item in dataclasses.fields(a):
            assert_same(getattr(a, item.name), getattr(b, item.name), f"{where}.{item.name}")
    elif isinstance(a, dict):
        assert list(a) == list(b), where
        for key in a:
            assert_same(a[key], b[key], f"{where}[{key!r}]")
    elif isinstance(a, (list, tuple)):
        assert len(a) == len(b), where
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{where}[{i}]")
    else:
        assert a == b, where


def test_round_trip_is_exact(tmp_path):
    scene = full_scene()
    scene.materials[0].graph.nodes[0].props |= {"scalar": np.float32(0.1), "set": frozenset({"a", "b"}), "t": (1, (2,))}
    save_scene(scene, tmp_path / "s.photon")
    assert_same(scene, load_scene(tmp_path / "s.photon"))
    assert [p.name for p in tmp_path.iterdir()] == ["s.photon"]


def test_an_object_that_needs_pickle_is_refused_on_saving(tmp_path):
    scene = full_scene()
    scene.materials[0].graph.nodes[0].props["bad"] = np.array([object()])
    with pytest.raises(TypeError, match="object"):
        save_scene(scene, tmp_path / "s.npz")
    assert not list(tmp_path.iterdir())


def test_an_unwritable_path_is_a_users_problem(tmp_path):
    with pytest.raises(RenderError, match="cannot be written"):
        save_scene(SceneData(), tmp_path / "no" / "such" / "folder.npz")


def rewrite(path, change):
    """Pass the archive's arrays and tree through ``change``."""
    with np.load(path) as archive:
        arrays = dict(archive)
    tree = json.loads(arrays.pop(TREE).tobytes())
    change(tree, arrays)
    arrays[TREE] = np.frombuffer(json.dumps(tree).encode(), np.uint8)
    with open(path, "wb") as file:
        np.savez(file, **arrays)


MESH = ("scene", "meshes", 0)


def put(*keys_and_value):
    """A change that sets one entry of the tree."""
    *keys, value = keys_and_value

    def change(tree, arrays):
        for key in keys[:-1]:
            tree = tree[key]
        tree[keys[-1]] = value

    return change


def triangle_out_of_range(tree, arrays):
    arrays[tree["scene"]["meshes"][0]["triangles"]["name"]][0, 0] = 99


def undefined_position(tree, arrays):
    arrays[tree["scene"]["meshes"][0]["positions"]["name"]][0, 0] = np.nan


def short_normals(tree, arrays):
    name = tree["scene"]["meshes"][0]["normals"]["name"]
    arrays[name] = arrays[name][:1]


def drop_field(tree, arrays):
    del tree["scene"]["camera"]["window"]


@pytest.mark.parametrize(("change", "message"), [
    (put("version", 999), "version 999"),
    (put("format", "else"), "not a scene"),
    (put("scene", None), "no scene"),
    (put(*MESH, {"$": "os.system", "items": []}), "os.system"),
    (put(*MESH, "positions", {"$": "array", "name": "gone"}), "gone"),
    (put(*MESH, "surplus", 1), "surplus"),
    (drop_field, "window"),
    (triangle_out_of_range, "vertex 99"),
    (undefined_position, "positions"),
    (short_normals, "normals"),
    (put("scene", "instances", 0, "mesh", 7), "mesh 7"),
    (put("scene", "instances", 0, "materials", [0, 5]), "material"),
    (put("scene", "lights", 0, "kind", "LASER"), "LASER"),
    (put("scene", "frame", "x1", 999), "border"),
    (put("scene", "materials", 0, "graph", "surface", "node", 9), "output"),
])  # fmt: skip
def test_malformed_scenes_are_named(tmp_path, change, message):
    path = tmp_path / "s.npz"
    save_scene(full_scene(), path)
    rewrite(path, change)
    with pytest.raises(RenderError, match=message):
        load_scene(path)


def test_links_to_later_nodes_are_refused(tmp_path):
    scene = full_scene()
    scene.materials[0].graph.nodes[0].inputs["Vector"].node = 1
    save_scene(scene, tmp_path / "s.npz")
    with pytest.raises(RenderError, match="out of order"):
        load_scene(tmp_path / "s.npz")


def test_files_that_are_no_scene(tmp_path):
    with pytest.raises(RenderError, match="no such file"):
        load_scene(tmp_path / "missing.npz")
    path = tmp_path / "text.npz"
    path.write_text("hello")
    with pytest.raises(RenderError, match="not a scene file"):
        load_scene(path)
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(RenderError, match="not a scene file"):
        load_scene(tmp_path / "array.npy")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.txt", "x")
    with pytest.raises(RenderError, match=r"not a scene|damaged"):
        load_scene(path)
    np.savez(path, a=np.zeros(2))
    with pytest.raises(RenderError, match="not a scene"):
        load_scene(path)
    np.savez(path, **{TREE: np.array([{}], object)})
    with pytest.raises(RenderError, match=r"not a scene|damaged"):
        load_scene(path)


@pytest.mark.parametrize("keep", [0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_damaged(tmp_path, keep):
    path = tmp_path / "s.npz"
    save_scene(full_scene(), path)
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * keep)])
    with pytest.raises(RenderError):
        load_scene(path)
