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
_MAX_TASKS = 1_000
# Polling interval for cancellation [s].
_POLL_INTERVAL = 0.02
# Extra time after the deadline in which children report that they met it [s].
_GRACE_PERIOD = 0.5
_READ_SIZE = 1 << 16
_PR_SET_PDEATHSIG = 1

type Work = Callable[[int], Any]


@runtime_checkable
class Cores(Protocol):
    """Interface of a pool of CPU cores that limits the number of parallel processes."""

    def lease(self, max_cores: int) -> Any:
        """Return a context manager that leases up to `max_cores` cores and yields their number."""
        ...


class FixedCores:
    """Fixed number of cores that belong to one process alone."""

    def __init__(self, count: int) -> None:
        """Provide up to `count` cores."""
        self._count = count

    @contextmanager
    def lease(self, max_cores: int) -> Generator[int]:
        """Yield the smaller of `max_cores` and the number of cores."""
        yield max(0, min(self._count, max_cores))


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
        self._cores: Cores = FixedCores(processes - 1) if isinstance(processes, int) else processes

    def each(self, work: Work, count: int, deadline: Deadline) -> Generator[tuple[int, Any]]:
        """Yield (number, outcome) of tasks 0 to count - 1 as they complete.

        The outcome is the value of `work`, or the `WayproofError` that it raised. Not promised:
        every task. Missing are tasks of a child that died, tasks after the deadline, tasks beyond
        `_MAX_TASKS`, and all tasks if no core is free or this process has several threads.

        Raises:
            Canceled: Cancellation was requested.
        """
        count = min(count, _MAX_TASKS)
        if count < 2 or threading.active_count() > 1:
            return
        with self._cores.lease(count - 1) as num_leased:
            if num_leased:
                with _fork_children(work, count, num_leased + 1) as pipes:
                    yield from _receive_results(pipes, deadline)


@contextmanager
def _fork_children(work: Work, count: int, processes: int) -> Generator[list[int]]:
    """Fork children that share the task numbers below `count`; yield the pipes of their results."""
    queue, queue_writer = os.pipe()
    os.write(queue_writer, b"".join(_NUMBER.pack(k) for k in range(count)))
    os.close(queue_writer)
    parent = os.getpid()
    with ExitStack() as cleanup:
        cleanup.callback(os.close, queue)
        pipes: list[int] = []
        with suppress(OSError):  # no more processes available: continue with the ones forked so far
            for _ in range(processes):
                result_reader, result_writer = os.pipe()
                cleanup.callback(os.close, result_reader)
                with ExitStack() as writer_cleanup:
                    writer_cleanup.callback(os.close, result_writer)
                    child = fork()
                    if not child:
                        _run_child(work, queue, result_writer, parent)
                cleanup.callback(end_fork, child)
                pipes.append(result_reader)
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


def _run_child(work: Work, queue: int, result_writer: int, parent: int) -> None:
    """Run tasks from the queue until it is empty, then exit the process; never return."""
    try:
        die_with_parent()
        while os.getppid() == parent and (number := os.read(queue, _NUMBER.size)):
            k: int = _NUMBER.unpack(number)[0]
            try:
                outcome = work(k)
            except WayproofError as error:
                outcome = error
            _send(result_writer, pickle.dumps((k, outcome)))
    except BaseException:  # noqa: BLE001, S110  (the parent repeats missing tasks and reports errors)
        pass
    finally:
        os._exit(0)


def _send(result_writer: int, body: bytes) -> None:
    unsent = memoryview(_LENGTH.pack(len(body)) + body)
    while unsent:
        unsent = unsent[os.write(result_writer, unsent) :]


def _receive_results(pipes: list[int], deadline: Deadline) -> Generator[tuple[int, Any]]:
    """Yield results until all pipes are closed or the deadline, plus its grace time, is over."""
    with selectors.DefaultSelector() as selector:
        received: dict[int, bytearray] = {pipe: bytearray() for pipe in pipes}
        for pipe in pipes:
            selector.register(pipe, selectors.EVENT_READ)
        while received:
            if deadline.is_canceled():
                deadline.check("search")
            if deadline.clock() > deadline.expires_at + _GRACE_PERIOD:
                deadline.on_expiry()
                return
            for key, _ in selector.select(_POLL_INTERVAL):
                chunk = os.read(key.fd, _READ_SIZE)
                if not chunk:
                    selector.unregister(key.fd)
                    del received[key.fd]
                    continue
                received[key.fd] += chunk
                yield from _complete_messages(received[key.fd])


def _complete_messages(received: bytearray) -> Generator[tuple[int, Any]]:
    """Yield the complete messages of a receive buffer and remove them from it."""
    while len(received) >= _LENGTH.size:
        end = _LENGTH.size + _LENGTH.unpack_from(received)[0]
        if len(received) < end:
            return
        body = bytes(received[_LENGTH.size : end])
        del received[:end]
        yield pickle.loads(body)  # noqa: S301  (from a fork of this process)
