"""Machines: where the workers of a server are: below it, or on the nodes of a Ray cluster."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from benchmarks.serving.processes import Process, descendants, workers
from tests.service.jobs.remote.machines import cluster, end_clusters

_NUM_HOSTS = 2


class Machines(Protocol):
    """Where workers are.

    Attributes:
        name: Of the engine.
    """

    name: str

    @property
    def environment(self) -> Mapping[str, str]:
        """What tells a server to use them."""
        ...

    def workers(self, server: int) -> list[Process]:
        """Return the processes that run tasks of a server, or help them."""
        ...

    def hosts(self, server: int) -> list[Process]:
        """Return the processes that own workers, but for the server itself."""
        ...

    def lose(self, choice: float) -> list[Process]:
        """End one of the machines without a word, have another one in its place.

        Args:
            choice: Which, 0 to 1.

        Returns:
            What ran on it.
        """
        ...

    def close(self) -> None:
        """End them."""
        ...


class OwnMachine:
    """Workers are below the server."""

    name = "process"
    environment: Mapping[str, str] = {}

    def workers(self, server: int) -> list[Process]:
        """Return children of its forkserver, and what they started."""
        return workers(server)

    def hosts(self, server: int) -> list[Process]:  # noqa: ARG002  (see `Machines`)
        """Return none: the server itself owns them."""
        return []

    def lose(self, choice: float) -> list[Process]:  # noqa: ARG002  (see `Machines`)
        """Lose nothing: it is the machine of the server."""
        return []

    def close(self) -> None:
        """Do nothing: they end with the server."""


class RayMachines:
    """Workers are on two nodes of a Ray cluster, which this process has started here."""

    name = "ray"

    def __init__(self) -> None:
        """Start the cluster; its nodes find the modules of poison where this process does."""
        os.environ["PYTHONPATH"] = str(Path(__file__).parents[2])
        self._cluster = cluster(_NUM_HOSTS)

    @property
    def environment(self) -> Mapping[str, str]:
        """The address of its head."""
        return {
            "WAYPROOF_ENGINE": "ray",
            "WAYPROOF_RAY_ADDRESS": self._cluster.address,
            "WAYPROOF_RAY_HOSTS": str(_NUM_HOSTS),
            "WAYPROOF_PLAN_SLOTS": "1",
            "WAYPROOF_QUERY_SLOTS": "1",
        }

    def workers(self, server: int) -> list[Process]:
        """Return what the actors' forkservers have forked, and what that started."""
        actors = {actor.pid for actor in self.hosts(server)}
        return [
            process for actor in actors for process, parent in descendants(actor) if parent != actor
        ]

    def hosts(self, server: int) -> list[Process]:  # noqa: ARG002  (see `Machines`)
        """Return the actors."""
        return [one for one, _ in descendants(os.getpid()) if _is_host(one.pid)]

    def lose(self, choice: float) -> list[Process]:
        """End a node and what it runs by SIGKILL, and add one."""
        nodes = self._cluster.nodes
        node = nodes[int(choice * len(nodes))]
        own = self._cluster.pids(node)
        ran = {process for pid in own for process, _ in descendants(pid) if process.pid not in own}
        self._cluster.lose(node)
        self._cluster.add(_NUM_HOSTS)
        return list(ran)

    def close(self) -> None:
        """End the cluster."""
        end_clusters()


def _is_host(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().startswith(b"ray::HostActor")
    except OSError:
        return False
