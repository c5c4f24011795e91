"""How a run of a task ended, and the error that this amounts to."""

import signal
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from planning.errors import (
    Canceled,
    DeadlineExceeded,
    ExecutionFailure,
    PlanningFailure,
    WayproofError,
)
from service.jobs.errors import (
    WORKER,
    HostLost,
    MemoryLimitExceeded,
    ServerRestarted,
    WorkerCrashed,
    WorkerUnresponsive,
)
from service.jobs.json_text import Encoded


@dataclass(frozen=True)
class Returned:
    """It returned.

    Attributes:
        result: What.
        summary: What lists show of it; None for all.
    """

    result: Encoded
    summary: Encoded | None = None


def returned(summary: str, result: str) -> Returned:
    """Return the outcome of two texts, of which the first may be empty."""
    return Returned(Encoded(result), Encoded(summary) if summary else None)


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
    """Its time had run out.

    Attributes:
        time_limit: Time that it was allowed [s].
        error: What it said when it was told to end, None if it was ended by force.
        grace: Time beyond it in which it could have ended by itself [s].
    """

    time_limit: float
    error: WayproofError | None = field(default=None, compare=False)
    grace: float = 0.0


@dataclass(frozen=True)
class Silent:
    """Its process was alive and said nothing for too long [s]: it was ended."""

    seconds: float


@dataclass(frozen=True)
class MemoryExceeded:
    """It used more memory than it may, and was ended.

    Attributes:
        used: The most that was seen [bytes].
        bound: What it may use [bytes].
    """

    used: int
    bound: int


@dataclass(frozen=True)
class Lost:
    """The machine of its worker was lost.

    Attributes:
        host: Which one.
        has_begun: Whether it may have begun there.
    """

    host: str
    has_begun: bool


@dataclass(frozen=True)
class Terminated:
    """It ended, or was killed, on request.

    Attributes:
        error: What it said, None if it was ended by force.
    """

    error: WayproofError | None = None


type Failed = Raised | Crashed | Silent | TimedOut | MemoryExceeded | Lost | Terminated
type Outcome = Returned | Failed


def is_deterministic(summary: Any) -> bool:
    """Return whether what lists show of a result says that no clock had a part in it."""
    return isinstance(summary, dict) and summary.get("cut_short") == []


def error_of(outcome: Failed, attempts: int) -> WayproofError:
    """Return the error that a run without a result amounts to."""
    match outcome:
        case Raised(error=error):
            return error
        case Terminated(error=error):
            # A robot that was lost or touched something on its way to rest is not merely canceled.
            is_own = isinstance(error, Canceled | ExecutionFailure)
            return error if is_own else Canceled("canceled on request")
        case TimedOut(error=DeadlineExceeded() as error):
            return error
        case TimedOut():
            return _late(outcome)
        case Silent(seconds=seconds):
            message = f"the worker process said nothing for {seconds:g} s and was ended"
            return WorkerUnresponsive(message, {"silence": seconds, "attempts": attempts})
        case MemoryExceeded() | Crashed() | Lost():
            return _without_worker(outcome, attempts)


def signal_name(number: int) -> str:
    """Return the name of a signal, such as `SIGSEGV`."""
    known = {int(item): item.name for item in signal.Signals}
    return known.get(number, f"signal {number}")


def failure_of(error: WayproofError) -> dict[str, Any]:
    """Return the `failure` that a job shows for an error."""
    return {
        "code": error.code,
        "stage": getattr(error, "stage", ""),
        "detail": error.detail,
        "evidence": error.evidence,
        "timings": dict(getattr(error, "timings", {})),
    }


def with_stage(
    error: WayproofError, stage_event: Mapping[str, Any], seconds: float
) -> WayproofError:
    """Return the error of a run that was ended by force, with the stage that it was in.

    Args:
        error: What the run amounts to; one that knows its stage keeps it.
        stage_event: The data of the last event `stage`: its `stage`, and `timings` before it [s].
        seconds: How long the run took.
    """
    stage = stage_event.get("stage")
    if not isinstance(error, PlanningFailure) or error.stage != WORKER:
        return error
    if not isinstance(stage, str):
        return error
    timings = {
        str(name): float(spent) for name, spent in dict(stage_event.get("timings") or {}).items()
    }
    last = max(0.0, seconds - sum(timings.values()))
    found = error.saying(f"{error.detail}, in the stage {stage}", {"during": stage})
    found.timings = {**timings, stage: timings.get(stage, 0.0) + last, "total": seconds}
    return found.in_stage(stage)


def interrupted(outcome: Failed, error: WayproofError, reason: str, attempts: int) -> WayproofError:
    """Return the error of a run that the server had to end.

    Args:
        outcome: How it ended.
        error: What that amounts to otherwise.
        reason: Why the server ended it.
        attempts: How often the job was started.
    """
    match outcome:
        case Terminated(error=Canceled() as canceled):
            # It came to its end as one that is canceled does; why, is ours to say.
            return canceled.saying(f"{canceled.detail}: {reason}", {"reason": reason})
        case Terminated(error=None) | Crashed():
            message = f"{reason} while this ran, and it did not end in time"
            return ServerRestarted(message, {"attempts": attempts, "reason": reason})
        case _:
            return error


def _late(outcome: TimedOut) -> DeadlineExceeded:
    """Return the error of a run that did not end in time, with what it said then."""
    allowed, grace, said = outcome.time_limit, outcome.grace, outcome.error
    during = said.stage if isinstance(said, PlanningFailure) else WORKER
    message = f"the task did not end within the allowed {allowed:g} s"
    evidence = {"allowed": allowed, "during": during}
    if grace > 0.0:
        message, evidence = f"{message}, nor {grace:g} s later", {**evidence, "grace": grace}
    late = DeadlineExceeded(message, evidence).in_stage(during)
    late.timings = said.timings if isinstance(said, PlanningFailure) else {}
    return late


def _without_worker(outcome: MemoryExceeded | Crashed | Lost, attempts: int) -> WayproofError:
    """Return the error of a run whose process ended, or its machine."""
    if isinstance(outcome, Crashed):
        return _crash(outcome, attempts)
    if isinstance(outcome, Lost):
        message = f"the machine {outcome.host} was lost"
        return HostLost(message, {"attempts": attempts, "host": outcome.host})
    message = f"the task needs more than the {outcome.bound / 1e6:.0f} MB that a worker may use"
    evidence = {"used": outcome.used, "bound": outcome.bound, "attempts": attempts}
    return MemoryLimitExceeded(message, evidence)


def _crash(crash: Crashed, attempts: int) -> WorkerCrashed:
    code = crash.exit_code
    name = signal_name(-code) if code is not None and code < 0 else None
    how = crash.reason or (f"by {name}" if name else f"with exit code {code}")
    times = "once" if attempts == 1 else f"{attempts} times"
    evidence = {"attempts": attempts, "exit_code": code, "signal": name, "reason": crash.reason}
    return WorkerCrashed(f"the worker process died {times}, at last {how}", evidence)
