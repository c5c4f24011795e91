"""JobReads: what is asked of the record of jobs. No method of it waits for who writes."""

from collections.abc import Mapping

from sqlalchemy import Engine, bindparam, select

from service.jobs import reading
from service.jobs.enrolling import find_by_idempotency_key
from service.jobs.errors import UnknownJob
from service.jobs.event_bus import EventBatch
from service.jobs.states import JobState
from service.jobs.tables import Job, JobSpec, JobSummary, JobText, LoggedEvent, jobs

_STRETCH = 500
_STATE = select(jobs.c.state).where(jobs.c.id == bindparam("job_id"))


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

    def get(self, identifier: str) -> Job:
        """Return a job.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return reading.job(connection, identifier)

    def text(self, identifier: str) -> JobText:
        """Return a job as lists have it, with its whole result as text.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return reading.job_text(connection, identifier)

    def summary(self, identifier: str) -> JobSummary:
        """Return a job as lists have it.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return reading.brief(connection, identifier)

    def page(
        self,
        queue: str,
        wanted: Mapping[str, str | None] | None = None,
        *,
        before: int | None = None,
        limit: int = 50,
    ) -> list[JobSummary]:
        """Return jobs of a queue, newest first, with a sequence below `before`.

        Nothing large is read.

        Args:
            queue: Of the jobs.
            wanted: What columns of theirs hold, by name; None for whatever.
            before: A serial.
            limit: At most so many.
        """
        with self._engine.connect() as connection:
            return reading.page(connection, {"queue": queue, **(wanted or {})}, before, limit)

    def unfinished(self) -> list[Job]:
        """Return every job that is queued or running, oldest first."""
        with self._engine.connect() as connection:
            return reading.unfinished(connection)

    def counts(self) -> dict[tuple[str, str], int]:
        """Return how many jobs there are by queue and state."""
        with self._engine.connect() as connection:
            return reading.counts(connection)

    def events(self, identifier: str, after: int = 0) -> list[LoggedEvent]:
        """Return a job's events with numbers above `after`, in order."""
        with self._engine.connect() as connection:
            return reading.events_after(connection, identifier, after, None)

    def events_after(self, identifier: str, after: int) -> EventBatch[LoggedEvent]:
        """Return some of the events above a number, and whether the job had ended before.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            state = connection.execute(_STATE, {"job_id": identifier}).scalar_one_or_none()
            if state is None:
                raise UnknownJob.of(identifier)
            found = reading.events_after(connection, identifier, after, _STRETCH)
            return EventBatch(found, JobState(state).is_final)

    def last_event(self, identifier: str, type_: str) -> LoggedEvent | None:
        """Return the newest event of a type, if there is one."""
        with self._engine.connect() as connection:
            return reading.last_event(connection, identifier, type_)
