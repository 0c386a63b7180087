"""Scene files with something wrong in them: in the bytes, the arrays, or the description."""

from __future__ import annotations

import copy
import io
import json
import zipfile
from functools import cache
from pathlib import Path

import numpy as np

from photon_engine.scene.io import TREE

JUNK = (
    None, True, False, 0, -1, 1, 7, 2**31, -(2**31), 2**63, 2**70, 0.0, -0.5, 1e-300, 1e30, -1e30, 1e308, float("nan"),
    float("inf"), "", "x", "\0", "ä" * 1000, [], [0], [1.0, 2.0], [[]], {}, {"$": "dict", "items": []},
    {"$": "Mesh"}, {"$": "array", "name": "a0"}, {"$": "scalar", "name": "a1"}, {"$": []}, {"$": "tuple", "items": [1]},
)  # fmt: skip
TYPES = ("u1", "i1", "i4", "i8", "u8", "f2", "f4", "f8", "c8", "?", "S3", "U2", "M8[s]", ">f4", ">i4")
NUMBERS = (0, 1, -1, 2, 127, 255, 2**31 - 1, -(2**31), 1e-38, 1e30, -1e30, np.nan, np.inf, -np.inf)


def mutant(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """What was done to a scene file, and the file."""
    kind = rng.choice(["bytes", "array", "tree", "tree", "both"])
    if kind == "bytes":
        return broken_bytes(content, rng)
    with np.load(io.BytesIO(content)) as archive:
        arrays = dict(archive)
    said = []
    if kind in ("array", "both"):
        said.append(broken_array(arrays, rng))
    if kind in ("tree", "both"):
        said += [broken_tree(arrays, rng) for _ in range(rng.integers(1, 4))]
    return ", ".join(said), packed(arrays, bool(rng.random() < 0.2))


def packed(arrays: dict[str, np.ndarray], small: bool = False) -> bytes:
    """The file of these arrays."""
    out = io.BytesIO()
    (np.savez_compressed if small else np.savez)(out, **arrays)
    return out.getvalue()


def broken_bytes(content: bytes, rng) -> tuple[str, bytes]:
    """Cut off, with some bits turned over, a piece gone, doubled or blank."""
    data, what = bytearray(content), rng.choice(["cut", "flip", "blank", "drop", "twice", "noise"])
    a = int(rng.integers(len(data)))
    b = min(len(data), a + int(rng.integers(1, 4000)))
    if what == "cut":
        del data[a:]
    elif what == "flip":
        # half of them in the directory at the end, where names and sizes are
        for _ in range(rng.integers(1, 20)):
            at = int(rng.integers(len(data)) if rng.random() < 0.5 else len(data) - 1 - rng.integers(2000))
            data[at] ^= 1 << int(rng.integers(8))
    elif what == "blank":
        data[a:b] = bytes(b - a)
    elif what == "drop":
        del data[a:b]
    elif what == "twice":
        data[a:a] = data[a:b]
    else:
        data[a:b] = rng.bytes(b - a)
    return f"{what} at {a} to {b} of {len(content)}", bytes(data)


def broken_array(arrays: dict[str, np.ndarray], rng) -> str:
    """One array of another type or shape, with odd numbers, or gone."""
    name = str(rng.choice(sorted(set(arrays) - {TREE})))
    old, what = arrays[name], rng.choice(["type", "shape", "number", "numbers", "gone"])
    if what == "type":
        to = str(rng.choice(TYPES))
        with np.errstate(all="ignore"):
            arrays[name] = np.zeros(old.shape, to) if to[0] in "SUM" else old.astype(to)
    elif what == "shape":
        shapes = [old.ravel(), old[..., None], old[:0], old[:1], old[..., :1], old.T, np.concatenate([old, old])]
        arrays[name] = shapes[rng.integers(len(shapes))] if old.ndim else old[None]
    elif what == "gone":
        del arrays[name]
    else:
        new = old.copy().reshape(-1)
        count = 1 if what == "number" else max(1, new.size // 3)
        with np.errstate(all="ignore"):
            value = np.asarray(NUMBERS[rng.integers(len(NUMBERS))], np.float64).astype(old.dtype)
        if new.size:
            new[rng.integers(new.size, size=count)] = value
        arrays[name] = new.reshape(old.shape)
    return f"{what} of array {name}"


def broken_tree(arrays: dict[str, np.ndarray], rng) -> str:
    """One entry of the description replaced, removed, or exchanged for another one's."""
    tree = json.loads(arrays[TREE].tobytes())
    places = list(entries(tree))
    holder, key, path = places[rng.integers(len(places))]
    what = rng.choice(["junk", "number", "swap", "gone", "near", "near", "near", "near"])
    if what == "junk":
        holder[key] = JUNK[rng.integers(len(JUNK))]
    elif what == "near":  # of the same type, so that it gets further
        holder[key] = near(holder[key], tree, rng)
    elif what == "number":
        holder[key] = float(NUMBERS[rng.integers(len(NUMBERS))])
    elif what == "swap":
        other, name, _ = places[rng.integers(len(places))]
        holder[key] = copy.deepcopy(other[name])
    else:
        del holder[key]
    arrays[TREE] = np.frombuffer(json.dumps(tree).encode(), np.uint8)
    return f"{what} at {path}"


def near(value, tree, rng):
    """Another value of the same type."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return int(rng.choice([0, 1, -1, 2, 3, 7, 1000, 65536, 2**31 - 1]))
    if isinstance(value, float):
        return float(rng.choice([0.0, -0.0, -1.0, 1e-300, 1e-20, 1e-6, 0.5, 1.0, 3.0, 1e3, 1e6, 1e12, 1e20, 3e38]))
    if isinstance(value, str):
        words = [holder[key] for holder, key, _ in entries(tree) if isinstance(holder[key], str)]
        return words[rng.integers(len(words))]
    if isinstance(value, list) and value:
        return [value[i] for i in rng.integers(len(value), size=rng.integers(1, len(value) + 1))]
    return copy.deepcopy(value)


def entries(value, path: str = ""):
    """All (holder, key, path) of a JSON tree."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in list(items):
        yield value, key, f"{path}/{key}"
        yield from entries(item, f"{path}/{key}")


@cache
def bombs() -> dict[str, bytes]:
    """Small files that claim to be large, and files of other kinds; each must be refused, at once."""
    out = {}
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": (10**15,)})
    nested = b"\x93NUMPY\x01\x00" + (9000).to_bytes(2, "little") + b"(" * 9000
    for name, member in (
        ("petabyte", header.getvalue()), ("zeros", bytes(1 << 24)), ("nested", nested), ("text", b"hello"),
        ("pickle", b"\x93NUMPY\x01\x00\x46\x00" + b"{'descr': '|O', 'fortran_order': False, 'shape': (1,), }".ljust(69)
         + b"\n" + b"cos\nsystem\n(S'exit 1'\ntR."),
    ):  # fmt: skip
        file = io.BytesIO()
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("a0.npy", member)
        out[name] = file.getvalue()
    deep = '{"format": "photon-map-scene", "version": 1, "scene": ' + "[" * 50_000 + "]" * 50_000 + "}"
    out["deep"] = packed({TREE: np.frombuffer(deep.encode(), np.uint8)})
    out |= {"nothing": b"", "a letter": b"x", "png": b"\x89PNG\r\n\x1a\n" + bytes(99)}
    out["blend"] = b"BLENDER-v502" + bytes(99)
    out["npy"] = header.getvalue() + bytes(99)
    return out


def write(path: Path, content: bytes) -> Path:
    """The content in a file."""
    path.write_bytes(content)
    return path
