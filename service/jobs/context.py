"""TaskContext: how a task speaks to the server while it runs."""

from typing import Any, Protocol

# Type of an event that says which artifacts a task has made in the folder of its host, by sha256
# (`artifacts`). Those that run elsewhere are copied from there before the run has ended.
MADE = "made"


class TaskContext(Protocol):
    """The task's end of its worker."""

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Append an event to the job's log; of more than 64 KiB all but a note is left out."""
        ...

    def emit_whole(self, event_type: str, data: dict[str, Any]) -> None:
        """Append an event that the server itself reads again: nothing of it is left out."""
        ...

    def update(self, event_type: str, data: dict[str, Any]) -> None:
        """Append an event that the next of its type may replace; the task never waits for it."""
        ...

    def allow(self, seconds: float, grace: float = 0.0) -> None:
        """Have the run ended after some seconds from now on, and not before.

        Args:
            seconds: Time that the run may take, as it was asked for [s].
            grace: Time beyond it in which it may still end by itself [s].
        """
        ...

    def watch(self, silence: float) -> None:
        """Have the process ended if it says nothing for so long [s], from now on."""
        ...

    def controls(self) -> dict[str, Any]:
        """Return all that was asked of this run while it runs, the latest of each name."""
        ...

    def is_canceled(self) -> bool:
        """Return whether the end of the job was asked for."""
        ...
