"""JobRun: one job in one slot, from its start to its end in the table."""

import asyncio
import logging
from collections.abc import Callable, Sequence
from functools import partial

from planning.errors import Canceled
from service.events.bus import EventBus
from service.jobs.errors import InternalError
from service.jobs.floor import Floor
from service.jobs.moving import Moved
from service.jobs.outcome import Crashed, Ended, Outcome, Raised, Returned, error_of
from service.jobs.recorder import EventRecorder, Told
from service.jobs.records import Job, LoggedEvent
from service.jobs.slot import Run, Slot
from service.jobs.store import JobStore
from service.jobs.writer import Writer

# How long to wait before the end of a job is written again after the database refused it [s].
_RETRY_PERIOD = 5.0
_log = logging.getLogger(__name__)


class JobRun:
    """Runs a job once; whoever made it queues the job again if it is told to."""

    def __init__(
        self, job: Job, store: JobStore, writer: Writer, bus: EventBus[LoggedEvent], floor: Floor
    ) -> None:
        """Prepare to run a queued job."""
        self.job = job
        self._store = store
        self._writer = writer
        self._bus = bus
        self._floor = floor
        self._slot: Slot | None = None
        self._is_unwanted = False

    def cancel(self) -> None:
        """End the run on request, whatever it does."""
        self._is_unwanted = True
        if self._slot is not None:
            # A task that has something to give on a cancel says how long it needs for that.
            usual = self._floor.lane(self.job.lane).cancel_grace
            self._slot.cancel(self.job.payload.get("cancel_grace", usual))

    async def run(self, slot: Slot) -> bool:
        """Run the job in a slot, which is given back; return whether it is queued again."""
        recorder = EventRecorder(self._record)
        start = partial(self._store.start, self.job.id)
        started: Moved | None = None
        try:
            started = await self._writer.do(start, is_durable=False)
        except Exception:  # noqa: BLE001  (it is queued still)
            _log.exception("the start of %s could not be written", self.job.id)
            await asyncio.sleep(_RETRY_PERIOD)
            return True
        finally:
            if started is None:
                self._floor.readmit(self.job.lane, slot)
        if started is None:  # canceled while it was queued
            return False
        self._bus.publish(self.job.id, [started.event])
        outcome = await self._in_slot(slot, started, recorder)
        await recorder.close()
        return await self._conclude(outcome, started.attempts)

    async def _in_slot(self, slot: Slot, started: Moved, recorder: EventRecorder) -> Outcome:
        """Run the task and give the slot back before the end is written: others wait for it."""
        loop = asyncio.get_running_loop()
        began = loop.time()
        outcome: Outcome = Ended(Canceled("canceled before it began"))
        try:
            if not (self._is_unwanted or started.is_cancel_requested):
                self._slot = slot
                run = Run(self.job.task, self.job.payload, recorder, self.job.allowed)
                outcome = await slot.run(run)
        except Exception as fault:  # noqa: BLE001  (no job may stay unfinished)
            _log.exception("the slot failed under %s", self.job.id)
            outcome = Raised(InternalError(f"the slot failed: {type(fault).__name__}"))
        finally:
            self._slot = None
            self._floor.release(self.job.lane, slot, outcome, loop.time() - began)
        return outcome

    async def _record(self, told: Sequence[Told]) -> None:
        record = partial(self._store.record, self.job.id, told)
        self._bus.publish(self.job.id, await self._writer.do(record, is_durable=False))

    async def _conclude(self, outcome: Outcome, attempts: int) -> bool:
        """Write the end into the table, however long that takes."""
        while True:
            try:
                return await self._write_end(outcome, attempts)
            except Exception:  # noqa: BLE001  (no job may stay unfinished)
                _log.exception("the end of %s could not be written", self.job.id)
                if isinstance(outcome, Returned):
                    # It may be what it returned that the database does not take.
                    outcome = Raised(InternalError("the result could not be recorded"))
                    continue
            await asyncio.sleep(_RETRY_PERIOD)

    async def _write_end(self, outcome: Outcome, attempts: int) -> bool:
        store, identifier = self._store, self.job.id
        match outcome:
            case Returned(result=result, brief=brief):
                await self._write(partial(store.succeed, identifier, result, brief))
                return False
            case Crashed() if attempts < self.job.max_attempts and not self._is_unwanted:
                reason = error_of(outcome, attempts).detail
                moved = await self._write(partial(store.requeue, identifier, reason))
                if moved is None or not (moved.is_cancel_requested or self._is_unwanted):
                    return moved is not None
                error = error_of(Ended(), attempts)
            case Crashed() if self._is_unwanted:
                error = error_of(Ended(), attempts)
            case _:
                error = error_of(outcome, attempts)
        is_canceled = isinstance(error, Canceled)
        end = partial(store.cancel, identifier, error) if is_canceled else None
        await self._write(end or partial(store.fail, identifier, error))
        return False

    async def _write(self, move: Callable[[], Moved | None]) -> Moved | None:
        moved = await self._writer.do(move)
        if moved is not None:
            self._bus.publish(self.job.id, [moved.event])
        return moved
