"""JobStore: the system of record. States change by compare-and-set, final ones are written once.

Every writing transaction begins with an update or insert, which locks what it changes, so nothing
is decided on what another has changed meanwhile; the statements are the same on every database.
"""

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, Engine, bindparam, delete, func, insert, update

from planning.errors import Canceled, WayproofError
from service.jobs.job import Job, JobSpec, LoggedEvent, PendingEvent
from service.jobs.json_text import Encoded, encode
from service.jobs.outcome import failure_of
from service.jobs.outline import without
from service.jobs.states import JobEvent, JobState
from service.jobs.store.artifact_store import ArtifactStore
from service.jobs.store.drafts import Draft, draft, insert_job
from service.jobs.store.event_log import append_events, reserve_events
from service.jobs.store.queries import find_by_idempotency_key, now, read_job
from service.jobs.store.shared import count_queued, set_controls
from service.jobs.store.sql.notifications import note_change
from service.jobs.store.sql.prepared import Prepared
from service.jobs.store.sql.tables import bodies, jobs, makers, summaries
from service.jobs.store.transactions import Transactions
from service.jobs.store.transitions import Change, Transition, apply_change
from service.jobs.task import outline_of

_OPEN = [state.value for state in JobState if not state.is_final]
_JOB_ID = bindparam("job_id")
_FORGET_MAKER = delete(makers).where(makers.c.job == _JOB_ID)
_ADD_MAKER = Prepared(insert(makers), "job", "made_by")
_END = {
    (table, part): Prepared(
        update(table).where(table.c.job == _JOB_ID).values({part: bindparam("new")})
    )
    for table in (bodies, summaries)
    for part in ("result", "failure")
}
_IF_OPEN = update(jobs).where(jobs.c.id == _JOB_ID, jobs.c.state.in_(_OPEN))
# The first request counts.
_CANCEL = _IF_OPEN.values(
    is_cancel_requested=True,
    cancel_requested_at=func.coalesce(jobs.c.cancel_requested_at, bindparam("requested_at")),
)


