"""JobWaits: waits for the ends of jobs, which all end when the server begins to end."""

import asyncio
from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing, asynccontextmanager

from service.jobs.attempt import Attempt
from service.jobs.event_bus import EventBus
from service.jobs.job import Job, JobText, LoggedEvent
from service.jobs.json_steps import STEP, decode
from service.jobs.queries import JobQueries


class WaitLimits:
    """Who waits through it is never cut off without an answer by the end of the server."""

    def __init__(self) -> None:
        """Begin with none."""
        self._limits: set[asyncio.Timeout] = set()
        self._is_over = False

    @asynccontextmanager
    async def limit(self, seconds: float) -> AsyncGenerator[None]:
        """End what is awaited within after so many seconds, or when the server begins to end."""
        try:
            async with asyncio.timeout(0.0 if self._is_over else seconds) as limit:
                self._limits.add(limit)
                try:
                    yield
                finally:
                    self._limits.discard(limit)
        except TimeoutError:
            pass

    def end(self) -> None:
        """End all waits, those to come as well."""
        self._is_over = True
        now = asyncio.get_running_loop().time()
        for limit in self._limits:
            if not limit.expired():
                limit.reschedule(now)


# No stream is longer; it also fits into every database's integers.
END_OF_STREAM = 2**31 - 1


class JobWaits:
    """Waits for the jobs of a dispatcher, from its event loop."""

    def __init__(
        self, runs: Mapping[str, Attempt], bus: EventBus[LoggedEvent], store: JobQueries
    ) -> None:
        """Wait for the runs that there are, by the ids of their jobs, and for what `store` has."""
        self._attempts = runs
        self._bus = bus
        self._store = store
        self._limits = WaitLimits()

    async def whole(self, identifier: str, seconds: float) -> Job:
        """Return a job when it has ended, or as it is after so many seconds.

        Raises:
            UnknownJob: There is none.
        """
        run = await self._until_ended(identifier, seconds)
        if run is not None and run.ended is not None:
            return await _whole(run.ended)
        return await asyncio.to_thread(self._store.get, identifier)

    async def text(self, identifier: str, seconds: float) -> JobText:
        """Return a job as `whole` does, but for its result, which stays text.

        Raises:
            UnknownJob: There is none.
        """
        run = await self._until_ended(identifier, seconds)
        if run is not None and run.ended is not None:
            return run.ended
        return await asyncio.to_thread(self._store.text, identifier)

    def end(self) -> None:
        """Answer who waits at once with the job as it is, and who comes later as well."""
        self._limits.end()

    async def _until_ended(self, identifier: str, seconds: float) -> Attempt | None:
        """Wait until a job has ended, at most so long; return its last run, if it was here."""
        run = self._attempts.get(identifier)
        if run is not None and run.ended is not None:
            return run
        # One that is not here has ended, or is being taken up again: the log knows.
        wait = self._drained(identifier) if run is None else self._bus.until_over(identifier)
        async with self._limits.limit(seconds):
            await wait
        return self._attempts.get(identifier, run)

    async def _drained(self, identifier: str) -> None:
        async with aclosing(self._bus.follow(identifier, END_OF_STREAM)) as nothing:
            async for _ in nothing:
                pass


async def _whole(ended: JobText) -> Job:
    """Return a job with its result, which is decoded."""
    text = "null" if ended.result is None else ended.result.text
    is_small = len(text) <= STEP
    result = decode(text) if is_small else await asyncio.to_thread(decode, text)
    return Job(**{**vars(ended.summary), "result": result})
