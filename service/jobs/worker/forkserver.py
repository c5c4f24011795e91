"""forkserver(): the process that workers are forked off.

Light: a server starts it before it imports what itself needs.
"""

import multiprocessing
import multiprocessing.forkserver
import os
import signal
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

# What `multiprocessing` knows of its one forkserver; it has no public way to have another one.
_STATE: Any = multiprocessing.forkserver._forkserver  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
# Numbers of those that were replaced.
_former: list[int] = []


def forkserver(preload: Sequence[str]) -> Any:
    """Return the context that forks workers off a server which has imported some modules.

    There is one such server per process: the modules that are named first count.
    """
    context: Any = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([
        "service.jobs.worker.disable_gc",
        "service.jobs.worker.main",
        *preload,
    ])
    return context


def forkserver_pid() -> int | None:
    """Return the number of the forkserver's process; None before it was started."""
    pid: int | None = _STATE._forkserver_pid  # noqa: SLF001
    return pid


def replace_forkserver(pid: int | None) -> None:
    """Have the next process forked off a new forkserver, if the present one is of that number.

    The former one ends with the last process that was forked off it: by it we hear of their ends.
    Called where processes are started, which is one thread.
    """
    with _STATE._lock:  # noqa: SLF001
        if pid is None or forkserver_pid() != pid:
            return
        _reap()
        _former.append(pid)
        os.close(_STATE._forkserver_alive_fd)  # noqa: SLF001
        _STATE._forkserver_address = None  # noqa: SLF001
        _STATE._forkserver_alive_fd = None  # noqa: SLF001
        _STATE._forkserver_pid = None  # noqa: SLF001


def _reap() -> None:
    """Forget former forkservers that have ended."""
    _former[:] = [pid for pid in _former if os.waitpid(pid, os.WNOHANG) == (0, 0)]


def kill_forkserver() -> None:
    """End a forkserver that says nothing, and with it all that was forked off it.

    Who waits for it is told, and the next process that is started is forked off a new one.
    """
    pid = forkserver_pid()
    if pid is not None:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
