"""Machines for hosts of workers: some in this process, some in a Ray cluster of this machine."""

import asyncio
import os
import secrets
import shutil
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from service.jobs.hosts.host import WorkerHost
from service.jobs.hosts.plan import HostPlan, own_version
from service.jobs.hosts.remote_host import ConnectionLost, RemoteHost
from service.jobs.worker.main import Terms
from service.jobs.worker.process_worker import ProcessWorker

# `make ray` says "ray"; without its extra there is no cluster.
KINDS = tuple(os.environ.get("WAYPROOF_TEST_HOSTS", "local,hosted").split(","))
REMOTE = tuple(kind for kind in KINDS if kind != "local")


@dataclass
class Site:
    """Where a dispatcher is.

    Attributes:
        kind: Of its workers.
        url: Of its database; None for SQLite in the folder of the test.
        hosts: How many hosts its workers are on.
        machines: Gets what they run on.
    """

    kind: str = "local"
    url: str | None = None
    hosts: int = 1
    machines: list = field(default_factory=list)

    async def lose(self, name):
        """Have a machine go without a word."""
        if self.kind == "hosted":
            await self.machines[0].lose(name)
        else:
            await asyncio.to_thread(cluster().lose, name.partition("/")[2])


class Machines:
    """Machines of which each is a host in this process; messages cross as bytes."""

    def __init__(self, count=1):
        self.names = [f"machine-{i}" for i in range(count)]
        self.lost = {}
        self.hosts = {}

    @asynccontextmanager
    async def host(self, plan):
        while not (free := [name for name in self.names if name not in self.hosts]):  # noqa: ASYNC110
            await asyncio.sleep(0.01)
        name = free[0]
        told = HostPlan.loaded(plan.dumped())
        host = self.hosts[name] = WorkerHost(told)
        self.lost[name] = asyncio.Event()
        await host.open()
        try:
            yield Line(name, host, self.lost[name])
        finally:
            await host.close()
            self.hosts.pop(name, None)

    async def lose(self, name):
        """Have a machine go, and with it what runs there."""
        self.names.remove(name)
        self.lost[name].set()


class Line:
    """A connection within this process."""

    def __init__(self, name, host, lost):
        self.name = name
        self._host = host
        self._lost = lost

    async def deliver(self, batch):
        if self._lost.is_set():
            raise ConnectionLost(self.name)
        self._host.deliver(batch)

    async def collect(self):
        news = asyncio.ensure_future(self._host.collect())
        gone = asyncio.ensure_future(self._lost.wait())
        await asyncio.wait([news, gone], return_when=asyncio.FIRST_COMPLETED)
        gone.cancel()
        if self._lost.is_set():
            news.cancel()
            raise ConnectionLost(self.name)
        return await news


class Cluster:
    """A Ray cluster of this machine: a head that runs nothing, and nodes that do."""

    def __init__(self):
        os.environ.setdefault("RAY_AUTH_TOKEN", secrets.token_hex(32))
        os.environ |= {"RAY_USAGE_STATS_ENABLED": "0", "RAY_worker_niceness": "0"}
        from ray._private import utils
        from ray.cluster_utils import Cluster as RayCluster

        # Nodes end with the thread that started them (prctl(2), PR_SET_PDEATHSIG): it lives as long
        # as the cluster. No handler can be set in it; `close` ends them all.
        self._thread = ThreadPoolExecutor(1, "ray-nodes")
        utils.set_sigterm_handler = lambda _: None
        self._options = {"object_store_memory": 200_000_000}
        head = {"num_cpus": 0, "include_dashboard": False, **self._options}
        self._cluster = RayCluster(initialize_head=True, head_node_args=head)
        self.address = self._cluster.address
        self._nodes = {}
        self._folders = []

    @property
    def nodes(self):
        """The ids of those that may run hosts."""
        return list(self._nodes)

    @property
    def ip(self):
        """The address that all nodes have."""
        return self.address.partition(":")[0]

    def add(self, count):
        """Have so many nodes that may run hosts, at least; from any thread."""
        self._thread.submit(self._add, count).result()

    def _add(self, count):
        for _ in range(count - len(self._nodes)):
            # No machine sees the disk of another one.
            folder = tempfile.mkdtemp(prefix="wp-host-")
            self._folders.append(folder)
            node = self._started(folder)
            self._nodes[node.node_id] = node
        self._cluster.wait_for_nodes()

    def _started(self, folder, tries=5):
        try:
            return self._cluster.add_node(
                num_cpus=1,
                resources={"wayproof": 1},
                env_vars={"WAYPROOF_DATA_DIR": folder},
                wait=False,
                **self._options,
            )
        except Exception as fault:
            # Ray gives a node half a minute, in which one with much beside it does not start.
            if tries == 1 or "timed out during startup" not in str(fault):
                raise
            return self._started(folder, tries - 1)

    def pids(self, identifier):
        """The numbers of a node's own processes; what it runs is below them."""
        started = self._nodes[identifier].all_processes.values()
        return {one.process.pid for some in started for one in some}

    def lose(self, identifier):
        """End a node without a word."""
        (whole,) = [known for known in self._nodes if known.startswith(identifier)]
        self._cluster.remove_node(self._nodes.pop(whole), allow_graceful=False)

    def close(self):
        import ray

        ray.shutdown()
        self._cluster.shutdown()
        self._thread.shutdown()
        for folder in self._folders:
            shutil.rmtree(folder, ignore_errors=True)


_clusters = []


def cluster(count=1):
    """The cluster of this process, which lasts as long as it."""
    if not _clusters:
        _clusters.append(Cluster())
    _clusters[0].add(count)
    return _clusters[0]


def end_clusters():
    while _clusters:
        _clusters.pop().close()


def machines(kind, count=1):
    """Where hosts run."""
    if kind == "hosted":
        return Machines(count)
    from service.jobs.hosts.ray_hosts import RayHosts

    return RayHosts(cluster(count).address)


def workers(kind, preload, terms, hosts=1, made=None):
    """Workers of a kind, so many as there are terms on each host; `made` gets what hosts run on."""
    if kind == "local":
        return [ProcessWorker(preload, each) for _ in range(hosts) for each in terms]
    found = machines(kind, hosts)
    if made is not None:
        made.append(found)
    plan = HostPlan(tuple(preload), None, tuple(terms), own_version())
    return [one for _ in range(hosts) for one in RemoteHost(found, plan).workers]


def plain_terms(count):
    return [Terms() for _ in range(count)]
