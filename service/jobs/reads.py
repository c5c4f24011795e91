"""JobReads: what is asked of the record of jobs. No method of it waits for who writes."""

from collections.abc import Mapping

from sqlalchemy import Engine, bindparam, select

from service.events.bus import Stretch
from service.jobs import reading
from service.jobs.enrolling import job_by_key
from service.jobs.errors import UnknownJob
from service.jobs.records import Job, JobBrief, JobSpec, JobText, LoggedEvent, jobs
from service.jobs.states import JobState

_STRETCH = 500
_STATE = select(jobs.c.state).where(jobs.c.id == bindparam("job_id"))


class JobReads:
    """Jobs and their events as a database has them; from any thread."""

    def __init__(self, engine: Engine) -> None:
        """Read what is in `engine`."""
        self._engine = engine

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
            return reading.job(connection, identifier)

    def text(self, identifier: str) -> JobText:
        """Return a job as lists have it, with its whole result as text.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return reading.job_text(connection, identifier)

    def brief(self, identifier: str) -> JobBrief:
        """Return a job as lists have it.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return reading.brief(connection, identifier)

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
            state = connection.execute(_STATE, {"job_id": identifier}).scalar_one_or_none()
            if state is None:
                raise UnknownJob.of(identifier)
            found = reading.events_after(connection, identifier, after, _STRETCH)
            return Stretch(found, JobState(state).is_final)

    def last_event(self, identifier: str, type_: str) -> LoggedEvent | None:
        """Return the newest event of a type, if there is one."""
        with self._engine.connect() as connection:
            return reading.last_event(connection, identifier, type_)
