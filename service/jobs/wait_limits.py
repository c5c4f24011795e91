"""WaitLimits: time limits of waits for jobs, which all end when the server begins to end."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import asynccontextmanager


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
