"""A loop on which nothing of ours can wait for long: what it says of time holds on any machine.

Time that a busy machine takes passes without timers; time that we take passes by them.
"""

import asyncio
import math
from contextlib import contextmanager
from typing import Any

# Far beyond any test [s].
_NEVER = 1e6


class PromptLoop(asyncio.SelectorEventLoop):
    """An event loop that holds back timers while short waits alone are allowed."""

    def __init__(self) -> None:
        """Hold none back."""
        super().__init__()
        self._longest = math.inf
        self._held: list[tuple[float, asyncio.TimerHandle]] = []

    def call_at(self, when: float, *call: Any, **about: Any) -> asyncio.TimerHandle:
        """Set a timer."""
        if when - self.time() <= self._longest:
            return super().call_at(when, *call, **about)
        held = super().call_at(self.time() + _NEVER, *call, **about)
        self._held.append((when, held))
        return held

    @contextmanager
    def only_short_waits(self, longest: float):
        """Hold back timers that are set for later than that [s] meanwhile; older ones fire."""
        self._longest = longest
        try:
            yield
        finally:
            self._longest = math.inf
            for when, held in self._held:
                self.call_at(when, _fire, held)
            self._held.clear()


def _fire(held: asyncio.TimerHandle) -> None:
    if not held.cancelled():
        held._run()
        held.cancel()


def only_short_waits(longest: float) -> Any:
    """Hold back the longer timers [s] of the loop that runs."""
    loop = asyncio.get_running_loop()
    assert isinstance(loop, PromptLoop)
    return loop.only_short_waits(longest)


def run(story: Any) -> Any:
    """Run a coroutine on such a loop."""
    return asyncio.run(story, loop_factory=PromptLoop)
