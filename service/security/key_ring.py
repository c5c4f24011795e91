"""KeyRing: the keys of the database as a running server has them, read anew once a second.

A request waits for the database for half a second at most: what stops a robot is to work while the
database is locked or away. Until it answers again the keys that were read last are good.
"""

import asyncio
import logging
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from time import monotonic

from anyio import to_thread
from sqlalchemy.exc import SQLAlchemyError

from service.jobs.store.sql.database import keep_off_loops, open_engine
from service.security.keys import ApiKey, KeyStore, find_key

# How old what is known may be, and how long a request waits for something newer [s].
_PERIOD, _PATIENCE = 1.0, 0.5
_log = logging.getLogger(__name__)


class KeyRing:
    """Finds keys for requests."""

    def __init__(self, store: KeyStore, clock: Callable[[], float] = monotonic) -> None:
        """Read from `store`; call `read` before use."""
        self._store = store
        self._clock = clock
        self._keys = dict[str, ApiKey]()
        self._read_at = 0.0
        self._reading: asyncio.Task[None] | None = None

    async def find(self, text: str) -> ApiKey | None:
        """Return the valid key that a text is, None if it is none."""
        if self._clock() - self._read_at >= _PERIOD:
            await self._renew()
        key = find_key(text, self._keys)
        return key if key is not None and key.is_valid(datetime.now(UTC)) else None

    def is_good(self, key: ApiKey) -> bool:
        """Return whether a key that was found is still valid, as far as is known; wait for nothing.

        What is known is read anew meanwhile, if it is old.
        """
        if self._clock() - self._read_at >= _PERIOD:
            self._begin_to_read()
        known = self._keys.get(key.id)
        return known is not None and known.is_valid(datetime.now(UTC))

    @property
    def has_valid(self) -> bool:
        """Whether there is a valid key among those that were read."""
        now = datetime.now(UTC)
        return any(key.is_valid(now) for key in self._keys.values())

    async def read(self) -> None:
        """Read all keys.

        Raises:
            SQLAlchemyError: The database does not answer.
        """
        begun = self._clock()
        found = await to_thread.run_sync(self._store.all, abandon_on_cancel=True)
        self._keys, self._read_at = {key.id: key for key in found}, begun

    async def close(self) -> None:
        """Read no more."""
        if self._reading is not None:
            self._reading.cancel()
            with suppress(asyncio.CancelledError):
                await self._reading

    async def _renew(self) -> None:
        """Read all keys, once for all requests that wait for it, if that takes no time."""
        await asyncio.wait({self._begin_to_read()}, timeout=_PATIENCE)

    def _begin_to_read(self) -> asyncio.Task[None]:
        if self._reading is None or self._reading.done():
            self._reading = asyncio.get_running_loop().create_task(self._try_to_read())
        return self._reading

    async def _try_to_read(self) -> None:
        try:
            await self.read()
        except SQLAlchemyError as fault:
            self._read_at = self._clock()  # and not again with every request
            kind = type(fault).__name__
            _log.warning("keys could not be read (%s): those that were read last hold", kind)


@asynccontextmanager
async def open_key_ring(url: str) -> AsyncGenerator[KeyRing]:
    """Lend the keys of the database at a URL."""
    engine = open_engine(url)
    keep_off_loops(engine)
    store = KeyStore(engine)
    ring = KeyRing(store)
    try:
        await to_thread.run_sync(store.open)
        await ring.read()
        if not ring.has_valid:
            _log.warning("no key is valid yet, so nothing is let in: `wayproof keys create`")
        yield ring
    finally:
        await ring.close()
        await to_thread.run_sync(engine.dispose)
