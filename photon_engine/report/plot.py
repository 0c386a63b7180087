"""Error against seconds as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..issues import RenderError
from .metrics import INSTALL

COMBINED = "Combined"
STYLES = {"Photon Map": ("C0", "o-"), "Photon Map, denoised": ("C0", "o--"), "Cycles": ("C1", "s-"),
          "Cycles, denoised": ("C1", "s--")}  # fmt: skip
COLORS = {"Direct": "C2", "Caustic": "C3", "Diffuse": "C4", "Emission": "C5", "Environment": "C6"}
PANEL = (6.4, 4.6)  # [in]
DPI = 120

Line = list[dict[str, Any]]  # points, ascending in time


def load_matplotlib() -> Any:
    """Matplotlib's pyplot that needs no screen; a RenderError where it is not installed."""
    try:
        import matplotlib
    except ImportError:
        raise RenderError("report", "the package matplotlib is not installed", INSTALL) from None
    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def by_line(points: list[dict[str, Any]]) -> dict[tuple[str, str], Line]:
    """Points by (engine, picture): Combined of each engine, then components."""
    found: dict[tuple[str, str], Line] = {}
    for point in sorted(points, key=lambda point: (point["part"] != COMBINED, point["seconds"])):
        found.setdefault((point["engine"], point["part"]), []).append(point)
    order = list(dict.fromkeys((point["engine"], point["part"]) for point in points))
    return dict(sorted(found.items(), key=lambda item: (item[0][1] != COMBINED, order.index(item[0]))))


def plot(points: list[dict[str, Any]], title: str, source: str, target: Path) -> list[Path]:
    """Write target.png and target.svg: error against seconds of the whole picture by engine, and of our components.

    source : what the errors are from. Components stand in a panel of their own, where there are any.
    """
    pyplot = load_matplotlib()
    lines = by_line(points)
    engines = {engine: line for (engine, part), line in lines.items() if part == COMBINED}
    parts = {part: line for (_, part), line in lines.items() if part != COMBINED}
    count = 1 + bool(parts)
    figure, (panels,) = pyplot.subplots(1, count, figsize=(PANEL[0] * count, PANEL[1]), squeeze=False, sharex=True)
    for engine, line in engines.items():
        _draw(panels[0], line, engine, *STYLES.get(engine, ("C7", "^-")))
    panels[0].plot([], [], ":", color="grey", label="without the worst 0.1% of pixels")
    panels[0].set_title("Combined", fontsize=10)
    for part, line in parts.items():
        _draw(panels[1], line, part, COLORS.get(part, "C7"), "o-")
    if parts:
        panels[1].set_title("Components of Photon Map", fontsize=10)
    for axes in panels:
        _finish(axes, sorted({point["asked_seconds"] for point in points}))
    figure.suptitle(f"{title}\n{source}", fontsize=9)
    figure.tight_layout()
    paths = [target.with_suffix(suffix) for suffix in (".png", ".svg")]
    for path in paths:
        figure.savefig(path, dpi=DPI)
    pyplot.close(figure)
    return paths


def _draw(axes: Any, line: Line, label: str, color: str, style: str) -> None:
    """relMSE with markers, relMSE999 dotted."""
    seconds = [point["seconds"] for point in line]
    axes.loglog(seconds, [point["relMSE"] for point in line], style, color=color, label=label, markersize=5)
    axes.loglog(seconds, [point["relMSE999"] for point in line], ":", color=color, linewidth=1.2)


def _finish(axes: Any, asked: list[float]) -> None:
    """Names of the axes, grid, ticks at the seconds that were asked for."""
    from matplotlib.ticker import NullFormatter

    axes.set(xlabel="seconds", ylabel="relMSE")
    axes.set_xticks(asked, [f"{seconds:g}" for seconds in asked])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=3)
