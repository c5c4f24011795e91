"""Writer: one thread that writes to the store for coroutines.

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

from service.jobs.database import is_of_database
from service.jobs.errors import DatabaseUnavailable
from service.jobs.store import JobStore

_MAX_BATCH = 64
# When what is owed to the disk is given to it: after such a lull, at the latest after so long, and
# again so long after the database refused it [s].
_LULL, _MAX_UNFLUSHED, _AGAIN = 0.01, 0.05, 1.0
_log = logging.getLogger(__name__)
# How long to wait before a database that refused is asked again, and again [s].
_PAUSES = (0.1, 0.3, 1.0, 3.0)


@dataclass(eq=False)
class _PendingWrite:
    """A write that was asked for; until it is about to be committed it may be withdrawn."""

    work: Callable[[], Any]
    done: asyncio.Future[Any]
    is_durable: bool
    is_owed: bool = False
    is_withdrawn: bool = False
    is_sealed: bool = False


class _Withdrawn(Exception):
    """One of the orders of a transaction is not wanted any more."""


class GroupCommit:
    """Carries out writes in the order in which they were asked for."""

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
        done: asyncio.Future[Any] = self._loop.create_future()
        order = _PendingWrite(work, done, is_durable, is_owed)
        self._pending.put(order)
        try:
            async with asyncio.timeout(within):
                result: T = await asyncio.shield(done)
        except TimeoutError:
            if self._withdraw(order):
                raise DatabaseUnavailable.of(within or 0.0) from None
            result = await done
        except asyncio.CancelledError:  # who asked does not want to know any more
            done.cancel()
            raise
        return result

    async def close(self) -> None:
        """Carry out what was asked for, if the database takes it now, and no more."""
        self._closing.set()
        self._pending.put(None)
        await asyncio.to_thread(self._thread.join)

    def _serve(self) -> None:
        is_open = True
        while is_open:
            orders = self._next()
            is_open = None not in orders
            self._commit_all([order for order in orders if order is not None])
            if self._unflushed_since is not None and (
                not orders or not is_open or monotonic() > self._unflushed_since + _MAX_UNFLUSHED
            ):
                self._flush()

    def _next(self) -> list[_PendingWrite | None]:
        """Wait for orders, and return them; none if a debt comes first."""
        orders: list[_PendingWrite | None] = []
        with suppress(queue.Empty):
            orders.append(self._pending.get(timeout=self._lull if self._unflushed_since else None))
            while len(orders) < _MAX_BATCH:
                orders.append(self._pending.get_nowait())
        return orders

    def _flush(self) -> None:
        """Have the disk take what is owed to it."""
        self._unflushed_since, self._lull = None, _LULL
        try:
            self._store.flush()
        except OSError:
            _log.exception("the disk does not take what was committed")
            self._unflushed_since, self._lull = monotonic(), _AGAIN

    def _note_committed(self, orders: list[_PendingWrite]) -> None:
        """Count what has just been committed together."""
        if any(order.is_durable for order in orders):
            self._unflushed_since = None
        elif self._unflushed_since is None and any(order.is_owed for order in orders):
            self._unflushed_since, self._lull = monotonic(), _LULL

    def _commit_all(self, orders: list[_PendingWrite]) -> None:
        """Write all, and again what the database did not take, a few times."""
        for pause in (*self._pauses, None):
            orders = [order for order in orders if not order.is_withdrawn]
            refused = self._write(orders) if orders else []
            if pause is None or self._closing.is_set():
                self._answer([(order.done, None, fault) for order, fault in refused])
                return
            orders = [order for order, _ in refused]
            if not orders:
                return
            self._closing.wait(pause)

    def _write(self, orders: list[_PendingWrite]) -> list[tuple[_PendingWrite, Exception]]:
        """Write all in one transaction, else each on its own; return what the database refused."""
        if len(orders) == 1:
            return self._write_each(orders)
        try:
            with self._store.transaction(is_durable=any(order.is_durable for order in orders)):
                results = [order.work() for order in orders]
                self._seal(orders)
        except Exception:  # noqa: BLE001  (whose fault it is comes out one by one)
            return self._write_each(orders)
        self._note_committed(orders)
        answers = zip(orders, results, strict=True)
        self._answer([(order.done, result, None) for order, result in answers])
        return []

    def _write_each(self, orders: list[_PendingWrite]) -> list[tuple[_PendingWrite, Exception]]:
        for i, order in enumerate(orders):
            order.is_sealed = False
            try:
                with self._store.transaction(is_durable=order.is_durable):
                    result = order.work()
                    self._seal([order])
            except _Withdrawn:
                continue
            except Exception as fault:  # noqa: BLE001  (who asked for it is told)
                if is_of_database(fault):
                    # A locked one refuses the others too, after a long wait each; a full one may
                    # have room for what is smaller: the next time another is the first.
                    rest = [*orders[i + 1 :], order]
                    for other in rest:
                        other.is_sealed = False
                    return [(other, fault) for other in rest]
                self._answer([(order.done, None, fault)])
            else:
                self._note_committed([order])
                self._answer([(order.done, result, None)])
        return []

    def _seal(self, orders: list[_PendingWrite]) -> None:
        """Go on to the commit only if all is wanted still; nothing is withdrawn from now on.

        Raises:
            _Withdrawn: Something is not.
        """
        with self._sealing:
            if any(order.is_withdrawn for order in orders):
                raise _Withdrawn
            for order in orders:
                order.is_sealed = True

    def _withdraw(self, order: _PendingWrite) -> bool:
        """Have an order never carried out; return whether it is not too late for that."""
        with self._sealing:
            order.is_withdrawn = not order.is_sealed
            return order.is_withdrawn

    def _answer(self, answers: list[tuple[asyncio.Future[Any], Any, Exception | None]]) -> None:
        def settle() -> None:
            for done, result, fault in answers:
                if done.done():
                    continue
                if fault is None:
                    done.set_result(result)
                else:
                    done.set_exception(fault)

        with suppress(RuntimeError):  # the loop is closed: nobody waits
            self._loop.call_soon_threadsafe(settle)
