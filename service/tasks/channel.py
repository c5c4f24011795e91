"""Channel: how a task speaks to the server while it runs."""

from typing import Any, Protocol


class Channel(Protocol):
    """The task's end of its slot."""

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Append an event to the job's log."""
        ...

    def allow(self, seconds: float) -> None:
        """Have the run ended after so many seconds from now on, and not before."""
        ...

    def is_canceled(self) -> bool:
        """Return whether somebody asked for the end of the job."""
        ...
