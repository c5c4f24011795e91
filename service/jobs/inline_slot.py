"""InlineSlot: tasks in a thread of this process, for tests that want no processes.

Canceling is cooperative only, a deadline is the task's own affair, and a crash ends everything.
"""

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from service.jobs.outcome import Outcome
from service.jobs.slot import OnEvent, Run
from service.jobs.worker import run_task

# Drake worlds are kept per process and OMPL's random numbers are global to it: one task at a time.
_ONE_AT_A_TIME = threading.Lock()


class _ThreadChannel:
    """A channel within the process."""

    def __init__(self, loop: asyncio.AbstractEventLoop, on_event: OnEvent) -> None:
        self._loop = loop
        self._on_event = on_event
        self.canceled = threading.Event()

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Hand an event to the loop."""
        self._loop.call_soon_threadsafe(self._on_event, event_type, data)

    def is_canceled(self) -> bool:
        """Return whether somebody asked for the end of this run."""
        return self.canceled.is_set()


class InlineSlot:
    """A slot that is a thread."""

    def __init__(self, *, is_exclusive: bool) -> None:
        """Make the thread.

        Args:
            is_exclusive: Whether its tasks and those of other exclusive slots take turns.
        """
        self.warm_key: str | None = None
        self._is_exclusive = is_exclusive
        self._thread = ThreadPoolExecutor(1, "inline-slot")
        self._channel: _ThreadChannel | None = None

    async def run(self, run: Run) -> Outcome:
        """Run a task to its end."""
        loop = asyncio.get_running_loop()
        channel = _ThreadChannel(loop, run.on_event)
        self._channel = channel

        def call() -> Outcome:
            if not self._is_exclusive:
                return run_task(run.task, run.payload, channel)
            with _ONE_AT_A_TIME:
                return run_task(run.task, run.payload, channel)

        outcome = await loop.run_in_executor(self._thread, call)
        await asyncio.sleep(0)  # events that the thread handed over come before its end
        self._channel = None
        return outcome

    def cancel(self, grace: float) -> None:
        """Tell the task; there is no force here."""
        del grace
        if self._channel is not None:
            self._channel.canceled.set()

    async def close(self) -> None:
        """Wait for the present task, which is told to end."""
        self.cancel(0.0)
        await asyncio.to_thread(self._thread.shutdown)
