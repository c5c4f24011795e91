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
    """An event loop some of whose timers never fire.

    Attributes:
        longest: Timers that are set for later than that from now on never fire [s].
    """

    longest = math.inf

    def call_at(self, when: float, *call: Any, **about: Any) -> asyncio.TimerHandle:
        """Set a timer."""
        is_prompt = when - self.time() <= self.longest
        return super().call_at(when if is_prompt else self.time() + _NEVER, *call, **about)


@contextmanager
def only_short_waits(longest: float):
    """Have what waits longer meanwhile [s] wait forever; timers that are set already still fire."""
    loop = asyncio.get_running_loop()
    assert isinstance(loop, PromptLoop)
    loop.longest = longest
    try:
        yield
    finally:
        loop.longest = math.inf


def run(story: Any) -> Any:
    """Run a coroutine on such a loop."""
    return asyncio.run(story, loop_factory=PromptLoop)
