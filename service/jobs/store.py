"""JobStore: the system of record. States change by compare-and-set, final ones are written once.

Every writing transaction begins with an update or insert, which locks what it changes, so nothing
is decided on what another has changed meanwhile; the statements are the same on every database.
"""

import threading
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from sqlalchemy import Connection, Engine, delete, insert, select, update

from planning.errors import Canceled, WayproofError
from service.events.bus import Stretch
from service.jobs import reading
from service.jobs.briefs import fill_briefs
from service.jobs.database import set_durability
from service.jobs.enrolling import job_by_key, queued_row
from service.jobs.errors import DatabaseTaken, UnknownJob
from service.jobs.json_text import Encoded
from service.jobs.moving import Moved, log, move
from service.jobs.outcome import failure_of
from service.jobs.outline import outline_of, without
from service.jobs.reading import decoded, now
from service.jobs.records import (
    Job,
    JobBrief,
    JobSpec,
    LoggedEvent,
    bodies,
    briefs,
    jobs,
    makers,
    metadata,
    owner,
)
from service.jobs.states import JobEvent, JobState

_STRETCH = 500
_OPEN = [state.value for state in JobState if not state.is_final]


class JobStore:
    """Jobs and their events in a database; every method is one transaction, from any thread."""

    def __init__(self, engine: Engine, versions: Mapping[str, str] | None = None) -> None:
        """Keep jobs in `engine`; call `open` before use.

        Args:
            engine: Where.
            versions: Of what runs them, by name.
        """
        self._engine = engine
        self._versions = dict(versions or {})
        self._epoch: int | None = None
        self._lock = threading.RLock()
        self._joined: Connection | None = None

    def open(self) -> None:
        """Create the tables that are missing, and what an older version did not write of jobs."""
        metadata.create_all(self._engine)
        fill_briefs(self._engine)

    @property
    def may_crash_alone(self) -> bool:
        """Whether the database may die while we live: then it forgets what was not durable."""
        return self._engine.dialect.name != "sqlite"

    def fence(self, epoch: int) -> None:
        """Write only as long as the owner of the database is the one of an epoch."""
        self._epoch = epoch

    @contextmanager
    def transaction(self, *, is_durable: bool) -> Generator[Connection]:
        """Make what this thread writes meanwhile one transaction.

        Args:
            is_durable: Whether it must survive a power cut. The death of the server it survives
                in any case.

        Raises:
            DatabaseTaken: The database has another owner; nothing was written.
        """
        with self._lock:
            if self._joined is not None:
                yield self._joined
                return
            with self._engine.connect() as connection:
                set_durability(connection, is_durable=is_durable)
                self._joined = connection
                try:
                    yield connection
                    self._require_ownership(connection)
                    connection.commit()
                finally:
                    self._joined = None

    def insert(self, spec: JobSpec) -> tuple[Job, bool]:
        """Return a new queued job and True, or the one that the idempotency key names and False.

        Raises:
            IdempotencyConflict: The key was used for another request.
            TypeError: The payload is not JSON-compatible.
        """
        row = queued_row(spec)
        with self.transaction(is_durable=True) as connection:
            known = job_by_key(connection, spec)
            if known is not None:
                return known, False
            connection.execute(insert(jobs).values(row))
            connection.execute(insert(bodies).values(job=row["id"], payload=spec.payload))
            payload = without(spec.payload, outline_of(spec.task).payload)
            connection.execute(insert(briefs).values(job=row["id"], payload=payload))
            log(connection, row["id"], 1, [("queued", Encoded("{}"))])
            return self._get(connection, row["id"]), True

    def known(self, lane: str, key: str, request_digest: str) -> Job | None:
        """Return the job that an idempotency key names, if there is one.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        spec = JobSpec(lane, "", {}, key=key, request_digest=request_digest)
        with self._engine.connect() as connection:
            return job_by_key(connection, spec)

    def get(self, identifier: str) -> Job:
        """Return a job.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return self._get(connection, identifier)

    def page(
        self,
        lane: str,
        wanted: Mapping[str, str | None] | None = None,
        *,
        before: int | None = None,
        limit: int = 50,
    ) -> list[JobBrief]:
        """Return jobs of a lane, newest first, with a serial below `before`; nothing large is read.

        Args:
            lane: Of the jobs.
            wanted: What columns of theirs hold, by name; None for whatever.
            before: A serial.
            limit: At most so many.
        """
        with self._engine.connect() as connection:
            return reading.page(connection, {"lane": lane, **(wanted or {})}, before, limit)

    def unfinished(self) -> list[Job]:
        """Return every job that is queued or running, oldest first."""
        with self._engine.connect() as connection:
            return reading.unfinished(connection)

    def counts(self) -> dict[tuple[str, str], int]:
        """Return how many jobs there are by lane and state."""
        with self._engine.connect() as connection:
            return reading.counts(connection)

    def start(self, identifier: str) -> Moved | None:
        """Let a queued job run; None if it is not queued any more. So for the other moves."""
        changes = {"started_at": now(), "attempts": jobs.c.attempts + 1}
        with self.transaction(is_durable=False) as connection:
            moved = move(connection, identifier, JobEvent.START, changes, {})
            if moved is not None:
                connection.execute(delete(makers).where(makers.c.job == identifier))
                made_by = insert(makers).values(job=identifier, made_by=self._versions)
                connection.execute(made_by)
            return moved

    def requeue(self, identifier: str, reason: str, *, refund: int = 0) -> Moved | None:
        """Queue a running job again.

        Args:
            identifier: Of the job.
            reason: For people.
            refund: How many attempts do not count.
        """
        changes = {"attempts": jobs.c.attempts - refund}
        with self.transaction(is_durable=False) as connection:
            return move(connection, identifier, JobEvent.REQUEUE, changes, {"reason": reason})

    def succeed(
        self, identifier: str, result: Encoded, brief: Encoded | None = None
    ) -> Moved | None:
        """End a running job with its result.

        Args:
            identifier: Of the job.
            result: Whole.
            brief: What lists show of it; None for all.
        """
        with self.transaction(is_durable=True) as connection:
            moved = move(connection, identifier, JobEvent.SUCCEED, {"progress": 1.0}, {})
            if moved is not None:
                body = update(bodies).where(bodies.c.job == identifier)
                connection.execute(body.values(result=result))
                short = update(briefs).where(briefs.c.job == identifier)
                connection.execute(short.values(result=brief or result))
            return moved

    def fail(self, identifier: str, error: WayproofError) -> Moved | None:
        """End a job with the reason why it has no result."""
        return self._give_up(identifier, JobEvent.FAIL, error)

    def cancel(self, identifier: str, error: Canceled) -> Moved | None:
        """End a running job because somebody asked for it."""
        return self._give_up(identifier, JobEvent.CANCEL, error)

    def cancel_queued(self, identifier: str, error: Canceled) -> Moved | None:
        """End a job because somebody asked for it, if it is still queued."""
        return self._give_up(identifier, JobEvent.CANCEL, error, only=JobState.QUEUED)

    def request_cancel(self, identifier: str) -> Job:
        """Note that somebody wants the end of a job that has not ended, and return it.

        Raises:
            UnknownJob: There is none.
        """
        is_open = jobs.c.state.in_(_OPEN)
        with self.transaction(is_durable=True) as connection:
            statement = update(jobs).where(jobs.c.id == identifier, is_open)
            connection.execute(statement.values(is_cancel_requested=True))
            return self._get(connection, identifier)

    def record(
        self, identifier: str, told: Sequence[tuple[str, Encoded]], *, may_wait: bool = False
    ) -> list[LoggedEvent]:
        """Append what a running job says, and return it; nothing if the job has ended meanwhile.

        The last `stage` and `progress` in the data become the job's.

        Args:
            identifier: Of the job.
            told: Types and data.
            may_wait: Whether the job may also be queued: it is then said of the job, not by it.
        """
        if not told:
            return []
        changes: dict[str, Any] = {"num_events": jobs.c.num_events + len(told)}
        for _, data in told:
            changes |= reading.progress_in(decoded(data))
        states = _OPEN if may_wait else [JobState.RUNNING.value]
        is_open = (jobs.c.id == identifier) & jobs.c.state.in_(states)
        with self.transaction(is_durable=False) as connection:
            statement = update(jobs).where(is_open).values(changes)
            row = connection.execute(statement.returning(jobs.c.num_events)).first()
            if row is None:
                return []
            return log(connection, identifier, row.num_events - len(told) + 1, told)

    def events(self, identifier: str, after: int = 0) -> list[LoggedEvent]:
        """Return a job's events with numbers above `after`, in order."""
        with self._engine.connect() as connection:
            return reading.events_after(connection, identifier, after, None)

    def stretch(self, identifier: str, after: int) -> Stretch[LoggedEvent]:
        """Return some of the events above a number, and whether the job had ended before.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            query = select(jobs.c.state).where(jobs.c.id == identifier)
            state = connection.execute(query).scalar_one_or_none()
            if state is None:
                raise UnknownJob.of(identifier)
            found = reading.events_after(connection, identifier, after, _STRETCH)
            return Stretch(found, JobState(state).is_final)

    def last_event(self, identifier: str, type_: str) -> LoggedEvent | None:
        """Return the newest event of a type, if there is one."""
        with self._engine.connect() as connection:
            return reading.last_event(connection, identifier, type_)

    def _give_up(
        self,
        identifier: str,
        happened: JobEvent,
        error: WayproofError,
        only: JobState | None = None,
    ) -> Moved | None:
        failure = failure_of(error)
        with self.transaction(is_durable=True) as connection:
            moved = move(connection, identifier, happened, {}, {"failure": failure}, only)
            if moved is not None:
                body = update(bodies).where(bodies.c.job == identifier)
                connection.execute(body.values(failure=failure))
                task = connection.execute(select(jobs.c.task).where(jobs.c.id == identifier))
                kept = without(failure, outline_of(task.scalar_one()).failure)
                short = update(briefs).where(briefs.c.job == identifier)
                connection.execute(short.values(failure=kept))
            return moved

    def _require_ownership(self, connection: Connection) -> None:
        """Go on to the commit only if no other server has taken the database; it cannot before it.

        Raises:
            DatabaseTaken: One has.
        """
        if self._epoch is None:
            return
        query = select(owner.c.epoch).with_for_update(read=True)
        latest = connection.execute(query).scalar_one_or_none()
        if latest != self._epoch:
            message = "another server has taken the database over: nothing is written to it here"
            raise DatabaseTaken(message, {"epoch": self._epoch, "latest": latest})

    def _get(self, connection: Connection, identifier: str) -> Job:
        found = reading.jobs_where(connection, jobs.c.id == identifier)
        if not found:
            raise UnknownJob.of(identifier)
        return found[0]
