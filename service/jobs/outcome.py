"""How a run of a task ended."""

from dataclasses import dataclass
from typing import Any

from planning.errors import WayproofError


@dataclass(frozen=True)
class Returned:
    """It returned."""

    result: Any


@dataclass(frozen=True)
class Raised:
    """It said why not, with one of our errors."""

    error: WayproofError


@dataclass(frozen=True)
class Crashed:
    """Its process died; `exit_code` is negative where a signal ended it, None if unknown."""

    exit_code: int | None


@dataclass(frozen=True)
class TimedOut:
    """Its process was ended because its time had run out."""

    allowed: float


@dataclass(frozen=True)
class Ended:
    """Its process was ended because somebody asked for it."""


type Outcome = Returned | Raised | Crashed | TimedOut | Ended


def failure_of(error: WayproofError) -> dict[str, Any]:
    """Return the `failure` that a job shows for an error."""
    return {
        "code": error.code,
        "stage": getattr(error, "stage", ""),
        "detail": error.detail,
        "evidence": error.evidence,
    }
