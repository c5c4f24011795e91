"""Settled: work that is done once what is typed has come to rest.

The page tells of each key, and neither of Enter nor of a field that is left: after "1" comes "19".
"""

import threading
from collections.abc import Callable

# Without a key [s].
REST = 0.6


class Settled:
    """Carries out what was asked last, once nothing was asked for a while."""

    def __init__(self, carry_out: Callable[[Callable[[], None]], None], rest: float = REST) -> None:
        """Wait for work.

        Args:
            carry_out: Is given the work, from a thread.
            rest: How long nothing is to be asked before [s].
        """
        self._carry_out, self._rest = carry_out, rest
        self._timer: threading.Timer | None = None
        self._lock = threading.Lock()

    def ask(self, work: Callable[[], None]) -> None:
        """Have work done soon, in place of what waits."""
        with self._lock:
            self._drop()
            self._timer = threading.Timer(self._rest, self._begin, (work,))
            self._timer.daemon = True
            self._timer.start()

    @property
    def is_waiting(self) -> bool:
        """Whether there is work that has not begun."""
        return self._timer is not None

    def drop(self) -> None:
        """Forget what waits."""
        with self._lock:
            self._drop()

    def _drop(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None

    def _begin(self, work: Callable[[], None]) -> None:
        with self._lock:
            if threading.current_thread() is not self._timer:
                return  # something else was asked in the meantime
            self._timer = None
        self._carry_out(work)
