"""ContactWatch: robots that different executions move are looked at together while they move.

Each execution is carried out by itself: a simulation has the other robots where they were when it
began, and a robot of metal feels no other. Motions that run at once are proven beside each other
whatever their timing, so robots meet only where one has left its path. The measured positions of
all are held against one another twenty times a second; both executions of a contact are aborted,
and hold where they are.
"""

import asyncio
import logging
from collections import defaultdict
from collections.abc import Iterator, Sequence

from planning.errors import WayproofError
from service.executions.models import ExecutionStatus
from service.executions.tasks import EXECUTE, ExecutionOutline, Touch
from service.executions.watching.tasks import TOUCHING, MeasuredGroup, Touching, TouchWork
from service.jobs.job import JobSummary
from service.jobs.service import JobService
from service.jobs.states import JobState
from service.jobs.store.sql.database import is_of_database

# Between two looks at measured positions, and between two at what runs [s].
_PERIOD, _LOOK = 0.05, 0.25
# Executions that run at once; there are as many as workers for them.
_MOST = 100
_log = logging.getLogger(__name__)

type Measured = tuple[JobSummary, ExecutionOutline, ExecutionStatus]


class ContactWatch:
    """Looks after all scenes in which several executions run; of the server that leads."""

    def __init__(self, jobs: JobService) -> None:
        """Read what executions measure."""
        self._jobs = jobs
        self._seen: dict[str, list[list[float]]] = {}

    async def run(self) -> None:
        """Look at what moves until canceled."""
        while True:
            is_needed = False
            try:
                is_needed = await self._look()
            except Exception as fault:  # noqa: BLE001  (it goes on whatever happens)
                if not is_of_database(fault):
                    _log.exception("robots that move at once were not looked at")
            await asyncio.sleep(_PERIOD if is_needed else _LOOK)

    async def _look(self) -> bool:
        """Look once at each scene in which several executions run; return whether there is one."""
        if self._jobs.is_stopping or self._jobs.loads()[EXECUTE.queue].num_running < 2:
            self._seen.clear()
            return False
        page = await self._jobs.page(EXECUTE.queue, _MOST, None, state=JobState.RUNNING)
        by_scene: defaultdict[str, list[JobSummary]] = defaultdict(list)
        for job in page.jobs:
            by_scene[job.scene or ""].append(job)
        several = [jobs for jobs in by_scene.values() if len(jobs) > 1]
        await asyncio.gather(*(self._look_at(jobs) for jobs in several))
        return bool(several)

    async def _look_at(self, jobs: Sequence[JobSummary]) -> None:
        """Abort the executions of a scene whose robots touch."""
        measured = [each for job in jobs if (each := await self._measured(job)) is not None]
        where = [status.positions for _, _, status in measured]
        scene = jobs[0].scene or ""
        if len(measured) < 2 or self._seen.get(scene) == where:
            return
        try:
            found = await self._jobs.call(TOUCHING, _work(measured))
        except WayproofError as fault:  # a busy server: the next look comes soon
            _log.warning("robots that move at once were not looked at: %s", fault)
            return
        self._seen[scene] = where
        for touching in found.found[:1]:
            for job, touch in _touches(touching, measured):
                try:
                    await self._jobs.control(job, {"touch": touch.model_dump()})
                except WayproofError as fault:  # it has ended meanwhile
                    _log.info("execution %s was not stopped: %s", job.id, fault)

    async def _measured(self, job: JobSummary) -> Measured | None:
        event = await self._jobs.latest_event(job, "status")
        if event is None:
            return None
        work = ExecutionOutline.model_validate(job.payload)
        return job, work, ExecutionStatus.model_validate(event)


def _work(measured: Sequence[Measured]) -> TouchWork:
    """Return what is looked at, in the scene of the last execution that entered."""
    _, last, _ = max(measured, key=lambda each: each[0].sequence)
    groups = [
        MeasuredGroup(execution=job.id, group=work.group, positions=status.positions)
        for job, work, status in measured
    ]
    return TouchWork(library=last.library, scene=last.scene, groups=groups)


def _touches(
    touching: Touching, measured: Sequence[Measured]
) -> Iterator[tuple[JobSummary, Touch]]:
    """Yield each execution of a contact, and what it is told."""
    for job, _, status in measured:
        if job.id in touching.executions:
            (other,) = (each for each in touching.executions if each != job.id)
            yield (
                job,
                Touch(
                    pair=list(touching.pair),
                    depth=touching.depth,
                    time=status.time,
                    execution=other,
                ),
            )
