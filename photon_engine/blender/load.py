"""A .blend opened in Blender as a module, and what is rendered of it as SceneData.

Only a RenderEngine is given the dependency graph of a *render* (render visibility, render levels of modifiers); the one
that a script can ask for is the viewport's. So a small engine is registered for the moment of reading.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import bpy

from ..issues import IssueLog, RenderError
from ..scene.data import SceneData
from .extract import extract_scene
from .keep import Keep
from .properties import register as register_properties
from .properties import settings_from
from .unsupported import report_afterwards


class Options(NamedTuple):
    """What is taken of a file; None: as the file says."""

    frame: int | None = None
    camera: str | None = None
    view_layer: str | None = None
    resolution: tuple[int, int] | None = None


class SceneReader(bpy.types.RenderEngine):
    """An engine that renders nothing but hands the render's depsgraph to a function."""

    bl_idname = "PHOTON_MAP_READER"
    bl_label = "Photon Map (reading)"
    read: Callable[[Any], Any] | None = None
    result: Any = None
    error: BaseException | None = None

    def render(self, depsgraph) -> None:
        """Call `read`; an exception is kept for the caller, since Blender would drop it."""
        cls = type(self)
        try:
            cls.result = cls.read(depsgraph)
        except BaseException as error:
            cls.error = error


class OpenBlend:
    """A .blend that is open, to extract one frame after the other: what does not change is read once.

    Raises a RenderError when the file cannot be read, or what was asked for is not in it. To be used with `with`.
    """

    def __init__(self, path: str | Path, options: Options, issues: IssueLog) -> None:
        """Open it. issues : is told what the file lacks."""
        register_properties()
        self.options = options
        self.keep = Keep()
        with _stdout_to_stderr():
            try:
                bpy.ops.wm.open_mainfile(filepath=str(Path(path).resolve()), load_ui=False, use_scripts=False)
            except RuntimeError as error:
                reason = str(error).strip().removeprefix("Error: ").rstrip(".")
                raise RenderError(str(path), f"Blender cannot open it: {reason}", "check that it is a .blend") from None
        if not bpy.data.filepath or not Path(bpy.data.filepath).samefile(path):  # or what was open before is rendered
            raise RenderError(str(path), "Blender did not open it", "check that it is a .blend")
        self.scene = bpy.context.scene
        self.default_layer = bpy.context.view_layer
        report_missing(issues)
        report_afterwards(self.scene, issues)
        self.scene.render.use_persistent_data = True  # Blender keeps what it evaluated from frame to frame

    def __enter__(self) -> OpenBlend:
        bpy.utils.register_class(SceneReader)
        self._engine = self.scene.render.engine
        return self

    def __exit__(self, *_error: object) -> None:
        self.scene.render.engine = self._engine
        bpy.utils.unregister_class(SceneReader)

    def read(self, issues: IssueLog, frame: int | None = None) -> tuple[SceneData, dict, str]:
        """A frame (None: that of the options) as scene, settings stored in the file by name, name of the view layer."""
        options = self.options if frame is None else self.options._replace(frame=frame)
        with _stdout_to_stderr():
            layer = choose(self.scene, options, self.default_layer)
            settings = settings_from(self.scene).to_dict()
            data = read_render(self.scene, layer, lambda depsgraph: self._extract(depsgraph, issues))
        return data, settings, layer.name

    def _extract(self, depsgraph: Any, issues: IssueLog) -> SceneData:
        """The scene, with what the frame before left."""
        self.keep.begin(depsgraph, animation=True)
        return extract_scene(depsgraph, issues, keep=self.keep)


def load_blend(path: str | Path, options: Options, issues: IssueLog) -> tuple[SceneData, dict, str]:
    """Open a file and extract one picture of it: scene, settings stored in the file (by name), view layer's name.

    Raises a RenderError when the file cannot be read, or what was asked for is not in it.
    """
    with OpenBlend(path, options, issues) as opened:
        return opened.read(issues)


