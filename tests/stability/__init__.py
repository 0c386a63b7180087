"""Extreme scenes, each with its law. `python -m tests.stability [FAMILY ...]` prints what was checked and found."""

from __future__ import annotations

import importlib

MODULES = (
    "space", "blends", "lamps", "views", "shapes", "pictures", "chains", "indices", "roughness", "grazing", "stiff",
    "deposits", "state",
)  # fmt: skip


def load_cases():
    """All cases, in the order of the table."""
    from . import lab

    for name in MODULES:
        importlib.import_module(f"{__name__}.{name}")
    return lab.CASES
