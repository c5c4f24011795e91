"""Faults: what goes wrong, drawn from a seed, and done to a server while it works."""

import random
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from enum import StrEnum

from sqlalchemy.exc import DBAPIError

from benchmarks.chaos_rounds.databases import Database
from benchmarks.chaos_rounds.fleet import Fleet
from benchmarks.chaos_rounds.keeper import Keeper
from benchmarks.serving.processes import Process


class FaultKind(StrEnum):
    """What can go wrong."""

    WORKER_KILLED = "worker -9"
    WORKER_CRASHED = "worker -11"
    WORKER_STOPPED = "worker stopped"
    WORKER_HUNG = "worker hung"
    FORKSERVER_KILLED = "forkserver -9"
    HOST_KILLED = "host -9"
    NODE_KILLED = "node -9"
    SERVER_KILLED = "server -9"
    LEADER_KILLED = "leader -9"
    FOLLOWER_KILLED = "follower -9"
    ALL_KILLED = "all servers -9"
    SERVER_TOLD = "server TERM"
    SERVER_HURRIED = "server TERM, -9"
    DISK_FULL = "disk full"
    READ_ONLY = "read-only"
    LOCKED = "locked"
    AWAY = "database away"


_WEIGHTS = {
    FaultKind.WORKER_KILLED: 9,
    FaultKind.WORKER_CRASHED: 4,
    FaultKind.WORKER_STOPPED: 4,
    FaultKind.WORKER_HUNG: 1,
    FaultKind.FORKSERVER_KILLED: 1,
    FaultKind.HOST_KILLED: 3,
    FaultKind.NODE_KILLED: 1,
    FaultKind.SERVER_KILLED: 2,
    FaultKind.LEADER_KILLED: 2,
    FaultKind.FOLLOWER_KILLED: 1,
    FaultKind.ALL_KILLED: 1,
    FaultKind.SERVER_TOLD: 2,
    FaultKind.SERVER_HURRIED: 1,
    FaultKind.DISK_FULL: 3,
    FaultKind.READ_ONLY: 2,
    FaultKind.LOCKED: 3,
    FaultKind.AWAY: 1,
}
# How long what does not happen at once lasts [s].
_LASTS = {
    FaultKind.WORKER_STOPPED: (0.2, 8.0),
    # Longer than any plan may take: native code that does not return looks like this from outside,
    # to a cancel and to a time limit, which both have to end the process.
    FaultKind.WORKER_HUNG: (80.0, 100.0),
    # Robots need a second to come to rest.
    FaultKind.SERVER_HURRIED: (0.0, 1.5),
    FaultKind.DISK_FULL: (0.5, 12.0),
    FaultKind.READ_ONLY: (0.5, 8.0),
    FaultKind.LOCKED: (0.5, 14.0),
    FaultKind.AWAY: (0.0, 3.0),
}
# What can happen to one server alone, and to one of several.
_TO_ONE = frozenset({FaultKind.SERVER_KILLED})
_TOLD = frozenset({FaultKind.SERVER_TOLD, FaultKind.SERVER_HURRIED})
_TO_SEVERAL = frozenset({
    FaultKind.LEADER_KILLED,
    FaultKind.FOLLOWER_KILLED,
    FaultKind.ALL_KILLED,
})
# What can happen to workers on other machines.
_ELSEWHERE = frozenset({FaultKind.HOST_KILLED, FaultKind.NODE_KILLED})
_ROLES = {FaultKind.LEADER_KILLED: "leader", FaultKind.FOLLOWER_KILLED: "follower"}
# How often a full disk is a limit on the server's files.
_LIMITED = 0.5


@dataclass(frozen=True)
class Fault:
    """Something that goes wrong.

    Attributes:
        kind: What.
        after: How long after the one before [s].
        lasts: How long [s].
        choice: Which of the processes or servers there are then, or which way of it, 0 to 1.
    """

    kind: FaultKind
    after: float
    lasts: float
    choice: float


def draw(rng: random.Random, count: int, kinds: Sequence[FaultKind]) -> list[Fault]:
    """Return faults of some kinds in the order in which they are to happen."""
    found = []
    for kind in rng.choices(kinds, [_WEIGHTS[kind] for kind in kinds], k=count):
        lasts = rng.uniform(*_LASTS.get(kind, (0.0, 0.0)))
        found.append(Fault(kind, rng.expovariate(1.0), lasts, rng.random()))
    return found


def kinds_of(database: str, engine: str = "process", num_servers: int = 1) -> list[FaultKind]:
    """Return what can go wrong with servers of an engine on a database."""
    left_out = _TO_ONE if num_servers > 1 else _TO_SEVERAL
    # Elsewhere a host is what workers are forked by, and it is lost with them.
    left_out |= _ELSEWHERE if engine == "process" else {FaultKind.FORKSERVER_KILLED}
    left_out |= {FaultKind.AWAY} if database == "sqlite" else set()
    return [kind for kind in FaultKind if kind not in left_out]