def choose(scene: bpy.types.Scene, options: Options, default_layer: bpy.types.ViewLayer) -> bpy.types.ViewLayer:
    """Set frame, camera and resolution of a scene, and return the view layer."""
    if options.camera is not None:
        camera = bpy.data.objects.get(options.camera)
        if camera is None or camera.type != "CAMERA":
            names = ", ".join(item.name for item in bpy.data.objects if item.type == "CAMERA") or "none"
            raise RenderError(options.camera, "there is no camera of that name", f"the file has: {names}")
        scene.camera = camera
    if options.resolution is not None:
        scene.render.resolution_x, scene.render.resolution_y = options.resolution
        scene.render.resolution_percentage = 100
        if (scene.render.resolution_x, scene.render.resolution_y) != options.resolution:
            least = f"{scene.render.resolution_x}x{scene.render.resolution_y}"
            raise RenderError("resolution", f"Blender refuses {options.resolution}", f"the nearest is {least}")
    if options.frame is not None:
        scene.frame_set(options.frame)
        if options.camera is not None:
            scene.camera = camera  # markers bound to cameras may have changed it
    if scene.camera is None:
        raise RenderError(scene.name, "the scene has no camera", "add one, or name one with --camera")
    if options.view_layer is None:
        return default_layer if scene.view_layers.get(default_layer.name) else scene.view_layers[0]
    layer = scene.view_layers.get(options.view_layer)
    if layer is None:
        names = ", ".join(item.name for item in scene.view_layers)
        raise RenderError(options.view_layer, "there is no view layer of that name", f"the file has: {names}")
    return layer


def report_missing(issues: IssueLog) -> None:
    """Warn of linked libraries and image files that are not there."""
    for library in bpy.data.libraries:
        path = bpy.path.abspath(library.filepath)
        if not os.path.exists(path):
            issues.warn(library.name, f"the linked file {path} is missing: its objects are left out", "relocate it")
    for image in bpy.data.images:
        if image.source != "FILE" or image.packed_file or not image.filepath or not image.users:
            continue
        path = bpy.path.abspath(image.filepath, library=image.library)
        if not os.path.exists(path):
            issues.warn(image.name, f"the image file {path} is missing", "relocate it, or pack it into the .blend")


def read_render(scene: bpy.types.Scene, layer: bpy.types.ViewLayer, read: Callable[[Any], Any]) -> Any:
    """What `read` makes of the depsgraph that a render of this scene and view layer uses."""
    render = scene.render
    render.use_compositing = render.use_sequencer = render.use_multiview = False
    alone = "bl_rna" not in vars(SceneReader)  # not registered; an OpenBlend's stays, and with it what Blender keeps
    if alone:
        bpy.utils.register_class(SceneReader)
    before = render.engine
    SceneReader.read, SceneReader.result, SceneReader.error = staticmethod(read), None, None
    try:
        if render.engine != SceneReader.bl_idname:  # Blender drops what it keeps even when the same is set
            render.engine = SceneReader.bl_idname
        bpy.ops.render.render(scene=scene.name, layer=layer.name, write_still=False)
        if SceneReader.error is not None:
            raise SceneReader.error
        if SceneReader.result is None:
            raise RenderError(scene.name, "Blender did not start the render", "open the file in Blender and render it")
        return SceneReader.result
    except RuntimeError as error:
        raise RenderError(scene.name, f"Blender cannot render it: {str(error).strip()}", "see the message") from error
    finally:
        SceneReader.read = SceneReader.result = SceneReader.error = None
        if alone:
            render.engine = before
            bpy.utils.unregister_class(SceneReader)


@contextmanager
def _stdout_to_stderr():
    """Blender's own lines go to stderr, so that stdout holds only what was asked for."""
    sys.stdout.flush()
    saved = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(saved, 1)
        os.close(saved)
