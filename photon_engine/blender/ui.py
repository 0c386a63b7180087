"""Panels: our own, and Blender's that also make sense here."""

from __future__ import annotations

import bpy

from ..film.passes import PASSES
from ..issues import Severity
from ..settings import FIELDS
from .engine import ENGINE_ID
from .properties import pass_property
from .result import last_issues, last_plan

# Blender's panels for "any engine" that are replaced here or show what is not rendered
EXCLUDED = frozenset({
    "DATA_PT_falloff_curve", "DATA_PT_light", "DATA_PT_spot", "NODE_DATA_PT_light", "NODE_DATA_PT_spot",
    "OBJECT_PT_visibility", "RENDER_PT_simplify", "VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes",
    "DATA_PT_camera_stereoscopy", "DATA_PT_shadow", "DATA_PT_area",
})  # fmt: skip
EXCLUDED_WORDS = ("freestyle", "grease", "gpencil", "Freestyle", "GreasePencil", "stereoscopy")
# and those of EEVEE that show the same data-blocks
ADOPTED = (
    "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface", "MATERIAL_PT_preview", "EEVEE_WORLD_PT_surface",
    "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture", "CAMERA_PT_dof", "EEVEE_NEXT_MATERIAL_PT_surface",
)  # fmt: skip


class _Panel:
    """Shown when Photon Map is the engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = frozenset({ENGINE_ID})

    @classmethod
    def poll(cls, context) -> bool:
        """Whether Photon Map renders this scene."""
        return context.engine in cls.COMPAT_ENGINES


def _layout(panel):
    """The usual column of labelled properties."""
    panel.layout.use_property_split = True
    panel.layout.use_property_decorate = False
    return panel.layout.column()


def _settings_panel(group: str, closed: bool) -> type:
    """A render panel with all settings of one group."""

    def draw(self, context) -> None:
        column = _layout(self)
        for name, item in FIELDS.items():
            if item.metadata["group"] == group:
                column.prop(context.scene.photon_map, name)

    members = {
        "__doc__": f"The settings of the group {group}.", "bl_label": group, "bl_context": "render", "draw": draw,
        "bl_options": {"DEFAULT_CLOSED"} if closed else set(),
    }  # fmt: skip
    return type(f"PHOTON_MAP_PT_{group.lower().replace(' ', '_')}", (_Panel, bpy.types.Panel), members)


GROUPS = list(dict.fromkeys(item.metadata["group"] for item in FIELDS.values()))
SETTINGS_PANELS = [_settings_panel(group, closed=group not in ("Budget", "Photons")) for group in GROUPS]


class PHOTON_MAP_PT_film(_Panel, bpy.types.Panel):
    """Exposure, pixel filter, transparency."""

    bl_label = "Film"
    bl_context = "render"

    def draw(self, context) -> None:
        """Draw Blender's settings, and Cycles' where it has them: scenes render alike in both."""
        column = _layout(self)
        cycles = getattr(context.scene, "cycles", None)
        if cycles is not None:
            column.prop(cycles, "film_exposure")
            column.prop(cycles, "pixel_filter_type", text="Pixel Filter")
            if cycles.pixel_filter_type != "BOX":
                column.prop(cycles, "filter_width")
        column.prop(context.scene.render, "film_transparent", text="Transparent")
        if cycles is not None and context.scene.render.film_transparent:
            column.prop(cycles, "film_transparent_glass", text="Transparent Glass")


class PHOTON_MAP_PT_report(_Panel, bpy.types.Panel):
    """What the last render could not do."""

    bl_label = "Last Render"
    bl_context = "render"

    def draw(self, context) -> None:
        """List issues by object."""
        column = self.layout.column(align=True)
        issues = last_issues()
        if not issues:
            column.label(text="Nothing to report")
        icons = {Severity.INFO: "INFO", Severity.WARNING: "ERROR", Severity.ERROR: "CANCEL"}
        for issue in issues:
            column.label(text=f"{issue.object}: {issue.message}", icon=icons[issue.severity])
            if issue.remedy:
                column.label(text=issue.remedy, icon="BLANK1")


class PHOTON_MAP_PT_plan(_Panel, bpy.types.Panel):
    """What the last render did and what it left out: it also tells why a pass is black."""

    bl_label = "Plan of the Last Render"
    bl_context = "render"
    bl_options = frozenset({"DEFAULT_CLOSED"})

    def draw(self, context) -> None:
        """A line for each decision, the reason below."""
        column = self.layout.column(align=True)
        lines = last_plan()
        if not lines:
            column.label(text="Render once to see it")
        for line in lines:
            column.label(text=line.name, icon="CHECKMARK" if line.runs else "X")
            column.label(text=line.reason, icon="BLANK1")


class PHOTON_MAP_PT_passes(_Panel, bpy.types.Panel):
    """Which pictures a view layer makes."""

    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context) -> None:
        """A switch for each pass."""
        column = _layout(self)
        column.prop(context.view_layer, "use_pass_combined")
        for item in PASSES:
            if item.name != "Combined":
                column.prop(context.view_layer.photon_map, pass_property(item.name))


class PHOTON_MAP_PT_light(_Panel, bpy.types.Panel):
    """A lamp, as Cycles understands it."""

    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context) -> bool:
        """Only for lamps."""
        return super().poll(context) and context.light is not None

    def draw(self, context) -> None:
        """Power, colour and shape."""
        light = context.light
        self.layout.row().prop(light, "type", expand=True)
        column = _layout(self)
        if hasattr(light, "use_temperature"):  # Blender 4.5 and later
            column.prop(light, "use_temperature")
            if light.use_temperature:
                column.prop(light, "temperature")
        column.prop(light, "color")
        column.prop(light, "energy", text="Strength" if light.type == "SUN" else "Power")
        for name in ("exposure", "normalize"):
            if hasattr(light, name):
                column.prop(light, name)
        column.separator()
        for name in _shape_properties(light):
            column.prop(light, name)


def _shape_properties(light) -> list[str]:
    """The properties of a lamp's shape by its type."""
    if light.type == "SUN":
        return ["angle"]
    if light.type == "AREA":
        sides = ["size"] if light.shape in ("SQUARE", "DISK") else ["size", "size_y"]
        return ["shape", *sides, "spread"]
    round_lamp = ["shadow_soft_size", "use_soft_falloff"]
    return [*round_lamp, "spot_size", "spot_blend", "show_cone"] if light.type == "SPOT" else round_lamp


