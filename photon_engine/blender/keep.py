"""What one render leaves for the next: meshes as extracted, images, triangles and what geometry/kept.py makes of them.

Persistent Data keeps Blender's own evaluated meshes between frames and renders; a mesh evaluated anew has a new
session_uid. Without it every frame's meshes are new, and the rest is kept by comparison until the animation ends.
Blender names the images whose settings changed. Pixels change without a word: of a reload it names the materials, of a
painted image that is saved or packed nothing, so the file's time and the packed bytes are looked at.
"""

from __future__ import annotations

import os
import zlib
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent

from ..issues import IssueLog
from ..scene.data import Image, Mesh

if TYPE_CHECKING:
    from .meshes import MeshNeeds

STILL_SOURCES = ("FILE", "GENERATED")  # images that no frame changes
READERS = ("MATERIAL", "WORLD", "LIGHT", "NODETREE")  # what Blender names when images that these use are reloaded


class Keep:
    """Parts of the last extraction; used by one render at a time."""

    def __init__(self) -> None:
        self.geometry: Any = None  # geometry.kept.Kept, made by the first render
        self.extracted = 0  # how many meshes were read from Blender, for tests
        self._meshes: dict[tuple[int, MeshNeeds], tuple[Mesh | None, IssueLog]] = {}
        self._images: dict[tuple, tuple[Image, IssueLog]] = {}
        self._stale: set[int] = set()
        self._new_meshes: dict[tuple[int, MeshNeeds], tuple[Mesh | None, IssueLog]] = {}

    def begin(self, depsgraph: Any, animation: bool) -> None:
        """A render of this depsgraph begins. animation : nobody can have edited an image since the last."""
        self._new_meshes = {}
        changed = [update for update in depsgraph.updates if update.is_updated_geometry]
        self._stale = {uid(item.id) for item in changed} | {
            uid(item.id.data) for item in changed if isinstance(item.id, bpy.types.Object) and item.id.data is not None
        }
        named = ("IMAGE",) if animation else ("IMAGE", *READERS)
        if any(depsgraph.id_type_updated(kind) for kind in named):
            self._images = {}

    def mesh(self, block: Any, owner: str, needs: MeshNeeds, issues: IssueLog) -> Mesh | None:
        """As `extract_mesh`; the one of the last render when Blender did not evaluate it anew."""
        from .meshes import extract_mesh  # here: who only enables the extension needs no numba

        key = (uid(block), needs)
        found = self._meshes.get(key) if key[0] not in self._stale else None
        if found is None or not key[0]:
            own = IssueLog()
            found = extract_mesh(block, owner, needs, own), own
            self.extracted += 1
        self._new_meshes[key] = found
        issues.extend(found[1])
        return found[0]

    def end(self) -> None:
        """All meshes are read: what this render did not use is dropped."""
        self._meshes, self._new_meshes = self._new_meshes, {}

    def image(self, image: Any, read: Any, issues: IssueLog) -> Image:
        """read(image, issues); the pixels of the render before when nothing can have changed them."""
        if image.source not in STILL_SOURCES or image.is_dirty:
            return read(image, issues)
        settings = image.colorspace_settings.name, image.alpha_mode, *image.size
        key = (uid(image), image.name, image.filepath, *settings, *_version(image))
        if key not in self._images:
            own = IssueLog()
            self._images[key] = read(image, own), own
        issues.extend(self._images[key][1])
        return self._images[key][0]


def _version(image: Any) -> tuple:
    """What changes with the pixels of a still image that is not being painted."""
    if image.source == "GENERATED":
        return image.generated_type, *image.generated_color
    if image.packed_file is not None:
        return image.packed_file.size, zlib.crc32(image.packed_file.data)
    try:
        found = os.stat(bpy.path.abspath(image.filepath, library=image.library))
    except OSError:
        return ()
    return found.st_size, found.st_mtime_ns


def uid(block: Any) -> int:
    """Blender's number of a data-block in this session; 0: it has none."""
    return getattr(block, "session_uid", 0)


_keep: Keep | None = None


def borrow() -> Keep:
    """What the last final render left."""
    global _keep
    if _keep is None:
        _keep = Keep()
    return _keep


@persistent
def _drop(*_arguments: Any) -> None:
    """Let it go at the end of a render job, or of a file."""
    global _keep
    scene = getattr(bpy.context, "scene", None)
    if scene is None or not scene.render.use_persistent_data:
        _keep = None


@persistent
def _drop_all(*_arguments: Any) -> None:
    """Another file is opened."""
    global _keep
    _keep = None


def register() -> None:
    """Forget what is kept when a job ends without Persistent Data, and when another file is opened."""
    bpy.app.handlers.render_complete.append(_drop)
    bpy.app.handlers.render_cancel.append(_drop)
    bpy.app.handlers.load_pre.append(_drop_all)


def unregister() -> None:
    """Take the handlers away."""
    handlers = bpy.app.handlers
    for table, function in (
        (handlers.render_complete, _drop),
        (handlers.render_cancel, _drop),
        (handlers.load_pre, _drop_all),
    ):
        if function in table:
            table.remove(function)
    _drop_all()
