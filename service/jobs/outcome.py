"""How a run of a task ended."""

import signal
from dataclasses import dataclass
from typing import Any

from planning.errors import Canceled, DeadlineExceeded, ExecutionFailure, WayproofError
from service.jobs.errors import MemoryLimitExceeded, WorkerCrashed, WorkerUnresponsive
from service.jobs.json_text import Encoded


@dataclass(frozen=True)
class Returned:
    """It returned.

    Attributes:
        result: What.
        brief: What lists show of it; None for all.
    """

    result: Encoded
    brief: Encoded | None = None


def returned(brief: str, result: str) -> Returned:
    """Return the outcome of two texts, of which the first may be empty."""
    return Returned(Encoded(result), Encoded(brief) if brief else None)


@dataclass(frozen=True)
class Raised:
    """It said why not, with one of our errors."""

    error: WayproofError


@dataclass(frozen=True)
class Crashed:
    """Its process died.

    Attributes:
        exit_code: Negative where a signal ended it, None if unknown.
        reason: What it said before, or empty.
    """

    exit_code: int | None
    reason: str = ""


@dataclass(frozen=True)
class TimedOut:
    """Its time had run out [s]."""

    allowed: float


@dataclass(frozen=True)
class Silent:
    """Its process was alive and said nothing for too long [s]: it was ended."""

    seconds: float


@dataclass(frozen=True)
class Overgrown:
    """It used more memory than it may, and was ended.

    Attributes:
        used: The most that was seen [bytes].
        bound: What it may use [bytes].
    """

    used: int
    bound: int


@dataclass(frozen=True)
class Ended:
    """It ended, or was ended, because somebody asked for it.

    Attributes:
        error: What it said, None if it was ended by force.
    """

    error: WayproofError | None = None


type Failed = Raised | Crashed | Silent | TimedOut | Overgrown | Ended
type Outcome = Returned | Failed


def error_of(outcome: Failed, attempts: int) -> WayproofError:
    """Return the error that a run without a result amounts to."""
    match outcome:
        case Raised(error=error):
            return error
        case Ended(error=error):
            # A robot that was lost or touched something on its way to rest is not merely canceled.
            is_own = isinstance(error, Canceled | ExecutionFailure)
            return error if is_own else Canceled("canceled on request")
        case TimedOut(allowed=allowed):
            message = f"the task did not end within {allowed:g} s"
            return DeadlineExceeded(message, {"allowed": allowed, "during": "worker"})
        case Silent(seconds=seconds):
            message = f"the worker process said nothing for {seconds:g} s and was ended"
            return WorkerUnresponsive(message, {"silence": seconds, "attempts": attempts})
        case Overgrown(used=used, bound=bound):
            message = f"the task needs more than the {bound / 1e6:.0f} MB that a worker may use"
            evidence = {"used": used, "bound": bound, "attempts": attempts}
            return MemoryLimitExceeded(message, evidence)
        case Crashed():
            return _crash(outcome, attempts)


def failure_of(error: WayproofError) -> dict[str, Any]:
    """Return the `failure` that a job shows for an error."""
    return {
        "code": error.code,
        "stage": getattr(error, "stage", ""),
        "detail": error.detail,
        "evidence": error.evidence,
    }


def _crash(crash: Crashed, attempts: int) -> WorkerCrashed:
    code = crash.exit_code
    name = None
    if code is not None and code < 0:
        number = -code
        known = {int(item): item.name for item in signal.Signals}
        name = known.get(number, f"signal {number}")
    how = crash.reason or (f"by {name}" if name else f"with exit code {code}")
    times = "once" if attempts == 1 else f"{attempts} times"
    evidence = {"attempts": attempts, "exit_code": code, "signal": name, "reason": crash.reason}
    return WorkerCrashed(f"the worker process died {times}, at last {how}", evidence)
