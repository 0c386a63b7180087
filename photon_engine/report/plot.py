"""Error against seconds as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..issues import RenderError
from .metrics import INSTALL

STYLES = {"Photon Map": ("C0", "o-"), "Photon Map, denoised": ("C0", "o--"), "Cycles": ("C1", "s-"),
          "Cycles, denoised": ("C1", "s--")}  # fmt: skip


def load_matplotlib() -> Any:
    """Matplotlib's pyplot that needs no screen; a RenderError where it is not installed."""
    try:
        import matplotlib
    except ImportError:
        raise RenderError("report", "the package matplotlib is not installed", INSTALL) from None
    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def plot(points: list[dict[str, Any]], title: str, target: Path) -> list[Path]:
    """Write target.png and target.svg: relMSE against seconds, a line for each engine and, thin, each component."""
    pyplot = load_matplotlib()
    figure, axes = pyplot.subplots(figsize=(7.0, 4.5))
    lines: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for point in points:
        lines.setdefault((point["engine"], point["part"]), []).append((point["seconds"], point["relMSE"]))
    parts = list(dict.fromkeys(part for _, part in lines))
    for (engine, part), line in lines.items():
        color, style = STYLES.get(engine, ("C2", "^-"))
        thin = part != "Combined"
        label = f"{engine}: {part}" if thin else engine
        color = f"C{2 + parts.index(part)}" if thin else color
        seconds, error = zip(*sorted(line), strict=True)
        axes.loglog(seconds, error, style, color=color, label=label, linewidth=0.8 if thin else 2.0,
                    markersize=3 if thin else 6)  # fmt: skip
    axes.set(xlabel="seconds", ylabel="relMSE", title=title)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=7)
    figure.tight_layout()
    paths = [target.with_suffix(suffix) for suffix in (".png", ".svg")]
    for path in paths:
        figure.savefig(path, dpi=120)
    pyplot.close(figure)
    return paths
