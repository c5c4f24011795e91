"""GroupCommit: one thread that writes to the store for coroutines, many writes a transaction.

What waits while a transaction is on its way to the disk goes into the next one together: a disk
that takes milliseconds to be sure slows each job, not their number.
"""

import asyncio
import logging
import queue
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic
from typing import Any

from service.jobs.errors import DatabaseUnavailable
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import is_of_database

_MAX_BATCH = 64
# When what is owed to the disk is given to it: after such a lull, at the latest after so long, and
# again so long after the database refused it [s].
_LULL, _MAX_UNFLUSHED, _AGAIN = 0.01, 0.05, 1.0
_log = logging.getLogger(__name__)
# How long to wait before a database that refused is asked again, and again [s].
_PAUSES = (0.1, 0.3, 1.0, 3.0)


@dataclass(eq=False)
class _PendingWrite:
    """A write; until it is about to be committed it may be withdrawn."""

    work: Callable[[], Any]
    done: asyncio.Future[Any]
    is_durable: bool
    is_owed: bool = False
    is_withdrawn: bool = False
    is_sealed: bool = False


class _Withdrawn(Exception):
    """One of the writes of a transaction was withdrawn."""


class GroupCommit:
    """Carries out writes in the order in which they came."""

    def __init__(self, store: JobStore, *, pauses: Sequence[float] = _PAUSES) -> None:
        """Write to `store`, from the running loop.

        Args:
            store: Where to write.
            pauses: Before a write that the database did not take is tried again, one a try [s].
        """
        self._store = store
        self._pauses = pauses
        self._loop = asyncio.get_running_loop()
        self._closing = threading.Event()
        self._sealing = threading.Lock()
        self._pending: queue.SimpleQueue[_PendingWrite | None] = queue.SimpleQueue()
        self._unflushed_since: float | None = None
        self._lull = _LULL
        self._thread = threading.Thread(target=self._serve, name="job-writer", daemon=True)
        self._thread.start()

    async def execute[T](
        self,
        work: Callable[[], T],
        *,
        is_durable: bool = True,
        is_owed: bool = False,
        within: float | None = None,
    ) -> T:
        """Carry out a write; it is committed when this returns.

        Args:
            work: Calls methods of the store; called again if the database did not take it.
            is_durable: Whether it must survive a power cut.
            is_owed: Whether it is to survive one that comes a moment later, if it must not at once.
            within: How long to wait [s]; what is not committed by then never is.

        Raises:
            DatabaseUnavailable: The database did not take it in that time.
        """
        done: asyncio.Future[T] = self._loop.create_future()
        write = _PendingWrite(work, done, is_durable, is_owed)
        self._pending.put(write)
        if within is not None:
            try:
                await asyncio.wait({done}, timeout=within)
            except asyncio.CancelledError:  # the caller waits no longer
                done.cancel()
                raise
            if not done.done() and self._withdraw(write):
                raise DatabaseUnavailable.of(within)
        return await done

    async def close(self) -> None:
        """Carry out what has come, if the database takes it now, and no more."""
        self._closing.set()
        self._pending.put(None)
        await asyncio.to_thread(self._thread.join)

    def _serve(self) -> None:
        with self._store.keeping_connection():
            self._serve_until_closed()

    def _serve_until_closed(self) -> None:
        is_open = True
        while is_open:
            writes = self._next()
            is_open = None not in writes
            self._commit_all([write for write in writes if write is not None])
            if self._unflushed_since is not None and (
                not writes or not is_open or monotonic() > self._unflushed_since + _MAX_UNFLUSHED
            ):
                self._flush()

    def _next(self) -> list[_PendingWrite | None]:
        """Wait for writes, and return them; none if a debt comes first."""
        writes: list[_PendingWrite | None] = []
        with suppress(queue.Empty):
            writes.append(self._pending.get(timeout=self._lull if self._unflushed_since else None))
            while len(writes) < _MAX_BATCH:
                writes.append(self._pending.get_nowait())
        return writes

    def _flush(self) -> None:
        """Have the disk take what was committed and not flushed."""
        self._unflushed_since, self._lull = None, _LULL
        try:
            self._store.flush()
        except OSError:
            _log.exception("the disk does not take what was committed")
            self._unflushed_since, self._lull = monotonic(), _AGAIN

    def _note_committed(self, writes: list[_PendingWrite]) -> None:
        """Count what has just been committed together."""
        if any(write.is_durable for write in writes):
            self._unflushed_since = None
        elif self._unflushed_since is None and any(write.is_owed for write in writes):
            self._unflushed_since, self._lull = monotonic(), _LULL

    def _commit_all(self, writes: list[_PendingWrite]) -> None:
        """Write all, and again what the database did not take, a few times."""
        for pause in (*self._pauses, None):
            writes = [write for write in writes if not write.is_withdrawn]
            refused = self._write(writes) if writes else []
            if pause is None or self._closing.is_set():
                self._answer([(write.done, None, fault) for write, fault in refused])
                return
            writes = [write for write, _ in refused]
            if not writes:
                return
            self._closing.wait(pause)

    def _write(self, writes: list[_PendingWrite]) -> list[tuple[_PendingWrite, Exception]]:
        """Write all in one transaction, else each on its own; return what the database refused."""
        if len(writes) == 1:
            return self._write_each(writes)
        try:
            with self._store.transaction(is_durable=any(write.is_durable for write in writes)):
                results = [write.work() for write in writes]
                self._seal(writes)
        except Exception:  # noqa: BLE001  (whose fault it is comes out one by one)
            return self._write_each(writes)
        self._note_committed(writes)
        answers = zip(writes, results, strict=True)
        self._answer([(write.done, result, None) for write, result in answers])
        return []

    def _write_each(self, writes: list[_PendingWrite]) -> list[tuple[_PendingWrite, Exception]]:
        for i, write in enumerate(writes):
            write.is_sealed = False
            try:
                with self._store.transaction(is_durable=write.is_durable):
                    result = write.work()
                    self._seal([write])
            except _Withdrawn:
                continue
            except Exception as fault:  # noqa: BLE001  (its caller gets it)
                if is_of_database(fault):
                    # A locked one refuses the others too, after a long wait each; a full one may
                    # have room for what is smaller: the next time another is the first.
                    rest = [*writes[i + 1 :], write]
                    for other in rest:
                        other.is_sealed = False
                    return [(other, fault) for other in rest]
                self._answer([(write.done, None, fault)])
            else:
                self._note_committed([write])
                self._answer([(write.done, result, None)])
        return []

    def _seal(self, writes: list[_PendingWrite]) -> None:
        """Go on to the commit only if nothing was withdrawn; nothing is from now on.

        Raises:
            _Withdrawn: Something was.
        """
        with self._sealing:
            if any(write.is_withdrawn for write in writes):
                raise _Withdrawn
            for write in writes:
                write.is_sealed = True

    def _withdraw(self, write: _PendingWrite) -> bool:
        """Have an write never carried out; return whether it is not too late for that."""
        with self._sealing:
            write.is_withdrawn = not write.is_sealed
            return write.is_withdrawn

    def _answer(self, answers: list[tuple[asyncio.Future[Any], Any, Exception | None]]) -> None:
        def settle() -> None:
            for done, result, fault in answers:
                if done.done():
                    continue
                if fault is None:
                    done.set_result(result)
                else:
                    done.set_exception(fault)

        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(settle)
