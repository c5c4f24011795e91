"""RayHosts: machines of a Ray cluster, one actor on each.

Ray places the actors, carries bytes, and says when one is lost. Jobs, queues, deadlines and retries
are not Ray's. Machines are the nodes that have the custom resource `wayproof`. Needs the extra
`ray`; nothing of it is imported before a machine is looked for.
"""

import asyncio
import contextlib
import importlib
import os
import signal
import threading
from collections.abc import AsyncGenerator, Awaitable
from contextlib import asynccontextmanager
from typing import Any

from service.jobs.hosts.plan import HostPlan
from service.jobs.hosts.ray_actor import HostActor
from service.jobs.hosts.remote_host import Connection, ConnectionLost

# Nodes that have it work; its amount is no matter.
RESOURCE = "wayproof"
# Between two looks for a machine that is free [s].
_PERIOD = 1.0
# Between two looks at what joining a cluster does to signals, far below Ray's 3 s [s].
_GUARD_PERIOD = 0.2
# Within which an actor's process is there, with what it imports [s].
_START_WITHIN = 120.0
# Within which the workers of an actor have ended [s].
_END_WITHIN = 3.0
_ENVIRONMENT = {
    # Nothing is told to anyone.
    "RAY_USAGE_STATS_ENABLED": "0",
    # A server that `uv run` started has its packages on each machine already.
    "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0",
}


class RayHosts:
    """Runs hosts on the machines of a cluster, at most one on each."""

    def __init__(self, address: str) -> None:
        """Work with a cluster; it is joined when the first machine is looked for.

        Args:
            address: Of its head, `host:port`; this machine is one of its nodes.
        """
        self._address = address
        self._taken: set[str] = set()
        self._failures: dict[str, int] = {}
        self._joining = asyncio.Lock()

    @asynccontextmanager
    async def host(self, plan: HostPlan) -> AsyncGenerator[Connection]:
        """Run a host on a machine that has none, as soon as there is one.

        Raises:
            ConnectionLost: The cluster or the machine was lost before the host ran.
        """
        ray = await self._join()
        node = await self._free_node(ray)
        identifier: str = node["NodeID"]
        name = f"{node['NodeManagerAddress']}/{identifier[:8]}"
        self._taken.add(identifier)
        # The machine that failed least often comes first.
        self._failures[identifier] = self._failures.get(identifier, 0) + 1
        actor: Any = None
        try:
            actor = _start(ray, identifier)
            await _begin(actor, plan, name)
            yield _RayConnection(actor, name)
        finally:
            self._taken.discard(identifier)
            if actor is not None:
                await _end(ray, actor)

    async def _join(self) -> Any:
        async with self._joining:
            joining = asyncio.ensure_future(asyncio.to_thread(_joined, self._address))
            try:
                while not joining.done():
                    await asyncio.wait({joining}, timeout=_GUARD_PERIOD)
                    _take_back_sigterm()
            finally:
                joining.cancel()
            return joining.result()

    async def _free_node(self, ray: Any) -> dict[str, Any]:
        while True:
            try:
                nodes = await asyncio.to_thread(ray.nodes)
            except Exception as fault:  # Ray has no class for all of them
                message = f"the cluster at {self._address} does not answer: {fault}"
                raise ConnectionLost(message) from fault
            free = [
                node
                for node in nodes
                if node["Alive"] and RESOURCE in node["Resources"]
                if node["NodeID"] not in self._taken
            ]
            if free:
                return min(free, key=lambda node: self._failures.get(node["NodeID"], 0))
            await asyncio.sleep(_PERIOD)


class _RayConnection:
    """A way to an actor."""

    def __init__(self, actor: Any, name: str) -> None:
        self.name = name
        self._actor = actor

    async def deliver(self, batch: bytes) -> None:
        await _answer(self._actor.deliver.remote(batch), self.name)

    async def collect(self) -> bytes:
        return await _answer(self._actor.collect.remote(), self.name)


def _joined(address: str) -> Any:
    """Return the module `ray`, which has joined a cluster; takes seconds.

    Raises:
        ConnectionLost: The cluster does not let it.
    """
    for name, text in _ENVIRONMENT.items():
        os.environ.setdefault(name, text)
    ray = _module("ray")
    if not ray.is_initialized():
        try:
            ray.init(address=address, configure_logging=False, log_to_driver=False)
        except Exception as fault:  # Ray has no class for all of them
            message = f"the cluster at {address} cannot be joined: {fault}"
            raise ConnectionLost(message) from fault
    return ray


def _take_back_sigterm() -> None:
    """Have SIGTERM come to this process alone again, as it did before it joined.

    Ray puts a handler of native code before it, which aborts the process 3 s later, whatever it
    still does: robots that come to rest, plans that are waited for (ray-project/ray#64830). It does
    so by an alarm, which has been set already where the signal came while the cluster was joined.
    """
    handler = signal.getsignal(signal.SIGTERM)
    if handler is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, handler)
        signal.alarm(0)  # nothing else here uses alarms


def _start(ray: Any, node: str) -> Any:
    """Return an actor on a node, which starts; it ends with this process."""
    strategies = _module("ray.util.scheduling_strategies")
    there = strategies.NodeAffinitySchedulingStrategy(node, soft=False)
    return ray.remote(HostActor).options(num_cpus=0, scheduling_strategy=there).remote()


async def _begin(actor: Any, plan: HostPlan, name: str) -> None:
    try:
        async with asyncio.timeout(_START_WITHIN):
            found = (await _answer(actor.begin.remote(plan.dumped()), name)).decode()
    except TimeoutError as fault:
        message = f"no host started on {name} within {_START_WITHIN:g} s"
        raise ConnectionLost(message) from fault
    if found != plan.version:
        message = f"{name} has version {found} of wayproof, not {plan.version}"
        raise ConnectionLost(message)


async def _end(ray: Any, actor: Any) -> None:
    """End an actor, after what runs in its workers."""
    # It may be gone, or the cluster may be.
    try:
        with contextlib.suppress(Exception):
            async with asyncio.timeout(_END_WITHIN):
                await actor.end.remote()
    finally:
        with contextlib.suppress(Exception):
            ray.kill(actor)


async def _answer(reference: Awaitable[Any], name: str) -> Any:
    try:
        return await reference
    except _module("ray.exceptions").RayError as fault:
        message = f"{name} was lost: {str(fault).splitlines()[0]}"
        raise ConnectionLost(message) from fault


def _module(name: str) -> Any:
    """Return a module of Ray, which is an extra, and takes seconds to import."""
    return importlib.import_module(name)
