"""Conclusion: what has to be done about a job that has come to its end, before that is recorded."""

from collections.abc import Callable
from typing import Any, Protocol

from service.jobs.job import Job
from service.jobs.json_text import Encoded

# Returns the data of the last event of a type; None without one.
type LastEvent = Callable[[str], dict[str, Any] | None]


class Conclusion(Protocol):
    """What is done about jobs at their ends; of those that it concerns, all events are recorded."""

    def concerns(self, job: Job, last: LastEvent) -> bool:
        """Return whether there is something to do.

        Args:
            job: That is at its end.
            last: Its last events.
        """
        ...

    async def conclude(self, job: Job, last: LastEvent, *, has_succeeded: bool) -> None:
        """Do it. What it raises is the failure of a job whose task has succeeded."""
        ...

    async def recovered(self, job: Job, last: LastEvent) -> Encoded | None:
        """Do it for a job that a server has left, however much of it that server had done.

        Returns:
            The result of a task that had succeeded; None for one that had not.

        Raises:
            WayproofError: It had succeeded, and it cannot be done: that is the job's failure.
        """
        ...


class NoConclusion:
    """There is nothing to do."""

    def concerns(self, job: Job, last: LastEvent) -> bool:
        """Return that there is nothing to do."""
        del job, last
        return False

    async def conclude(self, job: Job, last: LastEvent, *, has_succeeded: bool) -> None:
        """Do nothing."""

    async def recovered(self, job: Job, last: LastEvent) -> Encoded | None:
        """Return that nothing is known."""
