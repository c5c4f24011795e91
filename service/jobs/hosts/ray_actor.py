"""HostActor: what Ray runs on each machine, a process with the workers of that machine.

Ray starts it, carries bytes to it and from it, and ends it; it does nothing else.
"""

import os
import sys
from dataclasses import replace
from typing import Any

from service.jobs.hosts.host import WorkerHost
from service.jobs.hosts.plan import HostPlan, own_version

# What joins a cluster must not be known to processes that read what strangers wrote.
_SECRETS = ("RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH")


class HostActor:
    """An async actor; arguments and answers are bytes, which Ray passes on as they are."""

    def __init__(self) -> None:
        """Have no workers yet."""
        self._host: WorkerHost | None = None

    async def begin(self, plan: bytes) -> bytes:
        """Start the workers, if this is the version that the dispatcher has; return which it is."""
        told = HostPlan.loaded(plan)
        if told.version == own_version():
            _make_main_light()
            for name in _SECRETS:
                os.environ.pop(name, None)
            # A machine may have a folder of its own, as its operator told Ray when it was started.
            folder = os.environ.get("WAYPROOF_DATA_DIR", told.folder)
            self._host = WorkerHost(replace(told, folder=folder), on_abandoned=_exit)
            await self._host.open()
        return own_version().encode()

    async def deliver(self, batch: bytes) -> None:
        """Take messages of the dispatcher."""
        if self._host is not None:
            self._host.deliver(batch)

    async def collect(self) -> bytes:
        """Return what the workers have to say."""
        return b"" if self._host is None else await self._host.collect()

    async def end(self) -> None:
        """End the workers and what runs in them."""
        if self._host is not None:
            await self._host.close()


def _make_main_light() -> None:
    """Have workers not import Ray's own program, which multiprocessing would take for theirs.

    What a forked process imports as `__main__` is the file or the module that its parent says.
    """
    main: Any = sys.modules["__main__"]
    main.__file__ = None
    main.__spec__ = None


def _exit() -> None:
    os._exit(0)
