"""forkserver(): the process that workers are forked off.

Light: a server starts it before it imports what itself needs.
"""

import gc
import importlib
import logging
import multiprocessing
import multiprocessing.forkserver
import os
import signal
import socket
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import connection, resource_tracker
from typing import Any, Never

# What `multiprocessing` knows of its one forkserver; it has no public way to have another one.
_STATE: Any = multiprocessing.forkserver._forkserver  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
# Which has names that are not declared.
_CONNECTION: Any = connection
# Numbers of those that were replaced.
_former: list[int] = []
# What it imports before anything else: from there on it does not look for garbage.
_FIRST = ("service.jobs.worker.disable_gc", "service.jobs.worker.main")
_log = logging.getLogger(__name__)


def forkserver(preload: Sequence[str]) -> Any:
    """Return the context that forks workers off a server which has imported some modules.

    There is one such server per process: the modules that are named first count.
    """
    context: Any = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*_FIRST, *preload])
    return context


def start_forkserver(preload: Sequence[str], common: Sequence[str]) -> None:
    """Have the forkserver import while this process does; without effect once it runs.

    What both need is imported first, once, and the forkserver begins as a copy of this process:
    half a second of processor time less. A copy has but the thread that makes it, so where there
    are others, or no Linux, multiprocessing starts it from nothing, as it does a later one.

    Args:
        preload: As for `forkserver`.
        common: Modules that this process needs as well; they start no threads.
    """
    forkserver(preload)
    if forkserver_pid() is not None:
        return
    if sys.platform == "linux" and threading.active_count() == 1:
        gc.disable()  # as in `disable_gc`
        for name in common:
            importlib.import_module(name)
        _begin_as_copy([*_FIRST, *preload])
        gc.enable()
    else:
        multiprocessing.forkserver.ensure_running()


def _begin_as_copy(preload: Sequence[str]) -> None:
    """Begin as `multiprocessing` does (`ForkServer.ensure_running`), but by a fork of our own."""
    resource_tracker.ensure_running()
    address = _CONNECTION.arbitrary_address("AF_UNIX")  # in a folder that is this user's alone
    with _STATE._lock, socket.socket(socket.AF_UNIX) as listener:  # noqa: SLF001
        listener.bind(address)
        listener.listen()
        held, lifeline = os.pipe()
        pid = os.fork()
        if pid == 0:
            os.close(lifeline)  # or it would never see that all others have closed theirs
            _serve(listener.detach(), held, preload)
        os.close(held)
        _STATE._forkserver_address = address  # noqa: SLF001
        _STATE._forkserver_alive_fd = lifeline  # noqa: SLF001
        _STATE._forkserver_pid = pid  # noqa: SLF001


def _serve(listener: int, held: int, preload: Sequence[str]) -> Never:
    """Be the forkserver until all that use it have gone; nothing of the copy goes on then."""
    try:
        multiprocessing.forkserver.main(listener, held, preload)
    except SystemExit:
        os._exit(0)
    except BaseException:  # noqa: BLE001  (the process ends)
        _log.critical("the forkserver ends", exc_info=True)
    os._exit(1)


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
