"""Slot: one warm process that runs one task at a time and can be ended at any moment."""

import asyncio
import multiprocessing
import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from concurrent.futures import TimeoutError as FutureTimeoutError
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection  # noqa: TC003  (read at run time by tests)
from typing import Any, Protocol

from pebble import ProcessExpired, ProcessPool

from service.jobs.outcome import Crashed, Ended, Outcome, TimedOut
from service.jobs.worker import do_nothing, prepare, run_in_process

type OnEvent = Callable[[str, dict[str, Any]], None]


@dataclass(frozen=True)
class Run:
    """One run of a task.

    Attributes:
        task: `module:function`.
        payload: What it is called with.
        on_event: Told of each of its events, in the event loop's thread.
        allowed: Seconds after which it is ended, or None.
    """

    task: str
    payload: dict[str, Any]
    on_event: OnEvent
    allowed: float | None = None


class Slot(Protocol):
    """Where tasks run, one at a time."""

    warm_key: str | None

    async def run(self, run: Run) -> Outcome:
        """Run a task to its end, whatever that is."""
        ...

    def cancel(self, grace: float) -> None:
        """Ask the present run to end; end it by force after `grace` seconds."""
        ...

    async def close(self) -> None:
        """End the slot and what runs in it."""
        ...


class ProcessSlot:
    """A slot that is a process of its own: a single-worker pool of pebble's, on a forkserver."""

    def __init__(self, preload: Sequence[str]) -> None:
        """Prepare; the process starts with the first run.

        Args:
            preload: Modules that the forkserver imports once, so that new workers are warm.
        """
        self.warm_key: str | None = None
        self._context: Any = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload(list(preload))
        self._token = 0
        self._first_sign: Any = None
        self._future: Any = None
        self._was_canceled = False
        self._kill_timer: asyncio.TimerHandle | None = None
        self._on_event: OnEvent | None = None
        self._parts: list[bytes] = []
        self._pool: Any = None  # pebble's, or None while there is no process
        self._open_pipes()

    async def run(self, run: Run) -> Outcome:
        """Run a task to its end; a worker that dies is replaced before the next run."""
        self._token += 1
        self._on_event, self._parts, self._was_canceled = run.on_event, [], False
        try:
            await self._start(run)
            return Ended() if self._future is None else await asyncio.wrap_future(self._future)
        except FutureTimeoutError:
            return TimedOut(run.allowed or 0.0)
        except ProcessExpired as expired:
            await self._close_pool()
            return Ended() if self._was_canceled else Crashed(expired.exitcode)
        except (CancelledError, asyncio.CancelledError):
            if not self._was_canceled:
                raise
            return Ended()
        except (RuntimeError, OSError, EOFError):
            # The pool is broken: its worker was killed while it had nothing to do.
            await self._close_pool()
            return Crashed(None)
        finally:
            self._drain()
            self._future, self._on_event = None, None
            if self._kill_timer is not None:
                self._kill_timer.cancel()

    async def _start(self, run: Run) -> None:
        """Hand a task to the process, unless it is canceled before there is one."""
        if self._pool is None or not self._pool.active:
            # A first process may have to import much: the event loop goes on meanwhile.
            await asyncio.to_thread(self._open_pool)
        if not self._was_canceled:
            pool: Any = self._pool
            arguments = [run.task, run.payload, self._token]
            self._future = pool.schedule(run_in_process, args=arguments, timeout=run.allowed)

    def cancel(self, grace: float) -> None:
        """Tell the task, and end its process if it has not ended by itself in time."""
        if self._on_event is None or self._was_canceled:
            return
        self._was_canceled = True
        if self._future is None:
            return  # its process is still being started, and will not be used
        self._control_out.send_bytes(self._token.to_bytes(8))
        loop = asyncio.get_running_loop()
        self._kill_timer = loop.call_later(grace, self._future.cancel)

    async def close(self) -> None:
        """End the process, whatever it does."""
        self._was_canceled = True
        for future in (self._first_sign, self._future):
            if future is not None:
                future.cancel()
        await self._close_pool()
        self._close_pipes()

    def _open_pool(self) -> None:
        """Make a pool and wait until its process has started."""
        self._pool = ProcessPool(
            max_workers=1,
            context=self._context,
            initializer=prepare,
            initargs=[self._event_out, self._control_in, self._guard_in],
        )
        self._first_sign = self._pool.schedule(do_nothing)
        with suppress(CancelledError):
            self._first_sign.result()

    async def _close_pool(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.stop()
            await asyncio.to_thread(pool.join)

    def _open_pipes(self) -> None:
        self._event_in, self._event_out = self._context.Pipe(duplex=False)
        self._control_in, self._control_out = self._context.Pipe(duplex=False)
        self._guard_in, self._guard_out = self._context.Pipe(duplex=False)
        asyncio.get_running_loop().add_reader(self._event_in.fileno(), self._drain)

    def _close_pipes(self) -> None:
        asyncio.get_running_loop().remove_reader(self._event_in.fileno())
        pipes: list[Connection] = [
            self._event_in,
            self._event_out,
            self._control_in,
            self._control_out,
            self._guard_in,
            self._guard_out,
        ]
        for pipe in pipes:
            pipe.close()

    def _drain(self) -> None:
        """Read what has come; what an earlier run left behind is dropped."""
        while self._event_in.poll(0):
            message = self._event_in.recv_bytes()
            if int.from_bytes(message[:8]) != self._token or self._on_event is None:
                continue
            self._parts.append(message[9:])
            if message[8]:
                whole, self._parts = b"".join(self._parts), []
                event_type, data = pickle.loads(whole)  # noqa: S301  (our own worker wrote it)
                self._on_event(event_type, data)
