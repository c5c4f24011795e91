"""How a run of a task ended."""

from dataclasses import dataclass
from typing import Any

from planning.errors import Canceled, DeadlineExceeded, WayproofError
from service.jobs.errors import WorkerCrashed


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


def canceled_failure() -> dict[str, Any]:
    """Return the `failure` of a job that was canceled from outside."""
    return failure_of(Canceled("canceled on request"))


def error_of(outcome: Crashed | TimedOut, attempts: int) -> WayproofError:
    """Return the error that a run without an answer amounts to, after so many attempts."""
    if isinstance(outcome, TimedOut):
        message = f"the process was ended after {outcome.allowed:g} s"
        return DeadlineExceeded(message, {"allowed": outcome.allowed, "during": "worker"})
    code = outcome.exit_code
    how = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
    message = f"the worker process died {how}, {attempts} times"
    return WorkerCrashed(message, {"exit_code": code, "attempts": attempts})


def value_of(outcome: Outcome, attempts: int) -> Any:
    """Return what a run returned.

    Raises:
        WayproofError: What it raised, or why it did not return.
    """
    match outcome:
        case Returned(result=result):
            return result
        case Raised(error=error):
            raise error
        case Ended():
            raise Canceled("canceled on request")
        case Crashed() | TimedOut():
            raise error_of(outcome, attempts)
