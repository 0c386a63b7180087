"""What a scene and the pictures asked for need, decided before anything is rendered, each decision with its reason.

`make_plan` is a pure function: scene, settings and the names of the pictures in, a frozen Plan out. Transport does what
the plan says and nothing else; people read it as lines ("Caustic map: left out, no specular surface"). A decision may
only leave out what adds exactly nothing: `plan=off` runs everything and gives the same pictures.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from .film.passes import ALL_NAMES, ERROR_MAPS, GUIDES, LIGHT_NAMES, NOISY
from .scene.data import SceneData
from .settings import Settings
from .survey import Survey, shines, survey

PHOTONS_A_PATH = 3.0  # of the camera
FEWEST_PIXELS = 10_000  # that are worth more than one
HARD = 0.035  # [rad] angle of a sun that casts hard shadows: 2 degrees
OFF = "everything runs (plan=off)"


@dataclass(frozen=True)
class Decision:
    """Whether something runs, and why or why not, in words."""

    runs: bool
    reason: str
    count: int = 1  # of what runs, where there is a choice

    def __bool__(self) -> bool:
        """Whether it runs."""
        return self.runs


class Line(NamedTuple):
    """One decision for people."""

    name: str
    runs: bool
    reason: str

    def __str__(self) -> str:
        """`Caustic map: left out, no specular surface`."""
        return f"{self.name}: {'runs' if self.runs else 'left out'}, {self.reason}"


LABELS = {
    "idle_lamps": "Lamps out of reach",
    "direct": "Direct light",
    "sun_rays": "More than one ray to a sun",
    "lobe_rays": "Rays from lobes",
    "see_through": "See-through shadows",
    "caustic_map": "Caustic map",
    "caustic_points": "Caustics where the eye looks",
    "diffuse_map": "Diffuse map",
    "stray_photons": "Photons past all objects",
    "more_paths": "More than one path a pixel",
    "mirrors": "Beyond mirrors and glass",
    "gather_all": "Final gather everywhere",
    "gather_narrow": "Final gather on glossy surfaces",
    "edges": "Walls and rims near by",
    "emission": "Emission",
    "environment": "Environment",
    "subsurface": "Below the surface",
    "media": "Absorbing insides",
    "lens": "Depth of field",
    "textures": "Textures",
    "unworn": "Materials on no surface",
    "guides": "Guides of the denoiser",
    "variance": "Variance of every pixel",
}


@dataclass(frozen=True)
class Plan:
    """What a render does and leaves out. Every field but `outputs` is a Decision."""

    outputs: frozenset[str]  # pictures asked for, names of film.passes; Combined stands for all light passes
    idle_lamps: Decision
    direct: Decision
    sun_rays: Decision
    lobe_rays: Decision
    see_through: Decision
    caustic_map: Decision
    caustic_points: Decision
    diffuse_map: Decision
    stray_photons: Decision
    more_paths: Decision
    mirrors: Decision
    gather_all: Decision
    gather_narrow: Decision
    edges: Decision
    emission: Decision
    environment: Decision
    subsurface: Decision
    media: Decision
    lens: Decision
    textures: Decision
    unworn: Decision
    guides: Decision
    variance: Decision

    @property
    def gathers(self) -> bool:
        """Whether some light is looked up one bounce away: its map then holds first hits too."""
        return bool(self.gather_all or self.gather_narrow)

    @property
    def sees_lights(self) -> bool:
        """Whether eye paths look for lamps and sky."""
        return bool(self.emission or self.environment)

    def lines(self) -> list[Line]:
        """All decisions, for the log and for panels."""
        choices = [(label, getattr(self, name)) for name, label in LABELS.items()]
        return [Line(label, choice.runs, choice.reason) for label, choice in choices]

    def __str__(self) -> str:
        """One line: what is left out."""
        left = [f"{line.name} ({line.reason})" for line in self.lines() if not line.runs]
        return f"Left out: {', '.join(left) or 'nothing'}"


class Rule:
    """Makes decisions: what is impossible is always left out, what is needless only with the plan on."""

    def __init__(self, plan: bool, outputs: frozenset[str]) -> None:
        self.plan = plan
        self.outputs = outputs | (frozenset(LIGHT_NAMES) if "Combined" in outputs else frozenset())

    def decide(self, why: str, impossible: Sequence[tuple], needless: Sequence[tuple] = ()) -> Decision:
        """The first reason that holds leaves it out. impossible, needless : (condition, reason)."""
        for holds, reason in (*impossible, *(needless if self.plan else ())):
            if holds:
                return Decision(False, reason)
        return Decision(True, why if self.plan else OFF)

    def unasked(self, name: str) -> tuple[bool, str]:
        """Whether a picture is not asked for, nor Combined."""
        return name not in self.outputs, f"{name} is not asked for"


def make_plan(
    scene: SceneData, settings: Settings, outputs: Iterable[str] = ALL_NAMES, known: Survey | None = None
) -> Plan:
    """What to do to make `outputs` (names of film.passes) of a scene.

    known : what was found out about the scene, if that was done already; it costs a compilation of the materials.
    """
    facts = survey(scene, settings.specular_threshold, reach=settings.plan) if known is None else known
    variance = every_variance(settings, outputs := frozenset(outputs))
    outputs = frozenset("Combined" if name in ERROR_MAPS else name.removeprefix(NOISY) for name in outputs)
    rule = Rule(settings.plan, outputs)
    diffuse = _diffuse(rule, facts, settings)
    gathers = _gathers(rule, facts, settings, diffuse)
    gathering = bool(gathers["gather_all"] or gathers["gather_narrow"])
    mirrored = facts.narrow if gathering else ()  # where a gather ends on them it is lit as the eye sees it
    maps = {"diffuse_map": diffuse, **_caustic(rule, facts, settings, mirrored)}
    direct, guides = _direct(rule, facts), _guides(rule, settings)
    shadows = [
        (not direct and not mirrored, "no direct light"), (not facts.see_through, "every surface stops light"),
    ]  # fmt: skip
    met = [
        (not direct and not gathering, "neither direct light nor a final gather"),
        (not facts.can_be_hit and not gathering, "no ray can meet a light: all are points or parallel beams"),
    ]
    why = "they gather diffuse light" if gathering else f"they may meet {names(facts.can_be_hit)}"
    return Plan(
        outputs,
        stray_photons=rule.decide("", [(not (maps["caustic_map"] or maps["diffuse_map"]), "no photons")], PAST),
        idle_lamps=_idle_lamps(scene, settings, facts),
        direct=direct,
        sun_rays=_sun_rays(scene, settings, facts),
        lobe_rays=rule.decide(why, [(not facts.lit, NO_LIGHT)], met),
        see_through=rule.decide(f"light passes {names(facts.see_through)}", [(not facts.lit, NO_LIGHT)], shadows),
        **maps,
        **gathers,
        edges=_edges(rule, maps),
        **_seen(rule, facts),
        more_paths=camera_paths(scene, settings),
        mirrors=_mirrors(rule, facts, guides),
        subsurface=_subsurface(rule, facts),
        media=_media(facts),
        lens=_lens(scene),
        textures=_textures(facts),
        unworn=_unworn(settings, facts),
        guides=guides,
        variance=variance,
    )


PAST = [(True, "where many are, caustic photons that miss every specular object's box, others that miss all objects'")]
NO_LIGHT = "nothing shines"
NO_ROUGH = "no rough surface to receive light"


def _idle_lamps(scene: SceneData, settings: Settings, facts: Survey) -> Decision:
    """Lamps that neither a receiver of light nor the camera can see shining."""
    if not settings.plan:
        return Decision(True, OFF)
    idle = [scene.lights[i].name for i in facts.idle]
    return Decision(False, f"{names(idle)} reach nothing that scatters light" if idle else "there is none")


def _sun_rays(scene: SceneData, settings: Settings, facts: Survey) -> Decision:
    """Shadow rays to a narrow sun, which by its power would take most of them from the sky."""
    if not settings.plan:
        return Decision(True, OFF)
    suns = [light for i, light in enumerate(scene.lights) if i not in facts.idle and shines(light)]
    narrow = [light.name for light in suns if light.kind == "SUN" and light.angle <= HARD]
    alone = len(facts.lit) == len(suns) + len(facts.sky) and all(light.kind == "SUN" for light in suns)
    if narrow and alone and facts.sky and settings.light_samples > 1:
        return Decision(False, f"one tells whether {names(narrow)} is seen, the others go to {names(facts.sky)}")
    return Decision(True, "there is no narrow sun with nothing but the world beside it, or one shadow ray a point")


def _direct(rule: Rule, facts: Survey) -> Decision:
    """Shadow rays from visible points."""
    needless = [rule.unasked("Direct"), (not facts.rough, NO_ROUGH)]
    return rule.decide(f"{names(facts.lit)} on {names(facts.rough)}", [(not facts.lit, NO_LIGHT)], needless)


def _caustic(rule: Rule, facts: Survey, settings: Settings, mirrored: Sequence[str]) -> dict[str, Decision]:
    """The map of caustic photons, and its use where the eye looks; mirrored: materials that show them in Diffuse."""
    asked, unasked = rule.unasked("Caustic")
    runs = rule.decide(
        f"{names(facts.sharp)} may focus light on {names(facts.rough)}",
        [
            (not facts.lit, NO_LIGHT), (not facts.surfaces, "no surface"),
            (settings.caustic_photons == 0, "Caustic Photons is 0"),
        ],
        [
            (asked and not mirrored, unasked),
            (not facts.sharp, "no specular surface"), (not facts.rough, NO_ROUGH),
        ],
    )  # fmt: skip
    seen = rule.decide("Caustic shows them", [(not runs, "no caustic map")], [rule.unasked("Caustic")])
    return {"caustic_map": runs, "caustic_points": seen}


def _diffuse(rule: Rule, facts: Survey, settings: Settings) -> Decision:
    """The map of photons that met two rough surfaces or more."""
    return rule.decide(
        f"light goes on between {names(facts.rough)}",
        [
            (not facts.lit, NO_LIGHT), (not facts.surfaces, "no surface"),
            (settings.diffuse_photons == 0, "Diffuse Photons is 0"),
            (settings.diffuse_bounces == 0, "Diffuse Bounces is 0"),
        ],
        [
            rule.unasked("Diffuse"), (not facts.rough, NO_ROUGH),
            # the rays of a final gather would look up first hits
            (settings.max_bounces < 2 and settings.final_gather == "OFF", "Bounces is 1"),
        ],
    )  # fmt: skip


def _gathers(rule: Rule, facts: Survey, settings: Settings, diffuse: Decision) -> dict[str, Decision]:
    """Final gathers; off is off. Automatic: both, until the pilot pass has counted photons."""
    mode = settings.resolved().final_gather
    other = f"Final Gather is {mode.capitalize()}"
    everywhere = f"{other}: the pilot pass decides" if mode == "AUTO" else other
    none = (not diffuse, "no diffuse map")
    narrow = rule.decide(
        f"{names(facts.narrow)} reflects too narrowly for the map",
        [(mode not in ("GLOSSY", "AUTO"), other), none],
        [(not facts.narrow, "no narrow glossy surface")],
    )
    return {
        "gather_all": rule.decide(everywhere, [(mode not in ("ALL", "AUTO"), other), none]),
        "gather_narrow": narrow,
    }


def _edges(rule: Rule, maps: dict[str, Decision]) -> Decision:
    """Rays that look how far the surface goes on around visible points: nobody asks without a map."""
    light = [name.removesuffix("_map") for name, choice in maps.items() if choice]
    return rule.decide(f"{' and '.join(light)} photons are counted on the surface only", [(not light, "no photon map")])


def _seen(rule: Rule, facts: Survey) -> dict[str, Decision]:
    """What eye paths see of lights. One look along a ray finds lamps and sky, so the one asked for brings the other."""
    emission = rule.decide(
        f"{names(facts.seen)} can be seen", [], [rule.unasked("Emission"), (not facts.seen, "no visible source")]
    )
    environment = rule.decide(
        f"{names(facts.sky)} gives light", [], [rule.unasked("Environment"), (not facts.sky, "the world is black")]
    )
    return {"emission": emission, "environment": environment}


def _mirrors(rule: Rule, facts: Survey, guides: Decision) -> Decision:
    """Eye paths behind the first surface that is not see-through; depth, normal and albedo are of that one."""
    unlit = not guides and not rule.outputs & frozenset(LIGHT_NAMES)
    needless = [(not facts.sharp, "no specular surface"), (unlit, "neither light nor guides are asked for")]
    return rule.decide(f"{names(facts.sharp)} shows other things", [], needless)


def camera_paths(scene: SceneData, settings: Settings) -> Decision:
    """How many paths of the camera a pass has in each pixel.

    Automatic: 4 or 2 where there are PHOTONS_A_PATH photons for each, else 1. With fewer paths a pass waits for photons
    that hardly anybody looks at; and the paths of one pass are spread evenly over the pixel and over lamps and lobes,
    which those of several passes cannot be: passes are independent. Relative MSE after 4 processor seconds at 128 x
    128, 4 paths against 1: ring_cardioid 0.00050 and 0.0014, diffuse_room denoised 0.0012 and 0.0019, material_shelf
    denoised 0.0049 and 0.0066; raw its noise takes 0.6 of the time.
    """
    frame, asked = scene.frame, settings.eye_samples
    if asked:
        return Decision(asked > 1, f"Camera Paths is {asked}", asked)
    pixels = (frame.x1 - frame.x0) * (frame.y1 - frame.y0)
    if pixels < FEWEST_PIXELS:
        return Decision(False, "the picture has so few pixels that a pass takes no time")
    photons = (settings.caustic_photons + settings.diffuse_photons) / pixels
    count = next((n for n in (4, 2) if photons >= PHOTONS_A_PATH * n), 1)
    return Decision(count > 1, f"a pass has {photons:.2g} photons a pixel", count)


def _media(facts: Survey) -> Decision:
    """Beer's law along rays: a scene without media keeps no track of what a ray is inside of."""
    if not facts.absorbing:
        return Decision(False, "no inside absorbs")
    return Decision(True, f"{names(facts.absorbing)} darkens with depth")


