"""What can go wrong with jobs, whatever they do."""

from planning.errors import PlanningFailure, WayproofError

# The stage of failures that no stage of a task explains.
WORKER = "worker"
# When to ask again a server whose database does nothing [s].
RETRY_AFTER = 5


class QueueFull(WayproofError):
    """A queue has as many waiting jobs as it may; evidence: `queue`, `bound`, `retry_after` [s]."""

    code = "queue_full"

    @classmethod
    def of(
        cls, queue: str, waiting: int, bound: int, retry_after: float, more: int = 1
    ) -> "QueueFull":
        """Build the error for a queue without room.

        Args:
            queue: Its name.
            waiting: Number of jobs that wait.
            bound: Largest number of jobs that may wait.
            retry_after: When to ask again [s].
            more: Number of jobs that were to be added.
        """
        asked = "" if more == 1 else f", and {more} more would be too many"
        message = f"{waiting} jobs wait for {queue} already{asked}; try again later"
        evidence = {"queue": queue, "queued": waiting, "bound": bound, "retry_after": retry_after}
        return cls(message, evidence)


class QueueTimeout(WayproofError):
    """No worker was free in time; evidence: `queue`, `waited` [s], `queued`, `retry_after` [s]."""

    code = "queue_timeout"


class IdempotencyConflict(WayproofError):
    """An idempotency key came again with another request.

    Evidence: `key`, and what it made: `job`, `scene`, `batch` or `webhook`.
    """

    code = "idempotency_conflict"

    @classmethod
    def of(cls, key: str, kind: str, identifier: str) -> "IdempotencyConflict":
        """Build the error for a key and what it made."""
        message = f"the idempotency key {key!r} was used for another request: {identifier}"
        return cls(message, {"key": key, kind: identifier})


class Overtaken(Exception):
    """Another job has entered the scene since the request looked, or has a robot: ask again."""


class UnknownJob(WayproofError):
    """There is no such job; evidence: `id`."""

    code = "unknown_job"

    @classmethod
    def of(cls, identifier: str) -> "UnknownJob":
        """Build the error for an id."""
        shown = identifier[:80]
        return cls(f"there is no job {shown!r}", {"id": shown})


class JobInUse(WayproofError):
    """A job that has not ended names this one; evidence: `id`, `used_by`."""

    code = "resource_in_use"

    @classmethod
    def of(cls, identifier: str, user: str) -> "JobInUse":
        """Build the error for a job and the one that names it."""
        message = f"{user} has not ended, and was asked to use {identifier}"
        return cls(message, {"id": identifier, "used_by": user})


class DatabaseInUse(WayproofError):
    """Another dispatcher works on this database; evidence: `database`."""

    code = "database_in_use"


class DatabaseTaken(WayproofError):
    """Another server has taken the database over; evidence: `epoch`, `latest`."""

    code = "database_taken"


class DatabaseTooNew(WayproofError):
    """A newer version has changed the database; evidence: `revision`, `newest` known here."""

    code = "database_too_new"

    @classmethod
    def of(cls, revision: str, newest: str) -> "DatabaseTooNew":
        """Build the error for the revision of a database and the newest that is known."""
        message = f"a newer version of the server has changed the database (revision {revision}; "
        message += f"this one knows up to {newest}): use that version, or restore a backup"
        return cls(message, {"revision": revision, "newest": newest})


class DatabaseUnrecognized(WayproofError):
    """The database has tables that are not this program's; evidence: `table`, `missing`."""

    code = "database_unrecognized"

    @classmethod
    def of(cls, table: str, missing: list[str]) -> "DatabaseUnrecognized":
        """Build the error for a table that lacks columns."""
        message = f"the table {table!r} of the database is not one of this program, or of a version"
        message += f" too old to be read: it has no columns {missing}"
        return cls(message, {"table": table, "missing": missing})


class DatabaseUnavailable(WayproofError):
    """The database does not answer, or takes nothing; evidence: `reason`, `retry_after` [s]."""

    code = "database_unavailable"

    @classmethod
    def of(cls, seconds: float) -> "DatabaseUnavailable":
        """Build the error for what was not written within some seconds."""
        message = f"the database is full, locked or away: nothing was written within {seconds:g} s"
        return cls(message, {"reason": "timeout", "retry_after": RETRY_AFTER})


class WorkerCrashed(PlanningFailure):
    """The worker process died under the job, every time.

    Evidence: `attempts`, `exit_code` (negative: by that signal), `signal` (its name), `reason`.
    """

    code = "worker_crashed"
    stage = WORKER


class WorkerUnresponsive(PlanningFailure):
    """The worker process said nothing for too long, and was ended; evidence: `silence` [s]."""

    code = "worker_unresponsive"
    stage = WORKER


class HostLost(PlanningFailure):
    """The machine that the job ran on was lost, and it may not run again, or it was lost too often.

    Evidence: `attempts`, `host`.
    """

    code = "host_lost"
    stage = WORKER


class MemoryLimitExceeded(PlanningFailure):
    """The job needs more memory than a worker may use; evidence: `used`, `bound` [bytes]."""

    code = "memory_limit_exceeded"
    stage = "worker"


class ServerRestarted(PlanningFailure):
    """The server ended while the job ran, and it may not run again; evidence: `attempts`."""

    code = "server_restarted"
    stage = WORKER


class InternalError(PlanningFailure):
    """The task raised what it should not; evidence: `exception`, `reference` in the log."""

    code = "internal_error"
    stage = WORKER
