"""Build the sample scenes: ``python sample_blends/build.py [NAME ...]`` (all without a name)."""

from __future__ import annotations

import importlib
import logging
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from sample_blends.builders import SAMPLES, common  # noqa: E402

LIMIT = 1_000_000  # bytes; a sample must stay small enough to clone


def build(name: str) -> Path:
    """Build one sample beside this script and return its path."""
    importlib.import_module(f"sample_blends.builders.{name}").build()
    path = HERE / f"{name}.blend"
    common.save(str(path))
    if path.stat().st_size > LIMIT:
        raise RuntimeError(f"{path.name} has {path.stat().st_size} bytes, more than {LIMIT}")
    return path


def main(names: list[str]) -> int:
    """Build the samples named, or all."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    unknown = [name for name in names if name not in SAMPLES]
    if unknown:
        logging.error("unknown sample %s; there are: %s", ", ".join(unknown), ", ".join(SAMPLES))
        return 2
    for name in names or SAMPLES:
        path = build(name)
        logging.info("%s: %d kB", path.name, path.stat().st_size // 1000)
    return 0


if __name__ == "__main__":
    code = main(sys.argv[1:])
    sys.stdout.flush()
    os._exit(code)  # bpy 4.5 hangs in an ordinary exit
