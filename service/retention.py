"""Retention: jobs that ended long ago are deleted, with all that was recorded of them.

What is still needed stays, however old it is: regions of the content of a scene, and whatever a
job that waits or runs names.
"""

import asyncio
import logging
import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

from anyio import to_thread
from sqlalchemy import ColumnElement, Connection, select
from sqlalchemy.exc import SQLAlchemyError

from service.jobs.errors import DatabaseTaken
from service.jobs.store.deletion import ENDED, delete_job, named_by_open
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.tables import jobs
from service.scenes.store.records import scenes

# Between two sweeps [s].
_PERIOD = 3600.0
# Others write meanwhile: no transaction takes long.
_JOBS_AT_ONCE = 50
_log = logging.getLogger(__name__)


class Retention:
    """Deletes jobs once an hour, in a thread."""

    def __init__(
        self, store: JobStore, days: float, on_deleted: Callable[[], None] | None = None
    ) -> None:
        """Delete from `store`.

        Args:
            store: Of the records.
            days: For which an ended job is kept; 0 for all time.
            on_deleted: Called after jobs were deleted: files may be needed no more.
        """
        self._store = store
        self._days = days
        self._on_deleted = on_deleted
        self._has_ended = threading.Event()

    async def run(self) -> None:
        """Sweep now and once an hour, until canceled."""
        if self._days == 0:
            return
        try:
            while True:
                await self._sweep()
                await asyncio.sleep(_PERIOD)
        finally:
            self._has_ended.set()

    async def _sweep(self) -> None:
        before = datetime.now(UTC) - timedelta(days=self._days)
        try:
            count = await to_thread.run_sync(self.sweep, before, abandon_on_cancel=True)
        except (SQLAlchemyError, DatabaseTaken):
            _log.exception("jobs that ended before %s could not be deleted", before)
            return
        if count:
            _log.info("deleted %d jobs that ended before %s", count, before)
            if self._on_deleted is not None:
                self._on_deleted()

    def sweep(self, before: datetime) -> int:
        """Delete the jobs that ended before an instant and are not needed; return how many."""
        count = 0
        while not self._has_ended.is_set():
            with self._store.transaction(is_durable=False) as connection:
                old = _old(connection, before, _JOBS_AT_ONCE)
            if not old:
                break
            for identifier in old:
                delete_job(self._store, identifier)
            count += len(old)
        return count


def _old(connection: Connection, before: datetime, most: int) -> list[str]:
    """Return jobs that ended before an instant and are not needed, oldest first."""
    is_old = jobs.c.state.in_(ENDED) & (jobs.c.finished_at < before.isoformat())
    query = select(jobs.c.id).where(is_old, ~_is_needed(connection)).order_by(jobs.c.sequence)
    return list(connection.execute(query.limit(most)).scalars())


def _is_needed(connection: Connection) -> ColumnElement[bool]:
    is_of_scene = jobs.c.world_digest.in_(select(scenes.c.digest))
    are_regions = jobs.c.queue == "regions"
    return (are_regions & is_of_scene) | jobs.c.id.in_(named_by_open(connection))
