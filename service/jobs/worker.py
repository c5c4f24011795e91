"""What runs in a slot's process. Light: forkserver imports it before any task."""

import fcntl
import importlib
import json
import os
import pickle
import signal
import traceback
from multiprocessing.connection import Connection
from typing import Any

from planning.errors import WayproofError
from service.jobs.errors import InternalError
from service.jobs.outcome import Outcome, Raised, Returned

# A pipe keeps writes up to 4096 bytes whole, also those of a process that is killed.
_CHUNK = 3500


class PipeChannel:
    """The task's end of its slot: events go out by a pipe, a cancel comes in by another."""

    def __init__(self, token: int, outgoing: Connection, incoming: Connection) -> None:
        """Speak for the run that `token` numbers."""
        self._token = token
        self._outgoing = outgoing
        self._incoming = incoming
        self._is_canceled = False

    def emit(self, event_type: str, data: dict[str, Any]) -> None:
        """Send an event, in pieces that are written whole."""
        message = pickle.dumps((event_type, data))
        for begin in range(0, len(message), _CHUNK):
            part = message[begin : begin + _CHUNK]
            is_last = begin + _CHUNK >= len(message)
            self._outgoing.send_bytes(self._token.to_bytes(8) + bytes([is_last]) + part)

    def is_canceled(self) -> bool:
        """Return whether somebody asked for the end of this run."""
        while not self._is_canceled and self._incoming.poll(0):
            self._is_canceled = int.from_bytes(self._incoming.recv_bytes()) == self._token
        return self._is_canceled


class _Pipes:
    """The pipes of this process, set once by `prepare`."""

    outgoing: Connection
    incoming: Connection
    guard: Connection


def prepare(outgoing: Connection, incoming: Connection, guard: Connection) -> None:
    """Make this process die when it should: at SIGTERM at once, and with its parent.

    A Python signal handler cannot run while C++ holds the interpreter, and neither can a thread;
    default actions of signals can. The parent holds the other end of `guard`: when the parent
    dies the kernel sends SIGIO, whose default action ends this process.
    """
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _Pipes.outgoing, _Pipes.incoming, _Pipes.guard = outgoing, incoming, guard
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    descriptor = guard.fileno()
    fcntl.fcntl(descriptor, fcntl.F_SETOWN, os.getpid())
    flags = fcntl.fcntl(descriptor, fcntl.F_GETFL)
    fcntl.fcntl(descriptor, fcntl.F_SETFL, flags | os.O_ASYNC | os.O_NONBLOCK)


def do_nothing() -> None:
    """Return, as a sign that the process is there."""


def run_in_process(task: str, payload: dict[str, Any], token: int) -> Outcome:
    """Run a task in this slot's process."""
    return run_task(task, payload, PipeChannel(token, _Pipes.outgoing, _Pipes.incoming))


def run_task(task: str, payload: dict[str, Any], channel: Any) -> Outcome:
    """Call `module:function` and say how it ended; what it should not raise is an InternalError."""
    try:
        result = load_task(task)(payload, channel)
        json.dumps(result)
        return Returned(result)
    except WayproofError as error:
        return Raised(error)
    except (SystemExit, KeyboardInterrupt) as exit_:
        return Raised(_internal(exit_, "the task tried to end its process"))
    except Exception as fault:  # noqa: BLE001  (the last edge: nothing may be lost)
        return Raised(_internal(fault, "the task failed in a way that is our fault"))


def load_task(task: str) -> Any:
    """Return the function that `module:function` names."""
    module, _, function = task.partition(":")
    return getattr(importlib.import_module(module), function)


def _internal(fault: BaseException, what: str) -> InternalError:
    lines = traceback.format_exception(fault)[-6:]
    evidence = {"exception": repr(fault)[:500], "traceback": "".join(lines)[-3000:]}
    return InternalError(f"{what}: {type(fault).__name__}: {fault}"[:500], evidence)
