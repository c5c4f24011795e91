"""AttemptPool: protocol of a worker pool that runs several planning attempts concurrently."""

from collections.abc import Callable, Generator
from typing import Any, Protocol, runtime_checkable

from planning.domain.request.deadline import Deadline


@runtime_checkable
class AttemptPool(Protocol):
    """Worker pool for numbered pieces of work, run while the caller waits.

    A pool may leave pieces undone; the caller then runs them itself, as if there were no pool.
    """

    def each(
        self, work: Callable[[int], Any], count: int, deadline: Deadline
    ) -> Generator[tuple[int, Any]]:
        """Yield (index, outcome) of pieces 0 to count - 1 in order of completion, perhaps not all.

        The outcome of a piece is the return value of `work`, or the WayproofError that it raised.
        When the generator is closed, all running pieces have ended.

        Raises:
            Canceled: The work is canceled.
        """
        ...
