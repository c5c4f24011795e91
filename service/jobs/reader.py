"""JobReader: reads what is recorded of jobs; whichever server runs them."""

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from functools import partial
from typing import Any

from anyio import to_thread

from service.errors import UnknownResource
from service.jobs.artifacts import Artifact
from service.jobs.errors import UnknownJob
from service.jobs.job import (
    BatchMember,
    BatchPage,
    Job,
    JobPage,
    JobSpec,
    JobSummary,
    JobText,
    LoggedEvent,
)
from service.jobs.json_steps import decode
from service.jobs.store.entries import Entries
from service.jobs.store.job_store import JobStore
from service.jobs.task import artifacts_of

_CHUNK = 20


class JobReader:
    """Reads jobs, lists of them, and the artifacts that they use.

    An id has the prefix of its queue, so that an id of another queue is unknown without a look.
    """

    def __init__(
        self, store: JobStore, *, prefixes: Mapping[str, str], queues: Sequence[str]
    ) -> None:
        """Read a record.

        Args:
            store: The record of jobs.
            prefixes: Of the ids of each queue's jobs.
            queues: The names of all queues, in the order in which they are counted.
        """
        self._store = store
        self._prefixes = prefixes
        self._queues = queues

    async def job(
        self, queue: str, identifier: str, read_result: Callable[[str], Any] = decode
    ) -> Job:
        """Return a job.

        Args:
            queue: Its queue.
            identifier: Its id.
            read_result: Returns its result from the text of that.

        Raises:
            UnknownResource: The queue has none of that id.
        """
        get = partial(self._store.get, read_result=read_result)
        return await self._read(queue, identifier, get)

    async def job_text(self, queue: str, identifier: str) -> JobText:
        """Return a job whose result is passed on as it is; raises as `job`."""
        return await self._read(queue, identifier, self._store.text)

    async def _read[T](self, queue: str, identifier: str, read: Callable[[str], T]) -> T:
        if not identifier.startswith(f"{self._prefixes[queue]}_"):
            raise UnknownResource.of(queue, identifier)
        try:
            return await to_thread.run_sync(read, identifier)
        except UnknownJob as fault:
            raise UnknownResource.of(queue, identifier) from fault

    async def find_by_key(self, spec: JobSpec) -> Job | None:
        """Return the job that the spec's idempotency key names, if there is one.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        if spec.key is None:
            return None
        request = (spec.queue, spec.key, spec.request_digest)
        return await to_thread.run_sync(self._store.find_by_key, *request)

    async def page(
        self,
        queue: str,
        limit: int,
        before: int | None,
        *,
        state: str | None = None,
        scene: str | None = None,
        batch: str | None = None,
    ) -> JobPage:
        """Return jobs of a queue, newest first, of those before a number of the list."""
        wanted = {"state": state, "scene": scene, "batch": batch}
        read = partial(self._store.page, queue, wanted, before=before, limit=limit + 1)
        return JobPage.of(await to_thread.run_sync(read), limit)

    async def newest(
        self, queue: str, *, scene: str | None = None, world_digest: str | None = None
    ) -> AsyncIterator[JobSummary]:
        """Yield the jobs of a queue in a scene, or with a scene's content, newest first."""
        wanted = {"scene": scene, "world_digest": world_digest}
        before: int | None = None
        limit = 1
        # Mostly the first one is enough.
        while True:
            read = partial(self._store.page, queue, wanted, before=before, limit=limit)
            found = await to_thread.run_sync(read)
            for job in found:
                yield job
            if len(found) < limit:
                return
            before, limit = found[-1].sequence, min(2 * limit, _CHUNK)

    async def members_of(self, batch: str) -> list[BatchMember]:
        """Return the jobs of a batch in the order in which they were asked for; none if unknown."""
        return await to_thread.run_sync(self._store.members_of, batch)

    async def batches(
        self, queue: str, limit: int, before: int | None, **wanted: str | None
    ) -> BatchPage:
        """Return batches, newest first, that have a job with what is wanted; else as `page`."""
        read = partial(self._store.batches, queue, wanted, before=before, limit=limit + 1)
        return BatchPage.of(await to_thread.run_sync(read), limit)

    async def entries(self, queue: str, scene: str) -> Entries:
        """Return which jobs of a queue move robots in a scene, or wait to."""
        return await to_thread.run_sync(self._store.entries, queue, scene)

    async def last_recorded(self, job: JobSummary, event_type: str) -> LoggedEvent | None:
        """Return the newest event of a type that is recorded, if there is one."""
        return await to_thread.run_sync(self._store.last_event, job.id, event_type)

    async def counts(self) -> dict[str, dict[str, int]]:
        """Return how many jobs there are, by state and queue."""
        found = await to_thread.run_sync(self._store.counts)
        counts: dict[str, dict[str, int]] = {
            state: dict.fromkeys(self._queues, 0)
            for state in ("queued", "running", "succeeded", "failed", "canceled")
        }
        for (queue, state), number in found.items():
            counts[state][queue] = number
        return counts

    async def artifacts_of(self, job: Job) -> Mapping[str, bytes]:
        """Return all artifacts that the task of a job reads, as far as they are stored."""
        read = artifacts_of(job.task, job.payload)
        parts = await self._store.artifacts.parts(read)
        wanted = {*read, *(part for needed in parts.values() for part in needed)}
        return await self._store.artifacts.contents(sorted(wanted))

    async def keep_artifact(self, artifact: Artifact, world_digest: str) -> str:
        """Store an artifact for as long as a job or a scene has a content; return its digest."""
        return await to_thread.run_sync(self._store.artifacts.keep, artifact, world_digest)
