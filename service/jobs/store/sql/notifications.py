"""Notifications: which jobs a transaction has changed, told to the other servers of the database.

PostgreSQL sends them when the transaction is committed, and to those that listen just then (NOTIFY,
LISTEN). They have ids of jobs alone: what has happened is read from the tables.
"""

import asyncio
import logging
from collections.abc import Callable, Collection
from itertools import batched
from typing import Any

from sqlalchemy import Connection, Engine

from service.jobs.store.sql.database import in_transaction

_CHANNEL = "wayproof_jobs"
_CHANGED = "changed_jobs"
# A notification has less than 8,000 bytes.
_IDS_AT_ONCE = 100
# A connection over which nothing comes is noticed to be dead within half a minute (libpq) [s].
_IN_TIME = {
    "connect_timeout": 5,
    "keepalives_idle": 10,
    "keepalives_interval": 5,
    "keepalives_count": 3,
}
# Before a database that is away is asked again [s].
_PAUSE = 0.5
_log = logging.getLogger(__name__)


def note_change(connection: Connection, identifier: str) -> None:
    """Note that the transaction of a connection changes a job."""
    in_transaction(connection, _CHANGED)[identifier] = None


def notify(connection: Connection, sender: str) -> None:
    """Have the commit tell which jobs were changed; only where servers share a database."""
    changed = in_transaction(connection, _CHANGED)
    if connection.dialect.name != "postgresql":
        return
    for some in batched(changed, _IDS_AT_ONCE):
        given = {"channel": _CHANNEL, "payload": " ".join((sender, *some))}
        connection.exec_driver_sql("SELECT pg_notify(%(channel)s, %(payload)s)", given)


def tell(connection: Connection, *names: str) -> None:
    """Have the commit tell all servers, this one too, that what has these names has changed.

    Names are those of streams, see `EventBus.watch`; only where servers share a database.
    """
    if connection.dialect.name == "postgresql":
        given = {"channel": _CHANNEL, "payload": " ".join(("-", *names))}
        connection.exec_driver_sql("SELECT pg_notify(%(channel)s, %(payload)s)", given)


class Listener:
    """Hears which jobs other servers have changed, on a connection of its own."""

    def __init__(
        self, engine: Engine, sender: str, on_change: Callable[[Collection[str] | None], None]
    ) -> None:
        """Prepare.

        Args:
            engine: Of a PostgreSQL database.
            sender: What this server's own notifications begin with.
            on_change: Called with ids of jobs; with None if any may have changed.
        """
        self._engine = engine
        self._sender = sender
        self._on_change = on_change

    async def run(self) -> None:
        """Listen until canceled, also to a database that was away."""
        import psycopg  # noqa: PLC0415  (an extra)

        while True:
            try:
                await self._listen()
            except (psycopg.Error, OSError) as fault:
                _log.warning("other servers are not heard, as the database is away: %s", fault)
            await asyncio.sleep(_PAUSE)

    async def _listen(self) -> None:
        from psycopg import AsyncConnection  # noqa: PLC0415  (an extra)

        _, of_url = self._engine.dialect.create_connect_args(self._engine.url)
        options: dict[str, Any] = {**_IN_TIME, **of_url, "autocommit": True}
        opened = await AsyncConnection.connect(**options)
        async with opened as connection:
            await connection.execute(f"LISTEN {_CHANNEL}")
            self._on_change(None)  # what was told before was not heard
            async for notification in connection.notifies():
                sender, *changed = notification.payload.split()
                if sender != self._sender:
                    self._on_change(changed)
