"""JobRelease: jobs that have waited for their robots are run, or refused."""

from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any

from planning.errors import WayproofError
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.job import Job, JobSpec, JobSummary
from service.jobs.store.release import release
from service.jobs.store.sql.database import ask


class JobRelease:
    """Releases jobs that wait for their robots; of a leader alone."""

    def __init__(
        self,
        recorder: JobRecorder,
        take_up: Callable[[Job], Coroutine[Any, Any, None]],
        note: Callable[[list[str]], None],
    ) -> None:
        """Put the parts together.

        Args:
            recorder: Writes jobs.
            take_up: Runs a job of the table.
            note: Has what looks at the table for other servers do so.
        """
        self._recorder = recorder
        self._take_up = take_up
        self._note = note

    async def jobs(self) -> list[JobSummary]:
        """Return the jobs that wait for their robots, oldest first."""
        return await ask(self._recorder.store.waiting_for_robots)

    async def release(self, identifier: str, spec: JobSpec) -> Job | None:
        """Run a job that waits for its robots, and return it; None if it has ended.

        Raises:
            Overtaken: Another job has entered the scene, or is before it.
        """
        store = self._recorder.store
        job = await self._recorder.write(partial(release, store, identifier, spec))
        if job is None:
            return None
        if store.is_shared:  # what looks at the table might find it, too: one of them runs it
            self._note([identifier])
        else:
            await self._take_up(job)
        return job

    async def refuse(self, identifier: str, error: WayproofError) -> None:
        """End a job that waits for its robots, with the reason."""
        ended = await self._recorder.write(partial(self._recorder.store.fail, identifier, error))
        if ended is not None:
            self._recorder.publish(identifier, [ended.event])
