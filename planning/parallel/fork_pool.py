"""ForkPool: process pool of forked children, which inherit the loaded world from their parent.

OMPL's random numbers are global to a process, and a world cannot be shared between processes. So
parallel attempts run in forked processes: each inherits the world, the oracle and the constraints
without loading or sending anything. The parent sends task numbers only and receives values. A child
dies with its parent (prctl(2): PR_SET_PDEATHSIG), and every exit from `each` ends all children.
"""

import ctypes
import os
import pickle
import selectors
import signal
import struct
import threading
import warnings
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any, Protocol, runtime_checkable

from planning.domain.request.deadline import Deadline
from planning.errors import WayproofError

_NUMBER = struct.Struct("=I")
_LENGTH = struct.Struct("=Q")
# Task numbers that certainly fit into an unread pipe; the caller runs the remaining tasks.
_MOST_PIECES = 1_000
# Polling interval for cancellation [s].
_POLL = 0.02
# Extra time after the deadline in which children report that they met it [s].
_GRACE = 0.5
_READ = 1 << 16
_PR_SET_PDEATHSIG = 1

type Work = Callable[[int], Any]


@runtime_checkable
class Cores(Protocol):
    """Interface of a pool of CPU cores that limits the number of parallel processes."""

    def lent(self, wanted: int) -> Any:
        """Return a context manager that leases up to `wanted` cores and yields their number."""
        ...


class OwnCores:
    """Fixed number of cores that belong to one process alone."""

    def __init__(self, count: int) -> None:
        """Provide up to `count` cores."""
        self._count = count

    @contextmanager
    def lent(self, wanted: int) -> Generator[int]:
        """Yield the smaller of `wanted` and the number of cores."""
        yield max(0, min(self._count, wanted))


class ForkPool:
    """Pool with one forked child for every leased core, and one for the caller's own core.

    Only a process with one Python thread is forked; with more, the caller does the work itself.
    """

    def __init__(self, processes: int | Cores) -> None:
        """Create a pool of a fixed or of a leased number of processes.

        Args:
            processes: Number of parallel processes; or the pool of cores to lease from, in
                addition to the caller's own core.
        """
        self._cores: Cores = OwnCores(processes - 1) if isinstance(processes, int) else processes

    def each(self, work: Work, count: int, deadline: Deadline) -> Generator[tuple[int, Any]]:
        """Yield (number, outcome) of tasks 0 to count - 1 as they complete.

        The outcome is the value of `work`, or the `WayproofError` that it raised. Not promised:
        every task. Missing are tasks of a child that died, tasks after the deadline, tasks beyond
        `_MOST_PIECES`, and all tasks if no core is free or this process has several threads.

        Raises:
            Canceled: Cancellation was requested.
        """
        count = min(count, _MOST_PIECES)
        if count < 2 or threading.active_count() > 1:
            return
        with self._cores.lent(count - 1) as more:
            if more:
                with _children(work, count, more + 1) as pipes:
                    yield from _arrivals(pipes, deadline)


@contextmanager
def _children(work: Work, count: int, processes: int) -> Generator[list[int]]:
    """Fork children that share the task numbers below `count`; yield the pipes of their results."""
    queue, end = os.pipe()
    os.write(end, b"".join(_NUMBER.pack(k) for k in range(count)))
    os.close(end)
    parent = os.getpid()
    with ExitStack() as cleanup:
        cleanup.callback(os.close, queue)
        pipes: list[int] = []
        with suppress(OSError):  # no more processes available: continue with the ones forked so far
            for _ in range(processes):
                near, far = os.pipe()
                cleanup.callback(os.close, near)
                with ExitStack() as mine:
                    mine.callback(os.close, far)
                    child = fork()
                    if not child:
                        _serve(work, queue, far, parent)
                cleanup.callback(end_fork, child)
                pipes.append(near)
        yield pipes


def fork() -> int:
    """Fork this process, which has one Python thread; return 0 in the child."""
    with warnings.catch_warnings():
        # There is one Python thread; those of the linear algebra library survive forks by its
        # own handlers (pthread_atfork).
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def die_with_parent() -> None:
    """Make this forked process end when its parent ends (prctl(2): PR_SET_PDEATHSIG)."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def end_fork(child: int) -> int:
    """Kill a forked process and return its wait status (waitpid(2)); 0 if that is unknown."""
    with suppress(ProcessLookupError):
        os.kill(child, signal.SIGKILL)
    with suppress(ChildProcessError):
        return os.waitpid(child, 0)[1]
    return 0


def _serve(work: Work, queue: int, far: int, parent: int) -> None:
    """Run tasks from the queue until it is empty, then exit the process; never return."""
    try:
        die_with_parent()
        while os.getppid() == parent and (number := os.read(queue, _NUMBER.size)):
            k: int = _NUMBER.unpack(number)[0]
            try:
                outcome = work(k)
            except WayproofError as error:
                outcome = error
            _send(far, pickle.dumps((k, outcome)))
    except BaseException:  # noqa: BLE001, S110  (the parent repeats missing tasks and reports errors)
        pass
    finally:
        os._exit(0)


def _send(far: int, body: bytes) -> None:
    rest = memoryview(_LENGTH.pack(len(body)) + body)
    while rest:
        rest = rest[os.write(far, rest) :]


def _arrivals(pipes: list[int], deadline: Deadline) -> Generator[tuple[int, Any]]:
    """Yield results until all pipes are closed or the deadline, plus its grace time, is over."""
    with selectors.DefaultSelector() as selector:
        received: dict[int, bytearray] = {pipe: bytearray() for pipe in pipes}
        for pipe in pipes:
            selector.register(pipe, selectors.EVENT_READ)
        while received:
            if deadline.is_canceled():
                deadline.check("search")
            if deadline.clock() > deadline.at + _GRACE:
                deadline.on_cut()
                return
            for key, _ in selector.select(_POLL):
                part = os.read(key.fd, _READ)
                if not part:
                    selector.unregister(key.fd)
                    del received[key.fd]
                    continue
                received[key.fd] += part
                yield from _whole(received[key.fd])


def _whole(received: bytearray) -> Generator[tuple[int, Any]]:
    """Yield the complete messages of a receive buffer and remove them from it."""
    while len(received) >= _LENGTH.size:
        end = _LENGTH.size + _LENGTH.unpack_from(received)[0]
        if len(received) < end:
            return
        body = bytes(received[_LENGTH.size : end])
        del received[:end]
        yield pickle.loads(body)  # noqa: S301  (from a fork of this process)
