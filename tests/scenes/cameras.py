"""Cameras and frames, on the diffuse corner under one soft lamp."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from sample_blends.builders import common

from . import stage


def view(name: str, **values) -> None:
    """The corner with properties of the camera (``dof.x`` for its depth of field) and the scene (``scene.x``)."""
    scene = stage.corner(name)
    common.set_world(scene, (0.5, 0.6, 0.9), 0.4)
    common.add_light(scene, "AREA", "Lamp", (0.5, -0.7, 1.9), (-0.3, 0.4, 0.2), 50.0, shape="DISK", size=0.6)
    camera = scene.camera.data
    for path, value in values.items():
        owner, _, key = path.rpartition("__")
        target = {"": camera, "dof": camera.dof, "render": scene.render, "cycles": scene.cycles}[owner]
        setattr(target, key, value)


DOF = {"dof__use_dof": True, "dof__focus_distance": 2.6, "dof__aperture_fstop": 0.12}
OPTIONS: dict[str, dict] = {
    "orthographic": {"type": "ORTHO", "ortho_scale": 3.6},
    "shift": {"shift_x": 0.15, "shift_y": -0.1},
    "wide_frame": {"render__resolution_x": 96, "render__resolution_y": 48},
    "tall_sensor": {"sensor_fit": "VERTICAL", "sensor_height": 30.0, "lens": 35.0, "render__resolution_y": 80},
    "pixel_aspect": {"render__pixel_aspect_x": 1.0, "render__pixel_aspect_y": 1.5},
    "percentage": {"render__resolution_percentage": 75},
    "clipping": {"clip_start": 3.4, "clip_end": 5.2},
    "depth_of_field": DOF,
    "depth_of_field_blades": {
        **DOF, "dof__aperture_blades": 5, "dof__aperture_rotation": math.radians(20.0), "dof__aperture_ratio": 1.6,
    },
    "exposure": {"cycles__film_exposure": 2.5},
    "filter_box": {"cycles__pixel_filter_type": "BOX"},
    "filter_gaussian_wide": {"cycles__pixel_filter_type": "GAUSSIAN", "cycles__filter_width": 4.0},
}
SCENES: dict[str, Callable[[], None]] = {name: partial(view, name, **values) for name, values in OPTIONS.items()}
