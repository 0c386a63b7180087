"""The render engine that Blender sees: thin, every failure reported, a merged result always."""

from __future__ import annotations

import logging
import traceback

import bpy

from ..driver.session import Session
from ..issues import IssueLog, RenderError, StopReason
from ..scene.data import SceneData
from ..settings import Settings
from .keep import Keep, borrow
from .passes import register_passes, wanted_outputs
from .properties import settings_from
from .result import EngineListener, picture_size, remember, report, write_black

log = logging.getLogger("photon_map")

ENGINE_ID = "PHOTON_MAP"
VIEWPORT_TEXT = "Photon Map does not render the viewport yet: press F12, or use Material Preview"
# material icons and the preview sphere are small and refreshed at each change: few photons, hence wide gathers
PREVIEW = Settings(
    passes=8, seconds=2.0, caustic_photons=10_000, diffuse_photons=20_000, caustic_radius=4.0, diffuse_radius=24.0,
    light_samples=4,
)  # fmt: skip


class PhotonMapEngine(bpy.types.RenderEngine):
    """Photon Map as a render engine. Blender 4.5 to 5.2 calls __init__ twice on one object: none here."""

    bl_idname = ENGINE_ID
    bl_label = "Photon Map"
    bl_use_preview = True
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def update_render_passes(self, scene=None, renderlayer=None) -> None:
        """Register the passes of a view layer."""
        register_passes(self, scene, renderlayer)

    def render(self, depsgraph) -> None:
        """Render one view layer of one frame."""
        layer = depsgraph.view_layer_eval.name
        size = picture_size(depsgraph.scene)
        listener = EngineListener(self, layer, show=not bpy.app.background)
        try:
            self._render(depsgraph, listener)
        except RenderError as error:
            self._fail(str(error.issue))
        except Exception as error:
            log.error("%s", traceback.format_exc())
            notes = "".join(f", {note}" for note in getattr(error, "__notes__", ()))
            self._fail(f"unexpected {type(error).__name__}: {error}{notes} (a bug: please report it)")
        finally:
            if not listener.wrote:
                write_black(self, size, layer)

    def _render(self, depsgraph, listener: EngineListener) -> None:
        """Extract, render, report; the listener writes the pictures."""
        issues = IssueLog()
        session = None
        try:
            self.update_stats("", "Reading the scene")
            if depsgraph.scene.camera is None:
                raise RenderError(depsgraph.scene.name, "the scene has no camera", "add one")
            if depsgraph.scene.render.use_multiview:
                issues.warn(depsgraph.scene.name, "stereoscopy is not supported: all views show the scene's camera")
            keep = Keep() if self.is_preview else borrow()
            keep.begin(depsgraph, animation=self.is_animation)
            scene = _extract(depsgraph, issues, keep)
            outputs = frozenset({"Combined"}) if self.is_preview else wanted_outputs(depsgraph.view_layer)
            session = Session(scene, self._settings(depsgraph), issues, outputs=outputs, kept=keep.geometry)
            film = session.new_film()
            endless = not (bpy.app.background or self.is_animation or self.is_preview)
            try:
                stop = session.render(listener, film, endless=endless)
            except Exception:
                if film.count:
                    session.finish(listener)  # what was finished is kept
                raise
            if stop is StopReason.CANCELLED and film.count:
                issues.info("Photon Map", f"cancelled, {film.count} passes are kept")
            keep.geometry = session.kept
        finally:
            if not self.is_preview:
                remember(issues, session.plan if session else None)
                report(self, issues)

    def _settings(self, depsgraph) -> Settings:
        """The scene's settings, or small ones for a material preview."""
        if self.is_preview:
            return PREVIEW
        return settings_from(depsgraph.scene)

    def _fail(self, text: str) -> None:
        """Make Blender's operator fail with a message: Blender drops an exception, and writes a black image."""
        self.error_set(text)
        self.report({"ERROR"}, text)

    def view_update(self, context, depsgraph) -> None:
        """The scene changed under a Rendered viewport: nothing to do but say so."""
        self.update_stats("", VIEWPORT_TEXT)

    def view_draw(self, context, depsgraph) -> None:
        """Draw why the viewport is empty."""
        draw_message(context.region.width, context.region.height, VIEWPORT_TEXT)


def _extract(depsgraph, issues: IssueLog, keep: Keep) -> SceneData:
    """As extract.extract_scene, which is imported late: it needs numba, which takes a second to load."""
    from .extract import extract_scene

    return extract_scene(depsgraph, issues, keep=keep)


def draw_message(width: int, height: int, text: str) -> None:
    """A grey region with a line of text in its middle; width, height in pixels."""
    import blf
    import gpu

    gpu.state.active_framebuffer_get().clear(color=(0.05, 0.05, 0.05, 1.0))
    font = 0
    blf.size(font, 16.0)
    blf.color(font, 0.9, 0.9, 0.9, 1.0)
    text_width, text_height = blf.dimensions(font, text)
    blf.position(font, max((width - text_width) / 2.0, 8.0), (height - text_height) / 2.0, 0.0)
    blf.draw(font, text)


def register() -> None:
    """Add the engine."""
    bpy.utils.register_class(PhotonMapEngine)


def unregister() -> None:
    """Remove it."""
    bpy.utils.unregister_class(PhotonMapEngine)