class JobStore(Transactions):
    """Jobs and their events in a database; every method is one transaction, from any thread.

    Attributes:
        versions: Of what runs them, by name.
        on_event: Called with each change of a state in the transaction that records it: what it
            writes is committed with it. From any thread.
        artifacts: That jobs read.
    """

    def __init__(self, engine: Engine, versions: Mapping[str, str] | None = None) -> None:
        """Keep jobs in `engine`; call `open` before use.

        Args:
            engine: Where.
            versions: Of what runs them, by name.
        """
        super().__init__(engine)
        self.versions = dict(versions or {})
        self.on_event: Callable[[Connection, LoggedEvent], None] | None = None
        self.artifacts = ArtifactStore(engine)
        self._made_by = encode(self.versions)

    def insert(self, spec: JobSpec) -> tuple[Job, bool]:
        """Return a new queued job and True, or the one that the idempotency key names and False.

        Raises:
            IdempotencyConflict: The key was used for another request.
            Overtaken: Another job has entered its scene, or moves one of its robots.
            TypeError: The payload is not JSON-compatible.
        """
        [job], is_new = self.insert_drafts([draft(spec)])
        return job, is_new

    def insert_drafts(
        self, drafts: Sequence[Draft], check: Callable[[int], None] | None = None
    ) -> tuple[list[Job], bool]:
        """Write jobs that were drafted, all of them or none; only the first may have a key.

        Returns the new jobs and True, or the one that the key names and False; raises as `insert`.

        Args:
            drafts: The jobs, of one queue.
            check: Called with the number of jobs that wait in it, if not all of them are here: if
                servers share the database, or for jobs that wait for their robots; it raises if
                that are too many.
        """
        first, *others = drafts
        with self.transaction(is_durable=True) as connection:
            while (known := find_by_idempotency_key(connection, first.job)) is None:
                is_told = self.is_shared or (first.entry is not None and first.entry.waits)
                if check is not None and is_told:
                    check(count_queued(connection, first.job.queue, len(drafts)))
                if (job := insert_job(connection, first)) is not None:
                    more = [insert_job(connection, drafted) for drafted in others]
                    return [job, *(other for other in more if other is not None)], True
            return [known], False

    def start(self, identifier: str) -> Transition | None:
        """Let a queued job run; None if it is not queued any more; so for all transitions."""
        changes = {"started_at": now(), "more_attempts": 1}
        with self.transaction(is_durable=False) as connection:
            transition = self._apply(connection, identifier, Change(JobEvent.START, changes))
            if transition is not None:
                if transition.event.number > 2:  # it is not the first event after `queued`
                    connection.execute(_FORGET_MAKER, {"job_id": identifier})
                _ADD_MAKER(connection, job=identifier, made_by=self._made_by)
            return transition

    def requeue(self, identifier: str, reason: str, *, refund: int = 0) -> Transition | None:
        """Queue a running job again.

        Args:
            identifier: Of the job.
            reason: For people.
            refund: How many attempts do not count.
        """
        change = Change(JobEvent.REQUEUE, {"more_attempts": -refund}, {"reason": reason})
        with self.transaction(is_durable=False) as connection:
            return self._apply(connection, identifier, change)

    def succeed(
        self,
        identifier: str,
        result: Encoded,
        summary: Encoded | None = None,
        events: Sequence[PendingEvent] = (),
    ) -> Transition | None:
        """End a running job with its result.

        Args:
            identifier: Of the job.
            result: Whole.
            summary: What lists show of it; None for all.
            events: Its last ones, which are not recorded yet.
        """
        change = Change(JobEvent.SUCCEED, {"progress": 1.0}, events_before=events)
        with self.transaction(is_durable=True) as connection:
            transition = self._apply(connection, identifier, change)
            if transition is not None:
                _end(connection, identifier, "result", result.text, (summary or result).text)
            return transition

    def fail(self, identifier: str, error: WayproofError) -> Transition | None:
        """End a job with the reason why it has no result."""
        return self._end_without_result(identifier, JobEvent.FAIL, error)

    def cancel(self, identifier: str, error: Canceled) -> Transition | None:
        """End a running job whose cancel was requested."""
        return self._end_without_result(identifier, JobEvent.CANCEL, error)

    def cancel_queued(self, identifier: str, error: Canceled) -> Transition | None:
        """End a job whose cancel was requested, if it is still queued."""
        return self._end_without_result(identifier, JobEvent.CANCEL, error, only=JobState.QUEUED)

    def request_cancel(self, identifier: str, at: datetime | None = None) -> Job:
        """Note that the end of a job is requested, if it has not ended, and return it.

        Args:
            identifier: Of the job.
            at: When that was (UTC); None for now.

        Raises:
            UnknownJob: There is none.
        """
        with self.transaction(is_durable=True) as connection:
            given = {"job_id": identifier, "requested_at": at.isoformat() if at else now()}
            connection.execute(_CANCEL, given)
            note_change(connection, identifier)
            return read_job(connection, identifier)

    def append_events(
        self, identifier: str, new_events: Sequence[PendingEvent], *, may_wait: bool = False
    ) -> list[LoggedEvent]:
        """Append events of a running job, and return them; none if the job has ended meanwhile.

        The last `stage` and `progress` in the data become the job's.

        Args:
            identifier: Of the job.
            new_events: Types and data.
            may_wait: Whether the job may also be queued: they are then about the job, not from it.
        """
        if not new_events:
            return []
        with self.transaction(is_durable=False) as connection:
            first = reserve_events(connection, identifier, new_events, may_wait=may_wait)
            return [] if first is None else append_events(connection, identifier, first, new_events)

    def set_controls(self, identifier: str, changes: Mapping[str, Any]) -> list[LoggedEvent]:
        """Set controls of a job that waits or runs; return the event, none if it has ended."""
        with self.transaction(is_durable=False) as connection:
            return set_controls(connection, identifier, changes)

    def _end_without_result(
        self,
        identifier: str,
        event: JobEvent,
        error: WayproofError,
        only: JobState | None = None,
    ) -> Transition | None:
        failure = failure_of(error)
        change = Change(event, data={"failure": failure}, only=only)
        with self.transaction(is_durable=True) as connection:
            transition = self._apply(connection, identifier, change)
            if transition is not None:
                kept = without(failure, outline_of(transition.columns["task"]).failure)
                _end(connection, identifier, "failure", encode(failure), encode(kept))
            return transition

    def _apply(self, connection: Connection, identifier: str, change: Change) -> Transition | None:
        """Make a change as `apply_change` does, and tell `on_event`."""
        transition = apply_change(connection, identifier, change)
        if transition is not None and self.on_event is not None:
            self.on_event(connection, transition.event)
        return transition


def _end(connection: Connection, identifier: str, part: str, whole: str, short: str) -> None:
    """Write how a job ended (JSON), whole and as lists show it."""
    _END[bodies, part](connection, job_id=identifier, new=whole)
    _END[summaries, part](connection, job_id=identifier, new=short)
