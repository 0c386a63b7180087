"""Damaged .blend files through the command line: `python -m tests.fuzz.blends COUNT [SEED]`.

Blender reads structures as they lie in the file, so one turned bit can crash its reader; the processes that try the
files may die. What the command line then says is the affair of `photon_engine/driver/guard.py`.
"""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from .mutate import broken_bytes, write
from .runs import try_each

WORDS = (0, 1, 2, 7, 255, 65535, 2**31 - 1, 2**31, 2**32 - 1, 0x7FC00000, 0x7F800000, 0x3F800000)
PATIENCE = 30  # [s] for one file
MAKE = """
import bpy, sys, os
bpy.ops.wm.read_factory_settings(use_empty=False)
material = bpy.data.materials["Material"]
tree = material.node_tree
node = tree.nodes.new("ShaderNodeTexNoise")
tree.links.new(node.outputs[0], next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"])
image = bpy.data.images.new("Paint", 4, 4); image.pack()
tree.nodes.new("ShaderNodeTexImage").image = image
bpy.data.objects["Cube"].modifiers.new("S", "SUBSURF")
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1], compress=sys.argv[2] == "1")
sys.stdout.flush(); os._exit(0)
"""


def save_base(folder: Path, compress: bool = False) -> Path:
    """A small .blend: cube, lamp, camera, a node tree, a packed image."""
    path = folder / ("small.blend" if compress else "base.blend")
    command = [sys.executable, "-c", MAKE, str(path), str(int(compress))]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return path


def mutant(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """What was done to a .blend, and the file.

    A third as any file is broken, which Blender notices by its chain of blocks; the others keep that chain, most often:
    some bits turned in the data before the description of types at the end, or numbers in the beginning.
    """
    kind, data = rng.choice(["any", "bits", "words", "beginning"], p=[0.3, 0.2, 0.4, 0.1]), bytearray(content)
    if kind == "any":
        return broken_bytes(content, rng)
    if kind == "beginning":
        for at in rng.integers(0, 64, rng.integers(1, 8)):
            data[at] = rng.integers(256)
    for at in rng.integers(64, int(0.7 * len(data)), rng.integers(1, 100)):
        if kind == "bits":
            data[at] ^= 1 << int(rng.integers(8))
        elif kind == "words":  # a number or a pointer
            data[at // 4 * 4 : at // 4 * 4 + 4] = int(rng.choice(WORDS)).to_bytes(4, "little")
    return str(kind), bytes(data)


def ask(path: Path) -> tuple[int, str]:
    """Exit code and messages of `info` on a file, within this process."""
    from photon_engine import cli

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = cli.main(["info", str(path)])
        except SystemExit as stop:
            code = int(stop.code or 0)
    return code, err.getvalue()


def verdict(path: Path) -> str:
    """Exit code and last line of what `info` says of a file, after WRONG where that is no proper answer."""
    code, said = ask(path)
    last = said.strip().splitlines()[-1] if said.strip() else ""
    wrong = "WRONG " if "Traceback" in said or code not in (0, 3) or (code and "error: " not in said) else ""
    return f"{wrong}{code} {last}"


def work(base: Path, numbers: range, seed: int, folder: Path) -> None:
    """Try the mutants with these numbers."""
    path = folder / "mutant.blend"
    try_each(base, numbers, seed, mutant, lambda data: verdict(write(path, data)), PATIENCE)


def hunt(base: Path, count: int, seed: int = 0) -> tuple[list[str], list[str]]:
    """Try mutants 0 ... count - 1: which killed the process, by what signal; and all answers."""
    killed, answers, first = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        while first < count:
            command = [sys.executable, "-m", "tests.fuzz.blends", "-w", str(base), str(first), str(count), str(seed),
                       folder]  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, errors="replace")
            lines = [line for line in done.stdout.splitlines() if line[:2] == "= " or line[:1].isdigit()]
            answers += [line[2:] for line in lines if line.startswith("= ")]
            tried = [line for line in lines if not line.startswith("= ")]
            if done.returncode == 0 or not tried:
                break
            killed.append(f"{tried[-1]}: exit {done.returncode}")
            first = int(tried[-1].split()[0]) + 1
    return killed, answers


def main() -> int:
    """As described above."""
    if sys.argv[1] == "-w":
        base, first, count, seed, folder = sys.argv[2:]
        work(Path(base), range(int(first), int(count)), int(seed), Path(folder))
        sys.stdout.flush()
        os._exit(0)  # Blender may hang when it is torn down
    with tempfile.TemporaryDirectory() as folder:
        killed, answers = hunt(save_base(Path(folder)), int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    wrong = [answer for answer in answers if answer.startswith("WRONG")]
    print("\n".join([*wrong, *killed]))
    read = sum(answer.startswith("0") for answer in answers)
    print(f"{len(answers)} answers, {read} files read, {len(wrong)} wrong; {len(killed)} killed Blender's reader")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
