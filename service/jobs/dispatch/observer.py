"""Observer: hears of what a dispatcher does, to count it."""

from service.jobs.job import JobSummary


class Observer:
    """Counts nothing; subclasses do. Its methods are called in the event loop, and are quick."""

    def note_assignment(self, queue: str, waited: float, *, was_warm: bool | None) -> None:
        """Note that what waited in a queue has a worker.

        Args:
            queue: Its name.
            waited: How long [s].
            was_warm: Whether the worker has its scene loaded; None if it is about none.
        """

    def note_crash(self, queue: str, reason: str) -> None:
        """Note that a worker has died under a run.

        Args:
            queue: Of the job or the call.
            reason: The name of a signal, `exit`, `silence` or `memory`.
        """

    def note_end(self, job: JobSummary) -> None:
        """Note that a job has ended here."""
