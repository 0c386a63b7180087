"""run.json: what was rendered, on what, how fast; enough to repeat it."""

from __future__ import annotations

import json
import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

from ..film.output import OutputError
from ..issues import IssueLog
from .listener import memory

DISTRIBUTIONS = ("bpy", "embreex", "numba", "llvmlite", "numpy", "scipy", "OpenImageIO")


def machine() -> dict[str, Any]:
    """The computer and the versions of what does the work."""
    versions = {}
    for name in DISTRIBUTIONS:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {
        "system": platform.platform(), "processor": _processor(), "cores": os.cpu_count(),
        "python": platform.python_version(), "versions": versions,
    }  # fmt: skip


def _processor() -> str:
    """The processor's name as the system gives it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def run_record(session: Any) -> dict[str, Any]:
    """What a finished (or broken off) driver.session.Session did, as plain values."""
    film = session.film
    return {
        "scene": session.scene.name,
        "frame": session.scene.frame_number,
        "camera": session.scene.camera.name,
        "resolution": [film.width, film.height] if film else None,
        "settings": session.settings.to_dict(),
        "seed": session.settings.seed,
        "passes": film.count if film else 0,
        "blocks": film.blocks if film else [],
        "seconds": sum(session.durations),
        "cpu_seconds": session.cpu_seconds + (session.darkroom.cpu_seconds if session.darkroom else 0.0),
        "pass_seconds": session.durations,
        "stage_seconds": session.stages,
        "statistics": session.statistics,
        "denoised_error": session.denoised_errors,
        "plan": [line._asdict() for line in session.plan.lines()] if session.plan else [],
        "memory_peak_mb": memory()[1],
        "issues": issue_records(session.issues),
        **evidence(session),
    }


def evidence(session: Any) -> dict[str, Any]:
    """What a picture says of itself: why it was finished, with which radii, how wrong it still is, on what it was made.

    radii : by map, of each pass: its number, the radius in pixels, and at most and at least how many metres
    """
    return {
        "stop": session.stop.value if session.stop else "an error",
        "radii": session.statistics.get("radii", {}),
        "error_curve": [mark.record() for mark in session.watch.curve],
        "machine": machine(),
    }


def issue_records(issues: IssueLog) -> list[dict[str, str]]:
    """Issues as plain values."""
    return [{**issue._asdict(), "severity": issue.severity.value} for issue in issues]


def write_json(path: str | Path, record: dict[str, Any]) -> None:
    """Write a record; numpy numbers become plain ones. An OutputError when the place cannot be written."""
    text = json.dumps(record, indent=2, default=_plain)
    try:
        Path(path).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise OutputError(str(path), f"cannot be written: {error.strerror}", "choose another place") from error


def _plain(value: Any) -> Any:
    """A numpy scalar or array as JSON can hold it."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return str(value)
