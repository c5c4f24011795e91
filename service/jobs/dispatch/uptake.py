"""Uptake: what other servers of the database have changed, and who has to know of it here.

A leader runs their jobs, and ends or steers what runs; streams of events look at the log.
"""

import asyncio
import logging
from collections.abc import Callable, Collection

from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from service.jobs.dispatch.attempts import Attempts
from service.jobs.dispatch.recorder import JobRecorder
from service.jobs.dispatch.recovery import Recovery
from service.jobs.dispatch.requests import JobControl
from service.jobs.errors import DatabaseTaken, DatabaseUnavailable
from service.jobs.event_bus import EventBus
from service.jobs.job import CONTROLS, FINISHED, LoggedEvent
from service.jobs.states import JobState
from service.jobs.store.queries import JobMark
from service.jobs.store.sql.database import ask

# Jobs that are read at once: each may be megabytes.
_AT_ONCE = 50
# Before a database that did not answer is asked again [s].
_PAUSE = 1.0
_log = logging.getLogger(__name__)


class Uptake:
    """Hears of changes at any pace, and deals with all that there are by then."""

    def __init__(
        self,
        recorder: JobRecorder,
        bus: EventBus[LoggedEvent],
        attempts: Attempts,
        control: JobControl,
        recovery: Recovery,
    ) -> None:
        """Prepare.

        Args:
            recorder: Of jobs.
            bus: Of those who follow them.
            attempts: Of this server.
            control: Of what runs here.
            recovery: Takes up jobs of the table.
        """
        self._recorder = recorder
        self._store = recorder.store
        self._bus = bus
        self._attempts = attempts
        self._control = control
        self._recovery = recovery
        self._changed: dict[str, None] = {}
        self._may_all_have_changed = False
        self._has_lost_news = False
        self._news = asyncio.Event()

    def note(self, identifiers: Collection[str] | None) -> None:
        """Note that another server has changed jobs; None if nothing was heard for a while."""
        if identifiers is None:
            self._may_all_have_changed = self._has_lost_news = True
            self._bus.wake_all()
        else:
            self._changed |= dict.fromkeys(identifiers)
            for identifier in identifiers:
                self._bus.wake(identifier)
        self._news.set()

    async def run(self, leads: Callable[[], bool], poll: float) -> None:
        """Deal with changes until canceled.

        Args:
            leads: Returns whether this server is the leader.
            poll: How long to wait for news before a look at the table [s].
        """
        while True:
            try:
                async with asyncio.timeout(poll):
                    await self._news.wait()
            except TimeoutError:
                self._may_all_have_changed = True
                self._bus.wake_all()
            self._news.clear()
            if not leads():
                self._changed.clear()
                continue
            try:
                await self._deal()
            except DatabaseTaken:
                return
            except (DBAPIError, PoolTimeout, DatabaseUnavailable):
                _log.warning("what other servers have changed cannot be read yet")
                self._may_all_have_changed = self._has_lost_news = True
                self._news.set()
                await asyncio.sleep(_PAUSE)

    async def _deal(self) -> None:
        changed, self._changed = list(self._changed), {}
        if self._may_all_have_changed:
            has_lost_news, self._has_lost_news = self._has_lost_news, False
            self._may_all_have_changed = False
            known = list(self._attempts)
            marks = await ask(self._store.marks)
            # What waits here and not in the table has ended elsewhere, or is not written yet.
            changed = list({*changed, *known} - {mark.id for mark in marks})
            await self._settle(marks, with_controls=has_lost_news)
        for i in range(0, len(changed), _AT_ONCE):
            some = changed[i : i + _AT_ONCE]
            await self._settle(await ask(self._store.marks, some))

    async def _settle(self, marks: list[JobMark], *, with_controls: bool = True) -> None:
        fresh: list[str] = []
        for mark in marks:
            if mark.id in self._attempts:
                await self._update(mark, with_controls=with_controls)
            elif mark.state is JobState.QUEUED:
                fresh.append(mark.id)
        for i in range(0, len(fresh), _AT_ONCE):
            for job in await ask(self._store.queued, fresh[i : i + _AT_ONCE]):
                if job.id not in self._attempts:
                    await self._recovery.take_up(job)

    async def _update(self, mark: JobMark, *, with_controls: bool) -> None:
        """Have a job that waits or runs here do what the table says of it."""
        if mark.state.is_final:
            event = await ask(self._store.last_event, mark.id, FINISHED)
            if event is not None:
                self._recorder.publish(mark.id, [event])
            attempt = self._attempts.get(mark.id)
            if attempt is not None and not attempt.has_begun:
                self._attempts.drop(attempt)
            return
        if with_controls:  # that is a look through all events of a job without any
            event = await ask(self._store.last_event, mark.id, CONTROLS)
            if event is not None:
                self._control.adopt(mark.id, event.data)
        attempt = self._attempts.get(mark.id)
        if attempt is not None and mark.is_cancel_requested and not attempt.is_cancel_requested:
            self._attempts.cancel(attempt)
