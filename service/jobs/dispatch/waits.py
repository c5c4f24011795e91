"""JobWaits: waits for the ends of jobs, which all end when the server begins to end."""

import asyncio
from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing, asynccontextmanager

from service.jobs.dispatch.attempt import Attempt
from service.jobs.event_bus import EventBus
from service.jobs.job import Job, JobText, LoggedEvent
from service.jobs.json_steps import STEP, decode
from service.jobs.store.queries import JobQueries

# No stream is longer; it also fits into every database's integers.
END_OF_STREAM = 2**31 - 1


class WaitLimits:
    """Time limits of waits; the end of the server ends them all, so that each gets an answer."""

    def __init__(self) -> None:
        """Begin with none."""
        self._limits: set[asyncio.Timeout] = set()
        self._is_over = False

    @asynccontextmanager
    async def limit(self, seconds: float) -> AsyncGenerator[None]:
        """End what is awaited within after some seconds, or when the server begins to end."""
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


class JobWaits:
    """Waits for the jobs of a dispatcher, from its event loop.

    What runs here is waited for in memory; the log knows the rest.
    """

    def __init__(
        self, attempts: Mapping[str, Attempt], bus: EventBus[LoggedEvent], store: JobQueries
    ) -> None:
        """Wait for the attempts that there are, by the ids of their jobs, and what `store` has."""
        self._attempts = attempts
        self._bus = bus
        self._store = store
        self._limits = WaitLimits()

    async def whole(self, identifier: str, seconds: float) -> Job:
        """Return a job when it has ended, or as it is after some seconds, or when the server ends.

        Raises:
            UnknownJob: There is none.
        """
        attempt = await self._until_ended(identifier, seconds)
        if attempt is not None and attempt.ended is not None:
            return await _whole(attempt.ended)
        return await asyncio.to_thread(self._store.get, identifier)

    async def text(self, identifier: str, seconds: float) -> JobText:
        """Return a job as `whole` does, but for its result, which stays text; raises as `whole`."""
        attempt = await self._until_ended(identifier, seconds)
        if attempt is not None and attempt.ended is not None:
            return attempt.ended
        return await asyncio.to_thread(self._store.text, identifier)

    def end(self) -> None:
        """Answer all waits at once with the job as it is, those to come as well."""
        self._limits.end()

    async def _until_ended(self, identifier: str, seconds: float) -> Attempt | None:
        """Wait until a job has ended, at most so long; return its last attempt, if one was here."""
        attempt = self._attempts.get(identifier)
        if attempt is not None and attempt.ended is not None:
            return attempt
        # One that is not here has ended, or is being taken up again: the log knows.
        is_here = attempt is not None
        wait = self._bus.until_over(identifier) if is_here else self._drained(identifier)
        async with self._limits.limit(seconds):
            await wait
        return self._attempts.get(identifier, attempt)

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
