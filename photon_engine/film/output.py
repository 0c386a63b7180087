"""Files that are written: whether they can be, and the error when not."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from ..issues import RenderError


class OutputError(RenderError):
    """A file cannot be written; the scene is not to blame."""


def check_writable(path: str | Path) -> None:
    """Raise an OutputError unless a file can be made at `path`: better before a long render than after it."""
    path = Path(path)
    folder = path.parent
    try:
        if path.is_dir():
            raise OutputError(str(path), "is a folder", "give the name of a file")
        if not folder.is_dir():
            raise OutputError(str(path), f"the folder {folder} does not exist", "make it, or choose another place")
        if path.exists():
            with path.open("ab"):
                pass
        handle, name = tempfile.mkstemp(dir=folder, prefix=".photon_map_")
        os.close(handle)
        os.unlink(name)
    except (OSError, ValueError) as error:  # ValueError: a name that no system knows
        text = getattr(error, "strerror", None) or str(error)
        raise OutputError(str(path), f"cannot be written: {text}", "choose another place") from error
