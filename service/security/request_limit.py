"""RequestLimit: how many requests each caller may make in a window of time."""

from datetime import UTC, datetime

from limits import parse
from limits.aio.storage import MemoryStorage
from limits.aio.strategies import SlidingWindowCounterRateLimiter

from service.errors import RateLimited


class RequestLimit:
    """Counts requests in memory: those of one server, since it began."""

    def __init__(self, limit: str) -> None:
        """Allow so many.

        Args:
            limit: As `600/minute`.

        Raises:
            ValueError: It is not of that form.
        """
        self._text = limit
        self._limit = parse(limit)
        self._counter = SlidingWindowCounterRateLimiter(MemoryStorage())

    async def count(self, caller: str) -> RateLimited | None:
        """Count a request; return why it is refused, None if it is not.

        Args:
            caller: Whose it is.
        """
        if await self._counter.hit(self._limit, caller):
            return None
        window = await self._counter.get_window_stats(self._limit, caller)
        seconds = max(1.0, window.reset_time - datetime.now(UTC).timestamp())
        message = f"more than {self._text} requests: try again in {seconds:.0f} s"
        return RateLimited(message, {"limit": self._text, "retry_after": seconds})
