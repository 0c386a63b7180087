"""Every setting of the renderer, once: default, range, unit, text.

Blender's properties, the command line's ``--set NAME=VALUE`` and the metadata in pictures are generated from here.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

from .issues import RenderError


def setting(default: Any, label: str, text: str, **meta: Any) -> Any:
    """A dataclass field that carries what a user interface needs (min, max, unit, items, group)."""
    return field(default=default, metadata={"label": label, "text": text, **meta})


@dataclass(frozen=True)
class Settings:
    """How to render; SceneData says what."""

    passes: int = setting(
        32, "Passes", "Stop after this many passes; 0 means no limit", min=0, max=1_000_000, group="Budget"
    )
    seconds: float = setting(
        0.0, "Seconds", "Stop after this much time; 0 means no limit", min=0.0, max=1e6, unit="TIME", group="Budget"
    )
    error: float = setting(
        0.0,
        "Error",
        "Stop when noise and bias are below this part of the picture's brightness, 0.01 is 1%; 0 means no limit",
        min=0.0,
        max=1.0,
        group="Budget",
    )
    error_share: float = setting(
        0.95, "Of Pixels", "Part of the pixels that the error is asked of", min=0.01, max=1.0, group="Budget"
    )
    error_pass: str = setting(
        "COMBINED",
        "In Pass",
        "The picture that the error is asked of",
        items=(
            ("COMBINED", "Combined", "The whole picture"),
            ("DIRECT", "Direct", "Light that comes straight from a source"),
            ("CAUSTIC", "Caustic", "Light focused by glass and metal"),
            ("DIFFUSE", "Diffuse", "Light that went between rough surfaces first"),
            ("EMISSION", "Emission", "Sources seen by the camera"),
            ("ENVIRONMENT", "Environment", "The world"),
        ),
        group="Budget",
    )
    caustic_photons: int = setting(
        100_000,
        "Caustic Photons",
        "Photons aimed at glass and metal in each pass",
        min=0,
        max=100_000_000,
        group="Photons",
    )
    diffuse_photons: int = setting(
        200_000,
        "Diffuse Photons",
        "Photons for light between rough surfaces in each pass",
        min=0,
        max=100_000_000,
        group="Photons",
    )
    caustic_radius: float = setting(
        0.0,
        "Caustic Radius",
        "First gather radius of the caustic map, in pixels; 0: 2 pixels, 0.5 where the picture is denoised",
        min=0.0,
        max=1000.0,
        unit="PIXEL",
        group="Photons",
    )
    diffuse_radius: float = setting(
        8.0,
        "Diffuse Radius",
        "First gather radius of the diffuse map at visible points, in pixels",
        min=0.05,
        max=1000.0,
        unit="PIXEL",
        group="Photons",
    )
    alpha: float = setting(
        2.0 / 3.0,
        "Radius Alpha",
        "How slowly the radius shrinks from pass to pass (1: never)",
        min=0.01,
        max=1.0,
        group="Photons",
    )
    max_bounces: int = setting(
        64, "Bounces", "Longest path, after which light is dropped", min=1, max=1024, group="Light Paths"
    )
    diffuse_bounces: int = setting(
        64,
        "Diffuse Bounces",
        "Most rough bounces between a light and the eye beyond the first (0: no diffuse light)",
        min=0,
        max=1024,
        group="Light Paths",
    )
    final_gather: str = setting(
        "AUTO",
        "Final Gather",
        "Where diffuse light is looked up one bounce away instead of at the visible point",
        items=(
            ("AUTO", "Automatic", "All where the picture is denoised and photons lie sparser than pixels, else Glossy"),
            ("OFF", "Off", "Read the diffuse map at every visible point"),
            ("GLOSSY", "Glossy", "Gather for glossy surfaces, whose lobes are too narrow for the map"),
            ("ALL", "All", "Gather for every visible point: sharper contact shadows, more noise"),
        ),
        group="Light Paths",
    )
    light_samples: int = setting(
        4,
        "Light Samples",
        "Shadow rays from each visible point in each pass, and up to 2 rays that look where a glossy lobe reflects "
        "(four times as many through rough glass)",
        min=1,
        max=64,
        group="Light Paths",
    )
    eye_samples: int = setting(
        0,
        "Camera Paths",
        "Paths from the camera through each pixel in each pass, spread evenly over it; 0: one, or up to 4 where a pass "
        "has many photons to a pixel",
        min=0,
        max=64,
        group="Light Paths",
    )
    splits: int = setting(
        3,
        "Splits",
        "At how many surfaces a path from the camera follows reflection and refraction both, instead of one at random",
        min=0,
        max=8,
        group="Light Paths",
    )
    specular_threshold: float = setting(
        0.05,
        "Specular Threshold",
        "Lobes with a roughness (as in the material) below this count as mirrors: they carry caustics",
        min=0.0,
        max=0.5,
        group="Light Paths",
    )
    denoise: str = setting(
        "OFF",
        "Denoise",
        "Remove noise with Open Image Denoise, from Combined and from each light pass by itself. The automatic caustic "
        "radius follows: a denoiser wants noise that differs from pixel to pixel, hence a small one",
        items=(
            ("OFF", "Off", "Leave the noise"),
            ("FINAL", "Final", "Denoise the finished picture"),
            ("ALWAYS", "Always", "Denoise the finished picture and those shown before it is"),
        ),
        group="Denoising",
    )
    seed: int = setting(0, "Seed", "Another seed, another noise", min=0, max=2**31 - 1, group="Sampling")
    threads: int = setting(
        0, "Threads", "Worker threads; 0 means one for each core", min=0, max=1024, group="Performance"
    )

    plan: bool = setting(
        True,
        "Leave Out the Needless",
        "Do only what this scene and the pictures asked for need; off: run everything, for the same picture",
        group="Performance",
    )

    @classmethod
    def from_strings(cls, pairs: dict[str, str]) -> Settings:
        """Settings from ``name -> text``; a RenderError names an unknown setting or a bad value."""
        values = {}
        for name, text in pairs.items():
            values[name] = parse_value(name, text)
        return cls(**values)

    def replace(self, **changes: Any) -> Settings:
        """A copy with some settings changed."""
        return dataclasses.replace(self, **changes)

    def resolved(self) -> Settings:
        """With what is left to the engine (a value of 0 or AUTO) decided; a decided copy stays as it is.

        A denoiser removes noise that differs from pixel to pixel and keeps blotches, so caustics are gathered below a
        pixel for it: 20% less error at equal time on cornell_caustics of 256 pixels, 0 to 5% more on pool of 128,
        where the density of the photons bounds the radius. A smaller diffuse radius only makes blotches as large as the
        denoiser looks for; rays of a final gather make none. Where the picture is denoised, whether they pay is left
        to the pilot pass, which knows how dense photons lie: see transport/pilot.gather_mode.
        """
        radius = self.caustic_radius or (2.0 if self.denoise == "OFF" else 0.5)
        gather = "GLOSSY" if self.final_gather == "AUTO" and self.denoise == "OFF" else self.final_gather
        return self.replace(caustic_radius=radius, final_gather=gather)

    def to_dict(self) -> dict[str, Any]:
        """Plain values by name, for logs and metadata."""
        return dataclasses.asdict(self)

    def __post_init__(self) -> None:
        """Refuse a value outside its range, by name."""
        for item in dataclasses.fields(self):
            check_value(item, getattr(self, item.name))


FIELDS = {item.name: item for item in dataclasses.fields(Settings)}


def parse_value(name: str, text: str) -> Any:
    """A setting's value from text."""
    if name not in FIELDS:
        raise RenderError(f"--set {name}", "there is no setting of that name", f"one of: {', '.join(FIELDS)}")
    kind = type(FIELDS[name].default)
    if kind is bool:
        return parse_switch(name, text)
    try:
        return text.upper() if kind is str else kind(text)
    except ValueError:
        raise RenderError(f"--set {name}", f"'{text}' is not a {kind.__name__}", "give a number") from None


def parse_switch(name: str, text: str) -> bool:
    """A switch from text: on, off, true, false, yes, no, 1, 0."""
    states = dict.fromkeys(("on", "true", "yes", "1"), True) | dict.fromkeys(("off", "false", "no", "0"), False)
    if text.lower() not in states:
        raise RenderError(f"--set {name}", f"'{text}' is neither on nor off", "write on or off")
    return states[text.lower()]


def check_value(item: dataclasses.Field, value: Any) -> None:
    """Raise a RenderError when the value is outside the setting's range or choice."""
    meta = item.metadata
    if "items" in meta:
        names = [entry[0] for entry in meta["items"]]
        if value not in names:
            raise RenderError(item.name, f"'{value}' is not a choice", f"one of: {', '.join(names)}")
    elif isinstance(item.default, bool):
        if not isinstance(value, bool | int) or value not in (0, 1):
            raise RenderError(item.name, f"{value!r} is neither on nor off", "choose True or False")
    elif not meta["min"] <= value <= meta["max"]:
        raise RenderError(item.name, f"{value} is outside [{meta['min']}, {meta['max']}]", "choose a value inside")
