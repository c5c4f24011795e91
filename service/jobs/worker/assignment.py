"""Assignment: one run of a task; Worker: where tasks run, one at a time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from service.jobs.json_text import Encoded
from service.jobs.outcome import Outcome


class EventSink(Protocol):
    """Where the events of a run go."""

    def put(self, event_type: str, data: Encoded, *, is_update: bool = False) -> None:
        """Take an event; an update may replace the one of its type before it."""
        ...

    async def wait_for_space(self) -> None:
        """Wait while too many events have been taken and not been dealt with."""
        ...


@dataclass(frozen=True)
class Assignment:
    """One run of a task.

    Attributes:
        task: Its name.
        payload: What it is called with, as JSON.
        sink: Gets each of its events, in the event loop's thread.
        time_limit: Seconds after which it is told to end, and a little later killed; or None. A
            task that knows better may change it while it runs.
        controls: What is set when it begins; `Worker.control` tells what is set later.
        ids: Of what it is run for, by name; they are in every line that it logs.
    """

    task: str
    payload: Encoded
    sink: EventSink
    time_limit: float | None = None
    controls: Mapping[str, Any] = field(default_factory=dict)
    ids: Mapping[str, str] = field(default_factory=dict)


class Worker(Protocol):
    """Where tasks run, one at a time, each of which can be ended."""

    @property
    def generation(self) -> int:
        """A number that changes with the process: another one has no world loaded."""
        ...

    @property
    def fault(self) -> str | None:
        """Why no run would begin at once, or would not end well; None if all is well."""
        ...

    @property
    def is_lost(self) -> bool:
        """Whether its machine is lost, so that it gets nothing to do until it is ready again."""
        ...

    async def open(self, warm_up: str | None) -> None:
        """Begin to get ready; every process of the worker runs the task `warm_up` first."""
        ...

    async def ready(self) -> None:
        """Wait until a run would begin at once."""
        ...

    async def bring(self, artifacts: Sequence[str]) -> None:
        """Copy what the host lacks of artifacts that the next run reads.

        Raises:
            DBAPIError: The database does not answer.
            OSError: The host's folder cannot be written.
        """
        ...

    async def run(self, run: Assignment) -> Outcome:
        """Run a task to its end, whatever that is."""
        ...

    def cancel(self, grace: float) -> None:
        """Tell the present run to end; end it by force after `grace` seconds."""
        ...

    def control(self, controls: Mapping[str, Any]) -> None:
        """Tell the present run all controls that are set by now."""
        ...

    async def close(self) -> None:
        """End the worker and what runs in it."""
        ...
