"""Try many files; the process that does may die, the one that started it tells of what."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from .mutate import mutant, write
from .runs import try_each

PATIENCE = 60  # [s] for one file, with what it makes numba compile
FEW = {"caustic_photons": 500, "diffuse_photons": 500, "passes": 1, "max_bounces": 8, "threads": 1}


def attempt(path: Path) -> str:
    """Render a file as the command line does: "" for a picture, else the message."""
    from photon_engine.driver.session import Session
    from photon_engine.issues import IssueLog, RenderError
    from photon_engine.scene.io import load_scene
    from photon_engine.settings import Settings

    try:
        scene = load_scene(path)
        frame = scene.frame
        frame.x1, frame.y1 = min(frame.x1, frame.x0 + 8), min(frame.y1, frame.y0 + 8)
        Session(scene, Settings(**FEW), IssueLog()).render()
    except RenderError as error:
        return str(error)
    return ""


def work(base: Path, numbers: range, seed: int, folder: Path) -> None:
    """Try the mutants with these numbers; an exception that is no RenderError ends the process."""
    path = folder / "mutant.npz"
    try_each(base, numbers, seed, mutant, lambda data: attempt(write(path, data)) or "a picture", PATIENCE)


def hunt(base: Path, count: int, seed: int = 0) -> tuple[list[str], list[str]]:
    """Try mutants 0 ... count - 1: what broke it, each with the end of its traceback; and all answers."""
    broken, answers, first = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        while first < count:
            command = [sys.executable, "-X", "faulthandler", "-m", "tests.fuzz", "-w", str(base), str(first),
                       str(count), str(seed), folder]  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, errors="replace")
            lines = done.stdout.splitlines()
            answers += [line[2:] for line in lines if line.startswith("= ")]
            if done.returncode == 0:
                break
            tried = [line for line in lines if not line.startswith("= ")]
            last = tried[-1] if tried else f"{first} nothing was tried"
            broken.append(f"{last}: exit {done.returncode}, {' | '.join(done.stderr.strip().splitlines()[-6:])}")
            first = int(last.split()[0]) + 1
    return broken, answers


def main() -> int:
    """As `python -m tests.fuzz COUNT [SEED] [SCENE.npz]`."""
    if sys.argv[1] == "-w":
        base, first, count, seed, folder = sys.argv[2:]
        work(Path(base), range(int(first), int(count)), int(seed), Path(folder))
        return 0
    from .base import save_base

    with tempfile.TemporaryDirectory() as folder:
        base = Path(sys.argv[3]) if len(sys.argv) > 3 else save_base(Path(folder))
        broken, answers = hunt(base, int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    print("\n".join(broken))
    pictures = answers.count("a picture")
    print(f"{len(answers)} answers, {pictures} of them pictures; {len(broken)} broke it")
    return 1 if broken else 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.exit(code)
