"""JobRecorder: what happens to jobs goes to the table and then to those who follow.

What a server does never waits for the database: a run hears first. What the database does not
take is kept, and written when it takes it again; meanwhile `unrecorded` says what it lacks.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Sequence
from functools import partial

from service.jobs.errors import DatabaseTaken
from service.jobs.event_bus import EventBus
from service.jobs.job import LoggedEvent, PendingEvent
from service.jobs.store.group_commit import GroupCommit
from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import is_of_database
from service.jobs.store.transitions import Transition

# Before what the database refused is written again [s].
_PAUSE = 1.0
_log = logging.getLogger(__name__)


class JobRecorder:
    """Writes to the store for coroutines of one event loop, and publishes what was written."""

    def __init__(
        self, store: JobStore, bus: EventBus[LoggedEvent], on_taken: Callable[[], None]
    ) -> None:
        """Begin.

        Args:
            store: Where to write.
            bus: Who follows.
            on_taken: Called when another server has taken the database over.
        """
        self.store = store
        self._bus = bus
        self._on_taken = on_taken
        self._commits = GroupCommit(store)
        self._unrecorded: dict[str, list[str]] = {}

    def unrecorded(self, identifier: str) -> list[str]:
        """Return what has happened to a job and is not in the database yet."""
        return list(dict.fromkeys(self._unrecorded.get(identifier, ())))

    async def write[T](
        self,
        work: Callable[[], T],
        *,
        is_durable: bool = True,
        is_owed: bool = False,
        within: float | None = None,
    ) -> T:
        """Carry out a write; it is committed when this returns.

        Args:
            work: Calls methods of the store.
            is_durable: Whether it must survive a power cut.
            is_owed: Whether it is to survive one that comes a moment later, if it must not at once.
            within: How long to wait [s]; what is not committed by then never is.

        Raises:
            DatabaseUnavailable: The database did not take it in that time.
            DatabaseTaken: Another server has the database.
            DBAPIError: The database did not take it.
        """
        try:
            return await self._commits.execute(
                work, is_durable=is_durable, is_owed=is_owed, within=within
            )
        except DatabaseTaken:
            self._on_taken()
            raise

    async def apply(
        self,
        identifier: str,
        change: Callable[[], Transition | None],
        *,
        events: Sequence[PendingEvent] = (),
        is_durable: bool = True,
        is_owed: bool = False,
    ) -> Transition | None:
        """Change the state of a job, and publish that; raises as `write`.

        Args:
            identifier: Of the job.
            change: Changes it in the store.
            events: Its events before, which are not recorded yet.
            is_durable: As for `write`.
            is_owed: As for `write`.
        """

        def both() -> tuple[list[LoggedEvent], Transition | None]:
            return self.store.append_events(identifier, events), change()

        logged, transition = await self.write(both, is_durable=is_durable, is_owed=is_owed)
        if transition is not None:
            logged = [*logged, *transition.events_before, transition.event]
        self.publish(identifier, logged)
        return transition

    async def append_events(
        self, identifier: str, events: Sequence[PendingEvent], *, may_wait: bool = False
    ) -> None:
        """Append events of a job that runs, or waits, and publish them; raises as `write`."""
        work = partial(self.store.append_events, identifier, events, may_wait=may_wait)
        self.publish(identifier, await self.write(work, is_durable=False))

    def publish(self, identifier: str, events: Sequence[LoggedEvent]) -> None:
        """Publish events that have been recorded."""
        self._bus.publish(identifier, events)

    async def write_until_done[T](
        self, identifier: str, what: str, work: Callable[[], Awaitable[T]]
    ) -> T:
        """Write something until the database takes it.

        Args:
            identifier: Of the job.
            what: It is, for `unrecorded`.
            work: Writes once; raises as `write`.
        """
        missing = self._unrecorded.setdefault(identifier, [])
        missing.append(what)
        try:
            while True:
                try:
                    return await work()
                except Exception as fault:
                    if not is_of_database(fault):
                        raise
                    _log.error("%s of %s is not recorded yet: %s", what, identifier, fault)
                await asyncio.sleep(_PAUSE)
        finally:
            missing.remove(what)
            if not missing and self._unrecorded.get(identifier) is missing:
                del self._unrecorded[identifier]

    async def close(self) -> None:
        """Write what has come, if the database takes it now."""
        await self._commits.close()