class PHOTON_MAP_PT_object_visibility(_Panel, bpy.types.Panel):
    """Which rays see an object."""

    bl_label = "Visibility"
    bl_context = "object"
    bl_options = frozenset({"DEFAULT_CLOSED"})

    def draw(self, context) -> None:
        """Blender's flags."""
        column = _layout(self)
        item = context.object
        for name in ("hide_select", "hide_viewport", "hide_render", "visible_camera", "visible_shadow", "is_holdout"):
            column.prop(item, name, invert_checkbox=name.startswith("hide_"))


CLASSES = (
    *SETTINGS_PANELS,
    PHOTON_MAP_PT_film,
    PHOTON_MAP_PT_report,
    PHOTON_MAP_PT_plan,
    PHOTON_MAP_PT_passes,
    PHOTON_MAP_PT_light,
    PHOTON_MAP_PT_object_visibility,
)


def adopted_panels() -> list[type]:
    """Blender's panels that are shown for this engine too."""
    found = []
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        name = panel.__name__
        if not isinstance(engines, set) or name in EXCLUDED or any(word in name for word in EXCLUDED_WORDS):
            continue
        if "BLENDER_RENDER" in engines or name in ADOPTED:
            found.append(panel)
    return found


def register() -> None:
    """Add our panels and adopt Blender's."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for panel in adopted_panels():
        panel.COMPAT_ENGINES.add(ENGINE_ID)


def unregister() -> None:
    """Leave Blender's panels as they were."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if isinstance(engines, set):
            engines.discard(ENGINE_ID)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
