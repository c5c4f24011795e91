"""A job as a value: what it does, what became of it, and its events."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from functools import cached_property
from typing import Any, Self, override

from service.jobs.json_text import Encoded, decoded
from service.jobs.states import JobState

FINISHED = "finished"
CONTROLS = "controls"

# Type and data of an event that is not recorded yet.
type PendingEvent = tuple[str, Encoded]


class Priority(StrEnum):
    """Priority among the jobs that wait."""

    LOW = "low"
    NORMAL = "normal"
    HIGH = "high"

    @property
    def level(self) -> int:
        """The larger the sooner; 0 is normal."""
        return list(Priority).index(self) - 1


@dataclass(frozen=True)
class IdempotencyKey:
    """An idempotency key, or none, and all that must be the same where it is used again.

    Attributes:
        text: As the client chose it, or None.
        fingerprint: All that tells this request from another one of its queue, JSON-compatible: the
            body as it was sent, and what its address named.
    """

    text: str | None
    fingerprint: Mapping[str, Any]

    @classmethod
    def of(cls, text: str | None, fingerprint: Callable[[], Mapping[str, Any]]) -> Self:
        """Return a key; what it stands for is put together only where there is one."""
        return cls(text, {} if text is None else fingerprint())

    @property
    def digest(self) -> str:
        """The sha256 of what it stands for; empty without a key, for then it is never compared."""
        if self.text is None:
            return ""
        return hashlib.sha256(json.dumps(self.fingerprint, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class JobSpec:
    """What a job does.

    Attributes:
        queue: Which workers may run it.
        task: Its name.
        payload: JSON-compatible, or JSON already; `cancel_grace` in it stands for the queue's [s].
        prefix: Of the job's id.
        scene: Id of the scene it is about, for listing.
        world_digest: Workers that ran this key lately are preferred.
        priority: Level of a `Priority`; larger comes first.
        time_limit: Seconds after which it is told to end, and soon after killed; None without one.
        max_attempts: How often it may be run if its process dies.
        key: Idempotency key within the queue, or None.
        request_digest: What a second request with the same key must match.
        batch: Id of the batch that it is of, or None.
        follows: How many jobs that move robots had entered its scene when the request looked: the
            job is refused if there are more by now. None if that is no matter.
        robots: That it moves, in its scene; no other job moves one of them meanwhile.
        waits: Whether it waits for its robots, and begins once it is released.
        client: Who requests it: clients take turns.
    """

    queue: str
    task: str
    payload: dict[str, Any] | Encoded
    prefix: str = "job"
    scene: str | None = None
    world_digest: str | None = None
    priority: int = 0
    time_limit: float | None = None
    max_attempts: int = 2
    key: str | None = None
    request_digest: str = ""
    batch: str | None = None
    follows: int | None = None
    robots: tuple[str, ...] = ()
    waits: bool = False
    client: str = ""


@dataclass(frozen=True)
class JobSummary:
    """A job as lists have it: its payload, result and failure lack what is large."""

    id: str
    sequence: int
    queue: str
    task: str
    payload: dict[str, Any]
    scene: str | None
    world_digest: str | None
    priority: int
    time_limit: float | None
    max_attempts: int
    attempts: int
    key: str | None
    request_digest: str
    batch: str | None
    state: JobState
    stage: str
    progress: float
    is_cancel_requested: bool
    cancel_requested_at: datetime | None
    num_events: int
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    client: str
    result: dict[str, Any] | None
    failure: dict[str, Any] | None
    made_by: dict[str, str] | None


@dataclass(frozen=True)
class Job(JobSummary):
    """A job as the tables have it, whole."""


@dataclass(frozen=True)
class BatchMember:
    """A job of a batch, and when it was asked for and has ended."""

    id: str
    state: JobState
    created_at: datetime
    finished_at: datetime | None


@dataclass(frozen=True)
class BatchSummary:
    """A batch of jobs as lists have it.

    Attributes:
        id: Of the batch.
        sequence: Of its first job that there is still.
        counts: How many jobs there are, by state.
        created_at: When the first one was asked for.
        finished_at: When the last one ended; None while one has not.
    """

    id: str
    sequence: int
    counts: dict[JobState, int]
    created_at: datetime
    finished_at: datetime | None

    @classmethod
    def of(cls, identifier: str, sequence: int, states: Sequence[Sequence[Any]]) -> Self:
        """Return a batch.

        Args:
            identifier: Its id.
            sequence: Of its first job.
            states: Of its jobs: the name of each, how many jobs, since when, until when.
        """
        counts = {JobState(state): count for state, count, _, _ in states}
        begun = min(datetime.fromisoformat(created) for _, _, created, _ in states)
        ends = [datetime.fromisoformat(end) for _, _, _, end in states if end]
        is_over = all(state.is_final for state in counts)
        return cls(identifier, sequence, counts, begun, max(ends) if is_over else None)


@dataclass(frozen=True)
class JobText:
    """A job whose result is passed on as it is: it may be megabytes, and is not read here.

    Attributes:
        summary: As lists have it.
        result: Whole, None where there is none.
    """

    summary: JobSummary
    result: Encoded | None


@dataclass(frozen=True, eq=False)
class LoggedEvent:
    """An event of a job; numbers count from 1 without gaps.

    Attributes:
        job: Its id.
        number: Of the event.
        type: What kind of event it is.
        content: Its data, which may be JSON still: most events are recorded and not read here.
        at: When it was recorded (ISO 8601, UTC).
    """

    job: str
    number: int
    type: str
    content: Encoded | dict[str, Any]
    at: str

    @override
    def __eq__(self, other: object) -> bool:
        """Return whether another event tells the same, whether that was read or not."""
        if not isinstance(other, LoggedEvent):
            return NotImplemented
        return self._place == other._place and self.data == other.data

    @override
    def __hash__(self) -> int:
        return hash(self._place)

    @property
    def _place(self) -> tuple[str, int, str, str]:
        return self.job, self.number, self.type, self.at

    @cached_property
    def data(self) -> dict[str, Any]:
        """What it tells."""
        return decoded(self.content)

    @property
    def is_last(self) -> bool:
        """Whether nothing happens to the job after it."""
        return self.type == FINISHED


@dataclass(frozen=True)
class JobPage:
    """Some jobs of a queue, newest first, and the number before which the next page begins."""

    jobs: list[JobSummary]
    following: int | None

    @classmethod
    def of(cls, found: list[JobSummary], limit: int) -> Self:
        """Return a page of at most `limit` jobs, of what was found, which may be one more."""
        return cls(found[:limit], found[limit - 1].sequence if len(found) > limit else None)


@dataclass(frozen=True)
class BatchPage:
    """Some batches, newest first, and the number before which the next page begins."""

    batches: list[BatchSummary]
    following: int | None

    @classmethod
    def of(cls, found: list[BatchSummary], limit: int) -> Self:
        """Return a page of at most `limit` batches, of what was found, which may be one more."""
        return cls(found[:limit], found[limit - 1].sequence if len(found) > limit else None)