def _subsurface(rule: Rule, facts: Survey) -> Decision:
    """Random walks of eye paths and photons."""
    unlit = not rule.outputs & {"Direct", "Caustic", "Diffuse"}
    return rule.decide(
        f"{names(facts.deep)} lets light in, to leave elsewhere",
        [(not facts.deep, "no material scatters below its surface"), (not facts.lit, NO_LIGHT)],
        [(unlit, "no light on surfaces is asked for")],
    )


def _lens(scene: SceneData) -> Decision:
    """Depth of field: the camera's kernel draws no lens point for a pinhole."""
    radius = scene.camera.aperture_radius
    return Decision(radius > 0.0, f"aperture of {radius * 1e3:.3g} mm" if radius > 0.0 else "a pinhole camera")


def _guides(rule: Rule, settings: Settings) -> Decision:
    """Colour and normal of the first rough surface, averaged for the denoiser."""
    nothing = settings.denoise == "OFF" and not rule.outputs & GUIDES
    why = "the picture is denoised" if settings.denoise != "OFF" else "they are asked for"
    return rule.decide(why, [], [(nothing, "nothing is denoised")])


def every_variance(settings: Settings, outputs: Iterable[str]) -> Decision:
    """Sums of squares of every pixel; strips of rows are enough for figures."""
    rule = Rule(settings.plan, frozenset(outputs))
    unasked = (not rule.outputs & ERROR_MAPS, "no map of the error is asked for: strips of rows tell the figures")
    return rule.decide("a map of the error is asked for", [], [unasked])


def _textures(facts: Survey) -> Decision:
    """Lookups at hits (UVs, attributes, images)."""
    if not facts.varying:
        return Decision(False, "no material varies over a surface: no UVs, attributes or images are looked up")
    reads = ", ".join(sorted(facts.needs)) or "directions"
    return Decision(True, f"{names(facts.varying)} reads {reads}")


def _unworn(settings: Settings, facts: Survey) -> Decision:
    """Compiling materials that no triangle wears."""
    if not settings.plan:
        return Decision(True, OFF)
    return Decision(False, names(facts.unworn) if facts.unworn else "there is none")


def names(items: Sequence[str], most: int = 2) -> str:
    """`Glass`, `Glass and Metal`, `Glass, Metal and 3 more`."""
    items = list(items)
    if len(items) > most:
        return f"{', '.join(items[:most])} and {len(items) - most} more"
    return " and ".join(items)
