"""What went wrong, in words a user can act on, and why a render stopped."""

from __future__ import annotations

import enum
import logging
from typing import NamedTuple

log = logging.getLogger("photon_map")


class Severity(enum.StrEnum):
    """How much an issue matters to the picture."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


class StopReason(enum.StrEnum):
    """Why the progressive loop ended."""

    PASSES = "the requested passes are done"
    SECONDS = "the time budget is spent"
    ERROR = "the error is below its target"
    CANCELLED = "cancelled by the user"


class Issue(NamedTuple):
    """One thing a user should know: which object, what is wrong, what to do."""

    severity: Severity
    object: str  # the data-block or setting it is about
    message: str
    remedy: str = ""

    def __str__(self) -> str:
        """One line: object, message, remedy."""
        tail = f" ({self.remedy})" if self.remedy else ""
        return f"{self.object}: {self.message}{tail}"


class RenderError(Exception):
    """A user's problem that makes rendering impossible; carries its Issue."""

    def __init__(self, object: str, message: str, remedy: str = "") -> None:
        self.issue = Issue(Severity.ERROR, object, message, remedy)
        super().__init__(str(self.issue))

    def __reduce__(self):
        """What makes it again from a pickle: an exception that takes several arguments must say so."""
        return type(self), tuple(self.issue[1:])


class IssueLog:
    """Collects issues, each once, in the order they were first seen."""

    def __init__(self) -> None:
        self._seen: dict[Issue, None] = {}

    def add(self, severity: Severity, object: str, message: str, remedy: str = "") -> None:
        """Record an issue; a repeat of the same one is dropped."""
        issue = Issue(severity, object, message, remedy)
        if issue in self._seen:
            return
        self._seen[issue] = None
        level = {Severity.INFO: logging.INFO, Severity.WARNING: logging.WARNING, Severity.ERROR: logging.ERROR}
        log.log(level[severity], "%s", issue)

    def warn(self, object: str, message: str, remedy: str = "") -> None:
        """Record a warning."""
        self.add(Severity.WARNING, object, message, remedy)

    def info(self, object: str, message: str, remedy: str = "") -> None:
        """Record a remark."""
        self.add(Severity.INFO, object, message, remedy)

    def extend(self, other: IssueLog) -> None:
        """Take over the issues of another log."""
        self._seen.update(dict.fromkeys(other))

    def __iter__(self):
        """The issues, in order."""
        return iter(self._seen)

    def __len__(self) -> int:
        """How many distinct issues were seen."""
        return len(self._seen)
