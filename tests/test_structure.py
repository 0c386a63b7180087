"""The rules of the house that lint cannot see: who imports what, how kernels are declared, how long a file may get."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "photon_engine"
FILES = sorted(PACKAGE.rglob("*.py"))
PRODUCT = [path for path in FILES if "tests" not in path.parts]
EVERYTHING = sorted(
    path
    for folder in ("photon_engine", "tests", "sample_blends", "benchmarks", "scripts")
    for path in (ROOT / folder).rglob("*.py")
)

BLENDER = {"bpy", "bpy_extras", "bl_ui", "mathutils", "gpu", "gpu_extras", "blf", "bmesh", "addon_utils"}
MAX_LINES = 400
MAX_PARAMETERS = 8


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_bytes())


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def imports(path: Path) -> set[str]:
    """Top-level names of all absolute imports, at any depth of the file."""
    found = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add(node.module.partition(".")[0])
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in (
            "import_module",
            "__import__",
        ):
            found |= {item.value.partition(".")[0] for item in node.args if isinstance(item, ast.Constant)}
    return found


def test_only_blender_folder_imports_blender():
    inside = PACKAGE / "blender"
    assert not [name(path) for path in FILES if inside not in path.parents and imports(path) & BLENDER]
    assert imports(PACKAGE / "blender" / "engine.py") & BLENDER  # the search sees what it looks for


def test_only_intersect_imports_embreex():
    assert [name(path) for path in FILES if "embreex" in imports(path)] == ["photon_engine/geometry/intersect.py"]


def test_package_imports_itself_relatively():
    """An installed extension has another name: bl_ext.user_default.photon_engine.photon_engine."""
    assert not [name(path) for path in PRODUCT if "photon_engine" in imports(path)]


def called_names(path: Path) -> set[str]:
    """Names used in the file, dotted ones by their last part, and keyword arguments as ``name=value``."""
    found = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute):
            found.add(node.attr)
        elif isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.keyword) and isinstance(node.value, ast.Constant):
            found.add(f"{node.arg}={node.value.value}")
    return found


def test_kernels_are_declared_through_jit():
    forbidden = {"njit", "prange", "vectorize", "guvectorize", "cfunc", "stencil"}
    assert not {name(path) for path in PRODUCT if called_names(path) & forbidden}
    assert not {name(path) for path in PRODUCT if path.name != "linkage.py" and "CPUDispatcher" in called_names(path)}
    assert "CPUDispatcher" in called_names(PACKAGE / "linkage.py")


def test_no_kernel_is_parallel_or_assumes_finite_numbers():
    forbidden = {"parallel=True", "fastmath=True", "prange"}
    assert not {name(path) for path in EVERYTHING if called_names(path) & forbidden}


def test_files_are_short():
    lengths = {name(path): len(path.read_text().splitlines()) for path in EVERYTHING}
    assert not {path: lines for path, lines in lengths.items() if lines > MAX_LINES}


def public_functions(path: Path):
    """Module-level functions, classes and methods whose names have no leading underscore."""
    for node in tree(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from (
                    item for item in node.body if isinstance(item, ast.FunctionDef) and not item.name.startswith("_")
                )


def test_everything_public_is_explained():
    missing = [
        f"{name(path)}:{node.lineno} {node.name}"
        for path in PRODUCT
        for node in public_functions(path)
        if not ast.get_docstring(node)
    ]
    assert not missing
    assert not [name(path) for path in PRODUCT if not ast.get_docstring(tree(path))]


def is_kernel(node: ast.FunctionDef) -> bool:
    return any(isinstance(item, ast.Name) and item.id in ("kernel", "inlined") for item in node.decorator_list)


def test_public_functions_take_few_parameters():
    """Kernels are exempt: numba has no records that hold both arrays and named outputs."""
    long = []
    for path in PRODUCT:
        for node in public_functions(path):
            if isinstance(node, ast.FunctionDef) and not is_kernel(node):
                names = [item.arg for item in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
                if len([item for item in names if item not in ("self", "cls")]) > MAX_PARAMETERS:
                    long.append(f"{name(path)}:{node.lineno} {node.name}")
    assert not long


IMPORTING = """
import sys
sys.path.insert(0, {root!r})
import photon_engine
print(*sorted({{item.partition(".")[0] for item in sys.modules}}))
"""


def test_importing_the_package_loads_nothing_heavy():
    """Blender imports every enabled extension when it starts; `make bench` times it."""
    code = IMPORTING.format(root=str(ROOT))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"bpy", "numba", "scipy", "numpy", "embreex", "OpenImageIO"} & set(done.stdout.split())


def test_version_is_said_once():
    import photon_engine

    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    assert manifest["version"] == photon_engine.__version__
    assert f"## {manifest['version']}" in (ROOT / "CHANGELOG.md").read_text()


@pytest.mark.parametrize("folder", sorted({path.parent for path in FILES}), ids=name)
def test_every_folder_is_a_package_and_says_what_it_is(folder):
    init = folder / "__init__.py"
    assert init.is_file(), "a folder without __init__.py is invisible to the layer contract"
    if folder.name != "tests":
        assert ast.get_docstring(tree(init))
