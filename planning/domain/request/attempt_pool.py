"""AttemptPool: who makes several attempts at once."""

from collections.abc import Callable, Generator
from typing import Any, Protocol, runtime_checkable

from planning.domain.request.deadline import Deadline


@runtime_checkable
class AttemptPool(Protocol):
    """Does pieces of work elsewhere, while whoever asks waits.

    What it does not do is no error: the one who asks does it, as if there were no pool.
    """

    def each(
        self, work: Callable[[int], Any], count: int, deadline: Deadline
    ) -> Generator[tuple[int, Any]]:
        """Yield number and outcome of pieces 0 to count - 1 as they are done, perhaps not all.

        The outcome of a piece is what `work` returned, or the WayproofError that it raised. When
        the generator is closed all that is still at work has ended.

        Raises:
            Canceled: The end was asked for.
        """
        ...
