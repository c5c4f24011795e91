"""JobQueries: reads the record of jobs; no query waits for what writes."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    ColumnElement,
    Connection,
    Engine,
    Row,
    Select,
    Table,
    Text,
    bindparam,
    func,
    select,
    type_coerce,
)

from service.jobs.errors import IdempotencyConflict, UnknownJob
from service.jobs.event_bus import EventBatch
from service.jobs.job import (
    BatchMember,
    BatchSummary,
    Job,
    JobSpec,
    JobSummary,
    JobText,
    LoggedEvent,
)
from service.jobs.json_steps import decode
from service.jobs.json_text import Encoded
from service.jobs.states import JobState
from service.jobs.store.batches import read_batches
from service.jobs.store.entries import WAITS_FOR_ROBOTS, Entries, read_entries
from service.jobs.store.sql.tables import bodies, events, job_robots, jobs, makers, summaries

_EVENTS_AT_ONCE = 500
_INSTANTS = {"created_at", "started_at", "finished_at", "cancel_requested_at"}


def _jobs_with(content: Table) -> Select[Any]:
    columns = (content.c.payload, content.c.result, content.c.failure, makers.c.made_by)
    joined = select(jobs, *columns).join(content, content.c.job == jobs.c.id)
    return joined.join(makers, makers.c.job == jobs.c.id, isouter=True)


_WHOLE, _SUMMARY = _jobs_with(bodies), _jobs_with(summaries)
# Queries are built once: that takes longer than to carry them out.
_OF_ID = jobs.c.id == bindparam("job_id")
_ONE_WHOLE, _ONE_SUMMARY = _WHOLE.where(_OF_ID), _SUMMARY.where(_OF_ID)
_RESULT_TEXT = type_coerce(bodies.c.result, Text).label("text")
_ONE_TEXT = _ONE_SUMMARY.add_columns(_RESULT_TEXT).join(bodies, bodies.c.job == jobs.c.id)
_ONE_WHOLE_TEXT = _ONE_WHOLE.with_only_columns(
    *(column for column in _ONE_WHOLE.selected_columns if column is not bodies.c.result),
    _RESULT_TEXT,
)
_STATE = select(jobs.c.state).where(_OF_ID)
_OF_JOB = select(events).where(events.c.job == bindparam("job_id"))
_AFTER = _OF_JOB.where(events.c.number > bindparam("after")).order_by(events.c.number)
_OF_TYPE = _OF_JOB.where(events.c.type == bindparam("of_type"))
_NEWEST = _OF_TYPE.order_by(events.c.number.desc()).limit(1)

_OPEN = [state.value for state in JobState if not state.is_final]
# By its index: it is asked again and again.
_WAITING = _SUMMARY.where(
    jobs.c.id.in_(select(job_robots.c.job).where(job_robots.c.is_waiting)),
    jobs.c.state == JobState.QUEUED.value,
).order_by(jobs.c.sequence)
_MARKS = select(jobs.c.id, jobs.c.state, jobs.c.is_cancel_requested).order_by(jobs.c.sequence)


@dataclass(frozen=True)
class JobMark:
    """Where a job is, by its table."""

    id: str
    state: JobState
    is_cancel_requested: bool


class JobQueries:
    """Jobs and their events as a database has them; from any thread."""

    def __init__(self, engine: Engine) -> None:
        """Read what is in `engine`."""
        self._engine = engine

    def find_by_key(self, queue: str, key: str, request_digest: str) -> Job | None:
        """Return the job that an idempotency key names, if there is one.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        spec = JobSpec(queue, "", {}, key=key, request_digest=request_digest)
        with self._engine.connect() as connection:
            return find_by_idempotency_key(connection, spec)

    def get(self, identifier: str, read_result: Callable[[str], Any] = decode) -> Job:
        """Return a job, with its result as it is read from its text.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            columns = _one(connection, _ONE_WHOLE_TEXT, identifier)
        text = columns.pop("text")
        return job_of({**columns, "result": None if text is None else read_result(text)})

    def text(self, identifier: str) -> JobText:
        """Return a job as lists have it, with its whole result as text; raises as `get`."""
        with self._engine.connect() as connection:
            columns = _one(connection, _ONE_TEXT, identifier)
        text = columns.pop("text")
        return JobText(summary_of(columns), None if text is None else Encoded(text))

    def summary(self, identifier: str) -> JobSummary:
        """Return a job as lists have it; raises as `get`."""
        with self._engine.connect() as connection:
            return summary_of(_one(connection, _ONE_SUMMARY, identifier))

    def page(
        self,
        queue: str,
        wanted: Mapping[str, str | None] | None = None,
        *,
        before: int | None = None,
        limit: int = 50,
    ) -> list[JobSummary]:
        """Return jobs of a queue, newest first; nothing large is read.

        Args:
            queue: Of the jobs.
            wanted: What fields of theirs hold, by name; None for whatever.
            before: Their sequence numbers are below it.
            limit: Largest number of jobs.
        """
        query = _SUMMARY
        for name, content in {"queue": queue, **(wanted or {})}.items():
            query = query if content is None else query.where(jobs.c[name] == content)
        query = query if before is None else query.where(jobs.c.sequence < before)
        with self._engine.connect() as connection:
            rows = connection.execute(query.order_by(jobs.c.sequence.desc()).limit(limit))
            return [summary_of(columns_of(row)) for row in rows]

    def members_of(self, batch: str) -> list[BatchMember]:
        """Return the jobs of a batch in the order in which they were asked for."""
        columns = (jobs.c.id, jobs.c.state, jobs.c.created_at, jobs.c.finished_at)
        query = select(*columns).where(jobs.c.batch == batch).order_by(jobs.c.sequence)
        with self._engine.connect() as connection:
            rows = connection.execute(query)
            return [BatchMember(**with_values({**row})) for row in rows.mappings()]

    def batches(
        self,
        queue: str,
        wanted: Mapping[str, str | None],
        *,
        before: int | None = None,
        limit: int = 50,
    ) -> list[BatchSummary]:
        """Return batches of jobs, newest first; the jobs themselves are not read.

        Args:
            queue: Of their jobs.
            wanted: What fields of one of their jobs hold, by name; None for whatever.
            before: The sequence numbers of their first jobs are below it.
            limit: Largest number of batches.
        """
        with self._engine.connect() as connection:
            return read_batches(connection, queue, wanted, before=before, limit=limit)

    def unfinished(self) -> list[Job]:
        """Return every job that is queued or running, and waits for no robot, oldest first."""
        with self._engine.connect() as connection:
            return _jobs_where(connection, jobs.c.state.in_(_OPEN) & ~WAITS_FOR_ROBOTS)

    def entries(self, queue: str, scene: str) -> Entries:
        """Return which jobs of a queue move robots in a scene, or wait to."""
        with self._engine.connect() as connection:
            return read_entries(connection, queue, scene)

    def waiting_for_robots(self) -> list[JobSummary]:
        """Return the jobs that wait for their robots, oldest first."""
        with self._engine.connect() as connection:
            rows = connection.execute(_WAITING)
            return [summary_of(columns_of(row)) for row in rows]

    def counts(self) -> dict[tuple[str, str], int]:
        """Return how many jobs there are by queue and state."""
        query = select(jobs.c.queue, jobs.c.state, func.count()).group_by(
            jobs.c.queue, jobs.c.state
        )
        with self._engine.connect() as connection:
            return {(queue, state): number for queue, state, number in connection.execute(query)}

    def events(self, identifier: str, after: int = 0) -> list[LoggedEvent]:
        """Return a job's events with numbers above `after`, in order."""
        with self._engine.connect() as connection:
            return _events_after(connection, identifier, after, None)

    def events_after(self, identifier: str, after: int) -> EventBatch[LoggedEvent]:
        """Return some of the events above a number, and whether the job had ended before.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            state = connection.execute(_STATE, {"job_id": identifier}).scalar_one_or_none()
            if state is None:
                raise UnknownJob.of(identifier)
            found = _events_after(connection, identifier, after, _EVENTS_AT_ONCE)
            return EventBatch(found, JobState(state).is_final)

    def last_event(self, identifier: str, type_: str) -> LoggedEvent | None:
        """Return the newest event of a type, if there is one."""
        with self._engine.connect() as connection:
            return read_last_event(connection, identifier, type_)

    def marks(self, identifiers: Collection[str] | None = None) -> list[JobMark]:
        """Return where jobs are that wait for no robot; unknown ones are none.

        Args:
            identifiers: Of the jobs; None for all that are queued or running.
        """
        wanted = jobs.c.state.in_(_OPEN) if identifiers is None else jobs.c.id.in_(identifiers)
        with self._engine.connect() as connection:
            rows = connection.execute(_MARKS.where(wanted & ~WAITS_FOR_ROBOTS))
            return [JobMark(row.id, JobState(row.state), row.is_cancel_requested) for row in rows]

    def queued(self, identifiers: Collection[str]) -> list[Job]:
        """Return those of some jobs that are queued and wait for no robot, oldest first."""
        is_queued = (jobs.c.state == JobState.QUEUED.value) & ~WAITS_FOR_ROBOTS
        with self._engine.connect() as connection:
            return _jobs_where(connection, is_queued & jobs.c.id.in_(identifiers))


def find_by_idempotency_key(connection: Connection, spec: JobSpec | Job) -> Job | None:
    """Return the job that an idempotency key names, if there is one.

    Raises:
        IdempotencyConflict: The key was used for another request.
    """
    if spec.key is None:
        return None
    found = _jobs_where(connection, (jobs.c.queue == spec.queue) & (jobs.c.key == spec.key))
    if found and found[0].request_digest != spec.request_digest:
        raise IdempotencyConflict.of(spec.key, "job", found[0].id)
    return found[0] if found else None


def read_job(connection: Connection, identifier: str) -> Job:
    """Return a job.

    Raises:
        UnknownJob: There is none.
    """
    return job_of(_one(connection, _ONE_WHOLE, identifier))


def read_last_event(connection: Connection, identifier: str, type_: str) -> LoggedEvent | None:
    """Return the newest event of a type of a job, if there is one."""
    given = {"job_id": identifier, "of_type": type_}
    row = connection.execute(_NEWEST, given).first()
    return None if row is None else _event_of(row)


def now() -> str:
    """Return the time as it is recorded (ISO 8601, UTC)."""
    return datetime.now(UTC).isoformat()


def job_of(columns: Mapping[str, Any]) -> Job:
    """Return the job of the columns of its tables."""
    return Job(**with_values(columns))


def summary_of(columns: Mapping[str, Any]) -> JobSummary:
    """Return the job of the columns of its tables, as lists have it."""
    return JobSummary(**with_values(columns))


def columns_of(row: Row[Any]) -> dict[str, Any]:
    """Return the columns of a row by name."""
    return dict(row._mapping)  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]  (public)


def with_values(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return columns of a job with its state and its instants as values."""
    fields = dict(columns)
    for name in _INSTANTS & fields.keys():
        fields[name] = datetime.fromisoformat(fields[name]) if fields[name] else None
    fields["state"] = JobState(fields["state"])
    return fields


def _jobs_where(connection: Connection, condition: ColumnElement[bool]) -> list[Job]:
    rows = connection.execute(_WHOLE.where(condition).order_by(jobs.c.sequence))
    return [job_of(columns_of(row)) for row in rows]


def _one(connection: Connection, query: Select[Any], identifier: str) -> dict[str, Any]:
    row = connection.execute(query, {"job_id": identifier}).first()
    if row is None:
        raise UnknownJob.of(identifier)
    return columns_of(row)


def _event_of(row: Row[Any]) -> LoggedEvent:
    return LoggedEvent(row.job, row.number, row.type, row.data, row.at)


def _events_after(
    connection: Connection, identifier: str, after: int, limit: int | None
) -> list[LoggedEvent]:
    query = _AFTER if limit is None else _AFTER.limit(limit)
    rows = connection.execute(query, {"job_id": identifier, "after": after})
    return [_event_of(row) for row in rows]
