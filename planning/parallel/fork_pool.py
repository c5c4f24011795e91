"""ForkPool: attempts in forked processes, which have the loaded world from their parent.

OMPL's random numbers are global to a process, and a world lives in one: so attempts that run at
once are processes, and forking gives each the world, the oracle and the constraints without loading
or sending anything. The parent waits, hands out nothing but numbers, and takes back values. A child
dies with its parent (prctl(2): PR_SET_PDEATHSIG), and every way out of `each` ends all children.
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
# Numbers that certainly fit into a pipe before anybody reads; the caller does the others.
_MOST_PIECES = 1_000
# How soon a cancel is seen [s].
_POLL = 0.02
# What ends by its own deadline is given so much longer to say so [s].
_GRACE = 0.5
_READ = 1 << 16
_PR_SET_PDEATHSIG = 1

type Work = Callable[[int], Any]


@runtime_checkable
class Cores(Protocol):
    """Who says how many processes may work at once."""

    def lent(self, wanted: int) -> Any:
        """Return a context within which so many cores, at most `wanted`, are the asker's."""
        ...


class OwnCores:
    """A fixed number of cores, nobody else's."""

    def __init__(self, count: int) -> None:
        """Lend up to `count`."""
        self._count = count

    @contextmanager
    def lent(self, wanted: int) -> Generator[int]:
        """Lend as many as there are."""
        yield max(0, min(self._count, wanted))


class ForkPool:
    """Forks a child for every core that it is lent besides its own, and one for that.

    Only a process with one Python thread is forked; with more, the caller does the work itself.
    """

    def __init__(self, processes: int | Cores) -> None:
        """Use so many processes, or as many as somebody says.

        Args:
            processes: How many may work at once; or who lends cores, beside the asker's own.
        """
        self._cores: Cores = OwnCores(processes - 1) if isinstance(processes, int) else processes

    def each(self, work: Work, count: int, deadline: Deadline) -> Generator[tuple[int, Any]]:
        """Yield number and outcome of pieces as they are done; those of a child that died are not.

        Raises:
            Canceled: The end was asked for.
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
    """Fork children that share the numbers below `count`; give the pipes that they write to."""
    queue, end = os.pipe()
    os.write(end, b"".join(_NUMBER.pack(k) for k in range(count)))
    os.close(end)
    parent = os.getpid()
    with ExitStack() as cleanup:
        cleanup.callback(os.close, queue)
        pipes: list[int] = []
        with suppress(OSError):  # no more processes: those that there are do it
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
    """Have this process, a fork, end when the one that forked it does."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def end_fork(child: int) -> int:
    """End a forked process, and return how it ended (waitpid(2)); 0 if that is not known."""
    with suppress(ProcessLookupError):
        os.kill(child, signal.SIGKILL)
    with suppress(ChildProcessError):
        return os.waitpid(child, 0)[1]
    return 0


def _serve(work: Work, queue: int, far: int, parent: int) -> None:
    """Do pieces until none is left; never return."""
    try:
        die_with_parent()
        while os.getppid() == parent and (number := os.read(queue, _NUMBER.size)):
            k: int = _NUMBER.unpack(number)[0]
            try:
                outcome = work(k)
            except WayproofError as error:
                outcome = error
            _send(far, pickle.dumps((k, outcome)))
    except BaseException:  # noqa: BLE001, S110  (the parent does what is not done, and says why)
        pass
    finally:
        os._exit(0)


def _send(far: int, body: bytes) -> None:
    rest = memoryview(_LENGTH.pack(len(body)) + body)
    while rest:
        rest = rest[os.write(far, rest) :]


def _arrivals(pipes: list[int], deadline: Deadline) -> Generator[tuple[int, Any]]:
    """Yield what comes until all pipes are closed, or it is late."""
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
    """Yield the messages that have come in full, and take them out."""
    while len(received) >= _LENGTH.size:
        end = _LENGTH.size + _LENGTH.unpack_from(received)[0]
        if len(received) < end:
            return
        body = bytes(received[_LENGTH.size : end])
        del received[:end]
        yield pickle.loads(body)  # noqa: S301  (from a fork of this process)
