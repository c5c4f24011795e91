"""States of a job and what moves it from one to another, as a table."""

from enum import StrEnum

from planning.errors import IllegalTransition


class JobState(StrEnum):
    """State of a job; the last three are final and written once."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELED = "canceled"

    @property
    def is_final(self) -> bool:
        """Whether nothing can happen to the job any more."""
        return self in (JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELED)


class JobEvent(StrEnum):
    """What can happen to a job."""

    START = "start"
    SUCCEED = "succeed"
    FAIL = "fail"
    CANCEL = "cancel"
    REQUEUE = "requeue"


TRANSITIONS: dict[tuple[JobState, JobEvent], JobState] = {
    (JobState.QUEUED, JobEvent.START): JobState.RUNNING,
    (JobState.QUEUED, JobEvent.FAIL): JobState.FAILED,
    (JobState.QUEUED, JobEvent.CANCEL): JobState.CANCELED,
    (JobState.RUNNING, JobEvent.SUCCEED): JobState.SUCCEEDED,
    (JobState.RUNNING, JobEvent.FAIL): JobState.FAILED,
    (JobState.RUNNING, JobEvent.CANCEL): JobState.CANCELED,
    (JobState.RUNNING, JobEvent.REQUEUE): JobState.QUEUED,
}


def advance(state: JobState, event: JobEvent) -> JobState:
    """Return the state after an event.

    Raises:
        IllegalTransition: The event cannot happen in this state.
    """
    after = TRANSITIONS.get((state, event))
    if after is None:
        legal = sorted(e for s, e in TRANSITIONS if s is state)
        message = f"a {state} job cannot {event}; it can {legal}"
        raise IllegalTransition(message, {"state": state, "event": event, "legal": legal})
    return after


def sources(event: JobEvent) -> tuple[JobState, ...]:
    """Return the states that allow an event."""
    return tuple(state for state, allowed in TRANSITIONS if allowed is event)
