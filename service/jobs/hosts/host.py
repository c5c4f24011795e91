"""WorkerHost: the workers of a machine, in the process that owns them; knows no transport.

Each is the `ProcessWorker` that runs on the dispatcher's own machine. It enforces deadlines,
silence, memory and the grace of a cancel itself, so that a dispatcher that is lost prolongs
nothing. A host that is not asked for news any more ends what it runs.
"""

import asyncio
import json
import logging
from collections.abc import Callable
from pathlib import Path

from service.jobs.artifacts import ArtifactCopies
from service.jobs.errors import InternalError
from service.jobs.hosts.artifacts import ArtifactAnswers, FolderArtifacts, RemoteArtifacts
from service.jobs.hosts.messages import HostMessage, HostMessageKind, unpack
from service.jobs.hosts.outbox import Outbox, OutboxSink
from service.jobs.hosts.outcome_text import dump_outcome
from service.jobs.hosts.plan import HostPlan
from service.jobs.json_text import Encoded, encode
from service.jobs.outcome import Crashed, Outcome, Raised, Terminated
from service.jobs.worker.assignment import Assignment, Worker
from service.jobs.worker.process_worker import ProcessWorker

_log = logging.getLogger(__name__)


class WorkerHost:
    """Runs what it is told in its workers, and says how that goes; belongs to one event loop."""

    def __init__(
        self,
        plan: HostPlan,
        *,
        on_abandoned: Callable[[], None] = lambda: None,
        workers: list[Worker] | None = None,
    ) -> None:
        """Prepare; `open` starts the workers.

        Args:
            plan: How many, on what terms.
            on_abandoned: Called once what ran has ended because nothing asked for news.
            workers: Instead of processes.
        """
        self._plan = plan
        self._on_abandoned = on_abandoned
        self._outbox = Outbox()
        self._artifacts = RemoteArtifacts(self._outbox.put)
        folder = None if plan.folder is None else Path(plan.folder)
        self._answers = ArtifactAnswers(None if folder is None else FolderArtifacts(folder))
        copies = None if folder is None else ArtifactCopies(folder, self._artifacts)
        made = workers or [ProcessWorker(plan.preload, terms, copies) for terms in plan.workers]
        self._hosted = [HostedWorker(i, one, self._outbox) for i, one in enumerate(made)]
        self._watch: asyncio.TimerHandle | None = None
        self._closing: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Begin to get the workers ready; each says when it is."""
        for one in self._hosted:
            await one.open(self._plan.warm_up)
        self._wait_for_dispatcher()

    def deliver(self, batch: bytes) -> None:
        """Take messages of the dispatcher.

        Raises:
            ValueError: They are none.
        """
        for message in unpack(batch):
            match message.kind:
                case HostMessageKind.REPLY:
                    self._artifacts.take(message)
                case HostMessageKind.ASK:
                    self._answers.take(message, self._outbox.put)
                case _:
                    self._hosted[message.worker].take(message)

    async def collect(self) -> bytes:
        """Return what there is to say; nothing, if that is so for a while."""
        if self._watch is not None:
            self._watch.cancel()
        try:
            return await self._outbox.collect(self._plan.timeouts.patience)
        finally:
            self._wait_for_dispatcher()

    async def close(self) -> None:
        """End the workers and what runs in them."""
        if self._watch is not None:
            self._watch.cancel()
        self._answers.forget()
        await asyncio.gather(*(one.close() for one in self._hosted))

    def _wait_for_dispatcher(self) -> None:
        if self._watch is not None:
            self._watch.cancel()
        loop = asyncio.get_running_loop()
        self._watch = loop.call_later(self._plan.timeouts.abandoned, self._abandon)

    def _abandon(self) -> None:
        _log.error("nothing asked for news any more: what runs is ended")
        self._closing = asyncio.get_running_loop().create_task(self.close())
        self._closing.add_done_callback(lambda _: self._on_abandoned())


class HostedWorker:
    """One worker of a host, which is told what to do by messages."""

    def __init__(self, number: int, worker: Worker, outbox: Outbox) -> None:
        """Say how it goes in `outbox`."""
        self._number = number
        self._worker = worker
        self._outbox = outbox
        self._run = 0
        self._sink = OutboxSink(outbox, number, 0)
        self._canceled = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    async def open(self, warm_up: str | None) -> None:
        """Begin to get ready, and say so then."""
        await self._worker.open(warm_up)
        self._task = asyncio.get_running_loop().create_task(self._announce())

    async def close(self) -> None:
        """End what runs, and the worker."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self._worker.close()

    def take(self, message: HostMessage) -> None:
        """Do what a message says; what is about an earlier run is stale."""
        match message.kind:
            case HostMessageKind.RUN:
                self._begin(message)
            case _ if message.run != self._run:
                pass
            case HostMessageKind.CANCEL:
                self._canceled.set()
                self._worker.cancel(float(message.body))
            case HostMessageKind.CONTROLS:
                self._worker.control(json.loads(message.body))
            case HostMessageKind.RECEIVED:
                self._sink.note_received(int(message.body))
            case _:
                _log.error("a message out of turn: %s", message.kind.name)

    def _begin(self, message: HostMessage) -> None:
        self._run = message.run
        self._canceled = asyncio.Event()
        self._sink = OutboxSink(self._outbox, self._number, message.run)
        if self._task is not None:
            self._task.cancel()
        self._task = asyncio.get_running_loop().create_task(self._carry_out(message))

    async def _carry_out(self, message: HostMessage) -> None:
        """Run a task, say how it ended, and when the next one may begin."""
        try:
            outcome = await self._outcome(message)
        except Exception as fault:  # noqa: BLE001  (no run may stay without an end)
            _log.exception("a worker failed")
            outcome = Raised(InternalError(f"the worker failed: {type(fault).__name__}"))
        self._say(HostMessageKind.OUTCOME, dump_outcome(outcome))
        await self._announce()

    async def _outcome(self, message: HostMessage) -> Outcome:
        head, payload = message.parts
        terms = json.loads(head)
        limit, controls = terms["time_limit"], terms["controls"]
        run = Assignment(terms["task"], Encoded(payload), self._sink, limit, controls)
        try:
            await self._bring(terms["artifacts"])
        except OSError as fault:  # this machine's disk is full: another one may have room
            return Crashed(None, f"what it reads could not be copied: {fault.strerror}")
        # A cancel may have come before there was anything to cancel.
        return Terminated() if self._canceled.is_set() else await self._worker.run(run)

    async def _bring(self, artifacts: list[str]) -> None:
        """Copy what this host lacks of artifacts, or as much of it as there is until a cancel."""
        if not artifacts:
            return
        loop = asyncio.get_running_loop()
        bring = loop.create_task(self._worker.bring(artifacts))
        canceled = loop.create_task(self._canceled.wait())
        try:
            await asyncio.wait([bring, canceled], return_when=asyncio.FIRST_COMPLETED)
            if bring.done():
                bring.result()
        finally:
            bring.cancel()
            canceled.cancel()

    async def _announce(self) -> None:
        await self._worker.ready()
        state = {"generation": self._worker.generation, "fault": self._worker.fault}
        self._say(HostMessageKind.READY, encode(state).encode())

    def _say(self, kind: HostMessageKind, body: bytes) -> None:
        self._outbox.put(HostMessage(kind, self._number, self._run, body))