class Havoc:
    """Does faults to servers, some beside others, until told to stop.

    Attributes:
        done: How often what has happened.
    """

    def __init__(self, fleet: Fleet, database: Database) -> None:
        """Do nothing yet."""
        self.done: Counter[FaultKind] = Counter()
        self._fleet = fleet
        self._database = database
        self._end = threading.Event()
        self._lasting: list[threading.Thread] = []
        self._one = {kind: threading.Lock() for kind in FaultKind}

    @contextmanager
    def doing(self, faults: list[Fault], slowness: float = 1.0) -> Iterator[None]:
        """Do one fault after another meanwhile; at the end, end what lasts and do no more.

        Args:
            faults: In order.
            slowness: How many times longer than usually it is from one to the next one.
        """
        thread = threading.Thread(target=self._run, args=(faults, slowness))
        thread.start()
        try:
            yield
        finally:
            self._end.set()
            thread.join()

    def is_troubled(self) -> bool:
        """Return whether a fault is there now that may keep a server from its start."""
        return any(thread.is_alive() for thread in self._lasting)

    def _run(self, faults: list[Fault], slowness: float) -> None:
        for fault in faults:
            if self._end.wait(slowness * fault.after):
                break
            self._do(fault)
        for thread in self._lasting:
            thread.join()

    def _do(self, fault: Fault) -> None:
        match fault.kind:
            case FaultKind.WORKER_KILLED:
                self._kill(fault.kind, self._chosen(fault))
            case FaultKind.WORKER_CRASHED:
                self._kill(fault.kind, self._chosen(fault), signal.SIGSEGV)
            case FaultKind.HOST_KILLED:
                self._kill(fault.kind, _one_of(self._fleet.hosts(), fault))
            case FaultKind.NODE_KILLED:
                self._keeper(fault).lose_machine(fault.choice)
                self.done[fault.kind] += 1
            case FaultKind.FORKSERVER_KILLED:
                self._kill(fault.kind, self._keeper(fault).forkserver())
            case kind if kind in _TO_ONE | _TO_SEVERAL | _TOLD:
                self._end_servers(fault)
            case _:
                thread = threading.Thread(target=self._last, args=(fault,), daemon=True)
                self._lasting.append(thread)
                thread.start()

    def _end_servers(self, fault: Fault) -> None:
        """End some servers, and start them again."""
        found = self._servers(fault)
        for keeper in found:
            if fault.kind is FaultKind.SERVER_TOLD:
                keeper.end()
            else:
                keeper.kill(fault.lasts if fault.kind is FaultKind.SERVER_HURRIED else None)
        self.done[fault.kind] += bool(found)
        for keeper in found:
            keeper.start(self.is_troubled)

    def _servers(self, fault: Fault) -> Sequence[Keeper]:
        if fault.kind is FaultKind.ALL_KILLED:
            return self._fleet.keepers
        if role := _ROLES.get(fault.kind):
            return self._fleet.by_role(role)
        return [self._keeper(fault)]

    def _keeper(self, fault: Fault) -> Keeper:
        # Not by its first digit, which decides in which way a disk is full.
        return self._fleet.keepers[int(100 * fault.choice) % len(self._fleet.keepers)]

    def _last(self, fault: Fault) -> None:
        lock = self._one[fault.kind]
        # One worker is stopped beside another; a disk is not full twice.
        is_alone = fault.kind not in {FaultKind.WORKER_STOPPED, FaultKind.WORKER_HUNG}
        with ExitStack() as stack:
            if is_alone:
                stack.enter_context(lock)
            try:
                stack.enter_context(self._trouble(fault))
            except (DBAPIError, OSError):  # the database, or the server, is away
                return
            self.done[fault.kind] += 1
            self._end.wait(fault.lasts)
            stack.pop_all().close()

    def _trouble(self, fault: Fault) -> AbstractContextManager[None]:
        match fault.kind:
            case FaultKind.WORKER_STOPPED | FaultKind.WORKER_HUNG:
                return stopped(self._chosen(fault))
            case FaultKind.DISK_FULL:
                pid = self._keeper(fault).pid
                return self._database.disk.full(pid, is_limit=fault.choice < _LIMITED)
            case FaultKind.READ_ONLY:
                return self._database.read_only()
            case FaultKind.LOCKED:
                return _forgiving(self._database.locked)
            case _:
                return self._database.away()

    def _kill(
        self, kind: FaultKind, process: Process | None, by: signal.Signals = signal.SIGKILL
    ) -> None:
        if process is not None:
            process.send(by)
            self.done[kind] += 1

    def _chosen(self, fault: Fault) -> Process | None:
        """Return one of the processes that run tasks, or that help them."""
        return _one_of(self._fleet.workers(), fault)


def _one_of(found: list[Process], fault: Fault) -> Process | None:
    return found[int(fault.choice * len(found))] if found else None


@contextmanager
def stopped(process: Process | None) -> Iterator[None]:
    """Stop a process for a while: it is there and does nothing."""
    if process is not None:
        process.send(signal.SIGSTOP)
    try:
        yield
    finally:
        if process is not None:
            process.send(signal.SIGCONT)


@contextmanager
def _forgiving(lock: Callable[[], AbstractContextManager[None]]) -> Iterator[None]:
    """Hold a lock that may be lost meanwhile, with its database."""
    with ExitStack() as stack:
        stack.enter_context(lock())
        yield
        with suppress(DBAPIError):
            stack.close()
