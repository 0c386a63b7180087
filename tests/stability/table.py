"""The tables in README.md and docs/stability.md, from what was found."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from .lab import Case, Finding

ROOT = Path(__file__).resolve().parents[2]
README, DOCS = ROOT / "README.md", ROOT / "docs" / "stability.md"
BEGIN, END = "<!-- from python -m tests.stability --markdown -->", "<!-- end -->"
HEAD = """# Extreme scenes, case by case

Written by `python -m tests.stability --markdown [FAMILY ...]`. Cost: processor time of the case, as a multiple of four
passes of the plain scene. All pixels of all passes are finite and no light is negative, always.
"""

# family -> (cases, law) in a few words
FAMILIES = {
    "scale": ("room by lamp, ball, mesh, sun, world; times 1e-4 ... 1e4", "same picture, lights by the square"),
    "power": ("lights times 1e-9 ... 1e12; a lamp or glowing square 1e6 times brighter next door",
              "linear; error bars of the dim room"),
    "place": (
        "moved by 1e5 m; an object 1e6 m away; both in Blender: objects, a parent, instances, all kinds of coordinates",
        "same picture; what Blender's own floats round",
    ),
    "lights": (
        "size 0 to huge, spot 0.1 and 180, sun 0 and 180 degrees, touching, through a wall, boxed in, dark, negative, "
        "a million emitters", "formulas; 99.99th percentile against the truth",
    ),
    "camera": (
        "1 and 5000 mm, orthographic 1 m and 0.1 mm wide, 1 x 1 to 1 x 4096 pixels, pixel aspect 10, one-pixel border, "
        "on a surface, 10 m aperture", "as a plain render, a crop",
    ),
    "triangles": (
        "no area, NaN, infinite, needles, doubled, reversed, three on an edge, empty, mirrored, sheared, sizes of "
        "1e7:1", "the rest unchanged, one message",
    ),
    "images": (
        "1 x 1, 16384 wide, NaN, infinite and negative texels, 1e30, an HDR sun of 1e6, none",
        "as the plain wall, irradiance, message",
    ),
    "long chains": (
        "closed boxes of albedo and mirrors 0.9 ... 1, up to 1024 bounces; facing mirrors; lamp and camera in a block "
        "of glass; 64 shells", "sum of the bounces; n^2 L; what the cap cuts off is said",
    ),
    "index": (
        "0.5 ... 1000; glass, water and table that overlap, touch, coincide; panes; lamp inside a ball",
        "L / n^2 is kept; Fresnel; 2 n / (n^2 + 1); index 1 is not there",
    ),
    "stiff mixes": (
        "a caustic 5e5 times brighter than the dark half; 31 waves in 2 m; panes of 1 to 1000 micrometres over a floor "
        "of 100 m", "claimed errors within 1.5 of the true ones; 2 n / (n^2 + 1)",
    ),
    "roughness": (
        "0 ... 1, each side of the threshold, threshold 0; rough glass that bends next to nothing",
        "white stays white; the same Combined",
    ),
    "grazing": (
        "sun and eye at 80 ... 89.9999 degrees; coarse smooth balls; normals leaning 95 degrees",
        "E = S cos; furnace; no leaks; no brighter than the world",
    ),
    "photons": (
        "none sent, none stored, one a pass, a million in one spot, beams much thinner than their mirror, 10 million "
        "in a pass", "direct light unchanged, flux, mean, memory",
    ),
    "time and state": (
        "cancelled at every stage, 0.1 s, a million passes of 1e6 with deviation 1e-3, both ends of every setting",
        "result kept, variance to 1e-3",
    ),
}  # fmt: skip


class Row(NamedTuple):
    """A case with what was found."""

    case: Case
    found: Finding
    cost: float


def rewrite(rows: Sequence[Row]) -> None:
    """Put the families of these rows into both files; what they say of others stays."""
    families = {family: [row for row in rows if row.case.family == family] for family in FAMILIES}
    old = sections(DOCS.read_text() if DOCS.exists() else "")
    text = [HEAD]
    for family, mine in families.items():
        text.append(f"## {family}\n\n{detail(mine)}" if mine else old.get(family, f"## {family}\n"))
    DOCS.write_text("\n".join(text))
    before, _, rest = README.read_text().partition(BEGIN)
    table, _, after = rest.partition(END)
    kept = {line.split(" | ")[0].lstrip("| "): line for line in table.splitlines()}
    lines = ["| family | cases | law | held | nearest to its bound | cost |", "| --- | --- | --- | --- | --- | --- |"]
    lines += [summary(family, mine) if mine else kept.get(family, "") for family, mine in families.items()]
    table = "\n".join(line for line in lines if line)
    README.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}")


def sections(text: str) -> dict[str, str]:
    """Family -> its part of docs/stability.md."""
    return {part.splitlines()[0]: f"## {part.rstrip()}\n" for part in text.split("\n## ")[1:]}


def detail(rows: Sequence[Row]) -> str:
    """All cases of a family."""
    lines = ["| case | law | found | cost |", "| --- | --- | --- | --- |"]
    for row in rows:
        broken = "" if row.found.good else f"**BROKEN** {row.case.known}: "
        lines.append(f"| {row.case.name} | {row.case.law} | {broken}{row.found.figure} | {row.cost:.1f}x |")
    return "\n".join(lines) + "\n"


def summary(family: str, rows: Sequence[Row]) -> str:
    """One line for a family."""
    cases, law = FAMILIES[family]
    good = sum(row.found.good for row in rows)
    judged = [row for row in rows if row.found.used == row.found.used]
    worst = max(judged, key=lambda row: row.found.used, default=None)
    nearest = f"{worst.case.name}: {worst.found.figure} ({worst.found.used:.0%} of it)" if worst else ""
    costs = sorted(row.cost for row in rows)
    return f"| {family} | {cases} | {law} | {good} of {len(rows)} | {nearest} | {costs[0]:.1f} ... {costs[-1]:.1f}x |"
