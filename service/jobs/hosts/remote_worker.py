"""RemoteWorker: a worker on another machine, as the dispatcher sees it."""

import asyncio
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from service.jobs.hosts.messages import HostMessage, HostMessageKind
from service.jobs.hosts.outcome_text import load_outcome
from service.jobs.json_text import Encoded, encode
from service.jobs.outcome import Lost, Outcome, Terminated
from service.jobs.worker.assignment import Assignment

type Send = Callable[[HostMessage], None]


class Lifecycle(Protocol):
    """What opens and closes the host of a worker, and copies from it what runs have made."""

    async def open(self, warm_up: str | None) -> None:
        """Begin to look for a machine, if that has not begun."""
        ...

    async def close(self) -> None:
        """End the host, if it has not ended."""
        ...

    async def fetch(self, artifacts: Sequence[str]) -> None:
        """Copy what this machine lacks of artifacts that a run has made on the host."""
        ...


class RemoteWorker:
    """Passes runs on to its host; ready while the host is there and says so."""

    def __init__(self, number: int, host: Lifecycle) -> None:
        """Stand for a worker of `host`, which calls `attach` when there is a machine."""
        self.generation = 0
        self._number = number
        self._host = host
        self._name = ""
        self._send: Send | None = None
        self._fault: str | None = None
        self._why_lost = "no machine is there"
        self._is_ready = asyncio.Event()
        self._may_go_on = asyncio.Event()
        self._run = 0
        self._remote_generation = 0
        self._assignment: Assignment | None = None
        self._ended: asyncio.Future[Outcome] | None = None
        self._artifacts: tuple[str, ...] = ()
        self._made: list[str] = []
        self._lost: asyncio.Future[None] | None = None
        self._is_canceled = False
        self._acknowledging: set[asyncio.Task[None]] = set()

    @property
    def fault(self) -> str | None:
        """Why no run would begin at once, or would not end well."""
        if self._send is None:
            return self._why_lost
        # While it works it is not ready, and that is no fault.
        is_awaited = self.generation == 0 or (self._ended is None and not self._is_ready.is_set())
        return "no process is there" if is_awaited else self._fault

    @property
    def is_lost(self) -> bool:
        """Whether there is no machine."""
        return self._send is None

    async def open(self, warm_up: str | None) -> None:
        """Begin to look for a machine."""
        await self._host.open(warm_up)

    async def ready(self) -> None:
        """Wait until the host has a warm process."""
        await self._is_ready.wait()

    async def bring(self, artifacts: Sequence[str]) -> None:
        """Have the next run begin once its host has some artifacts."""
        self._artifacts = tuple(artifacts)

    async def run(self, run: Assignment) -> Outcome:
        """Have the host run a task to its end; a host that is lost ends it for the dispatcher."""
        self._is_canceled = False
        self._assignment = run
        try:
            while not self._is_ready.is_set():
                if self._send is None or self._is_canceled:
                    break
                self._may_go_on.clear()
                await self._may_go_on.wait()
            if self._is_canceled:
                return Terminated()
            if self._send is None:
                return Lost(self._name, has_begun=False)
            return await self._run_there(run)
        finally:
            self._assignment = None

    def cancel(self, grace: float) -> None:
        """Tell the host, which ends the process if it has not ended by itself in time."""
        if self._assignment is None:
            return
        self._is_canceled = True
        self._may_go_on.set()
        if self._ended is not None:
            self._say(HostMessageKind.CANCEL, repr(grace).encode())

    def control(self, controls: Mapping[str, Any]) -> None:
        """Tell the host; a run that has not begun is told when it does."""
        if self._ended is not None:
            self._say(HostMessageKind.CONTROLS, json.dumps(controls).encode())

    async def close(self) -> None:
        """End the host and what runs there."""
        for task in self._acknowledging:
            task.cancel()
        await self._host.close()

    def attach(self, name: str, send: Send) -> None:
        """Work on a machine from now on, whose workers get messages by `send`."""
        self._name, self._send = name, send
        self._remote_generation = 0

    def lose(self, why: str) -> None:
        """Note that the machine is lost, and with it what runs there."""
        self._send, self._why_lost = None, why
        self._is_ready.clear()
        self._may_go_on.set()
        if self._ended is not None and not self._ended.done():
            self._ended.set_result(Lost(self._name, has_begun=True))
        if self._lost is not None and not self._lost.done():
            self._lost.set_result(None)

    def take(self, message: HostMessage) -> None:
        """Deal with what the host says of this worker.

        Raises:
            ValueError: It makes no sense.
            KeyError: It lacks something.
        """
        match message.kind:
            case HostMessageKind.READY:
                self._note_ready(message)
            case HostMessageKind.OUTCOME if message.run == self._run and self._ended is not None:
                if not self._ended.done():
                    self._ended.set_result(load_outcome(message.body))
            case HostMessageKind.MADE if message.run == self._run:
                self._made += json.loads(message.body)["artifacts"]
            case HostMessageKind.EVENT | HostMessageKind.UPDATE:
                self._note_event(message)
            case _:
                pass  # of a run that was given up

    async def _run_there(self, run: Assignment) -> Outcome:
        self._is_ready.clear()
        self._run += 1
        self._made.clear()
        self._ended = asyncio.get_running_loop().create_future()
        terms = {
            "task": run.task,
            "time_limit": run.time_limit,
            "controls": dict(run.controls),
            "artifacts": self._artifacts,
        }
        body = f"{encode(terms)}\n{run.payload.text}"
        self._say(HostMessageKind.RUN, body.encode())
        try:
            outcome = await self._ended
            return await self._with_what_it_made(outcome) if self._made else outcome
        except asyncio.CancelledError:
            self._say(HostMessageKind.CANCEL, b"0.0")
            raise
        finally:
            self._ended = None

    async def _with_what_it_made(self, outcome: Outcome) -> Outcome:
        """Return an outcome once this machine has what the run made; the host may be lost before.

        Raises:
            OSError: The folder of this machine cannot be written.
        """
        if self._send is None:
            return Lost(self._name, has_begun=True)
        loop = asyncio.get_running_loop()
        self._lost = loop.create_future()
        fetch = loop.create_task(self._host.fetch(list(self._made)))
        try:
            await asyncio.wait([fetch, self._lost], return_when=asyncio.FIRST_COMPLETED)
            if not fetch.done():
                return Lost(self._name, has_begun=True)
            fetch.result()
        finally:
            fetch.cancel()
        return outcome

    def _note_ready(self, message: HostMessage) -> None:
        """Be ready if the host has ended the last run; what it said before that is stale."""
        if self._ended is not None and not self._ended.done():
            return
        state = json.loads(message.body)
        if state["generation"] != self._remote_generation:
            self._remote_generation = state["generation"]
            self.generation += 1
        self._fault = state["fault"]
        if message.run in {0, self._run}:
            self._is_ready.set()
            self._may_go_on.set()

    def _note_event(self, message: HostMessage) -> None:
        run = self._assignment
        if run is None or message.run != self._run:
            return
        is_update = message.kind is HostMessageKind.UPDATE
        event_type, data = message.parts
        run.sink.put(event_type, Encoded(data), is_update=is_update)
        if not is_update:
            task = asyncio.get_running_loop().create_task(self._acknowledge(run, message.run))
            self._acknowledging.add(task)
            task.add_done_callback(self._acknowledging.discard)

    async def _acknowledge(self, run: Assignment, number: int) -> None:
        await run.sink.wait_for_space()
        if number == self._run:
            self._say(HostMessageKind.RECEIVED, b"1")

    def _say(self, kind: HostMessageKind, body: bytes) -> None:
        if self._send is not None:
            self._send(HostMessage(kind, self._number, self._run, body))
