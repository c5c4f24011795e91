"""RemoteHost: the dispatcher's end of the workers of one machine, over any transport.

A machine that is lost is replaced by another one as soon as there is one; until then its workers
are not ready, and what ran there has ended as `Lost`.
"""

import asyncio
import logging
from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from typing import Protocol

from service.jobs.artifacts import ArtifactCopies
from service.jobs.hosts.artifacts import ArtifactAnswers, RemoteArtifacts
from service.jobs.hosts.messages import HostMessage, HostMessageKind, batch_of, pack, unpack
from service.jobs.hosts.plan import HostPlan
from service.jobs.hosts.remote_worker import RemoteWorker

# Before a machine is looked for again [s].
_PAUSE = 1.0
_log = logging.getLogger(__name__)


class ConnectionLost(Exception):
    """The host does not answer any more, or makes no sense."""


class Connection(Protocol):
    """A way to a host that runs.

    Attributes:
        name: Of the machine, for people.
    """

    name: str

    async def deliver(self, batch: bytes) -> None:
        """Have the host take messages, after those that it was given before.

        Raises:
            ConnectionLost: It does not answer.
        """
        ...

    async def collect(self) -> bytes:
        """Return what the host has to say; nothing, if that is so for a while.

        Raises:
            ConnectionLost: It does not answer.
        """
        ...


class Hosts(Protocol):
    """Where machines are found, and hosts run on them."""

    def host(self, plan: HostPlan) -> AbstractAsyncContextManager[Connection]:
        """Return a context in which a host runs; to enter it takes until there is a machine.

        Entering it raises `ConnectionLost` if the machine was lost before the host ran.
        """
        ...


class RemoteHost:
    """Has a host, always, as far as there are machines."""

    def __init__(self, hosts: Hosts, plan: HostPlan, copies: ArtifactCopies | None = None) -> None:
        """Prepare; the first worker that is opened begins to look for a machine.

        Args:
            hosts: Where to look.
            plan: What the host is told; its warm-up is that with which workers are opened.
            copies: On this machine, of the artifacts that its tasks read and make; None if they
                read and make none.
        """
        self._made = RemoteArtifacts(self._send)
        self._copies = None if copies is None else ArtifactCopies(copies.folder, self._made)
        self.workers = [RemoteWorker(number, self) for number in range(len(plan.workers))]
        self._hosts = hosts
        self._plan = plan
        self._supervisor: asyncio.Task[None] | None = None
        self._answers = ArtifactAnswers(None if copies is None else copies.source)
        self._waiting: list[HostMessage] = []
        # What may take long to send, and is sent when nothing else waits.
        self._in_bulk: list[HostMessage] = []
        self._has_some = asyncio.Event()

    async def open(self, warm_up: str | None) -> None:
        """Begin to look for a machine, if that has not begun."""
        if self._supervisor is None:
            plan = replace(self._plan, warm_up=warm_up)
            self._supervisor = asyncio.get_running_loop().create_task(self._supervise(plan))

    async def close(self) -> None:
        """End the host, if it has not ended."""
        if self._supervisor is not None:
            self._supervisor.cancel()
            await asyncio.gather(self._supervisor, return_exceptions=True)

    async def fetch(self, artifacts: Sequence[str]) -> None:
        """Copy what this machine lacks of artifacts that a run has made on the host."""
        if self._copies is not None:
            await self._copies.bring(artifacts)

    async def _supervise(self, plan: HostPlan) -> None:
        while True:
            why = "no machine is there"
            try:
                async with self._hosts.host(plan) as connection:
                    await self._work_with(connection, plan.timeouts.lost)
            except ConnectionLost as fault:
                why = str(fault)
                _log.error("a host was lost: %s", why)
            except Exception as fault:  # noqa: BLE001  (the next machine may be better)
                why = f"{type(fault).__name__}: {fault}"
                _log.exception("a host could not be used")
            finally:
                self._lose(why)
            await asyncio.sleep(_PAUSE)

    async def _work_with(self, connection: Connection, lost: float) -> None:
        """Pass messages on until the host is lost."""
        self._waiting.clear()
        self._in_bulk.clear()
        for worker in self.workers:
            worker.attach(connection.name, self._send)
        ways = [self._deliver(connection, lost), self._collect(connection, lost)]
        tasks = [asyncio.get_running_loop().create_task(way) for way in ways]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        except TimeoutError as fault:
            message = f"{connection.name} has not answered for {lost:g} s"
            raise ConnectionLost(message) from fault
        except (ValueError, KeyError, TypeError, IndexError) as fault:
            message = f"{connection.name} speaks nonsense: {fault!r}"
            raise ConnectionLost(message) from fault
        finally:
            # Nothing more may begin there, before it is known to be gone.
            self._lose(f"{connection.name} was lost")
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _deliver(self, connection: Connection, lost: float) -> None:
        """Deliver what there is, a batch at a time: the next one waits until the host has it."""
        while True:
            await self._has_some.wait()
            batch = batch_of(self._waiting or self._in_bulk)
            if not (self._waiting or self._in_bulk):
                self._has_some.clear()
            if batch:
                async with asyncio.timeout(lost):
                    await connection.deliver(pack(batch))

    async def _collect(self, connection: Connection, lost: float) -> None:
        while True:
            async with asyncio.timeout(lost):
                batch = await connection.collect()
            for message in unpack(batch):
                self._take(message)

    def _take(self, message: HostMessage) -> None:
        match message.kind:
            case HostMessageKind.ASK:
                self._answers.take(message, self._send)
            case HostMessageKind.REPLY:
                self._made.take(message)
            case _:
                self.workers[message.worker].take(message)

    def _send(self, message: HostMessage) -> None:
        is_bulk = message.kind is HostMessageKind.REPLY
        (self._in_bulk if is_bulk else self._waiting).append(message)
        self._has_some.set()

    def _lose(self, why: str) -> None:
        self._answers.forget()
        for worker in self.workers:
            worker.lose(why)
