"""Replanning: another motion for an execution whose own is in conflict with its scene.

The robot goes on meanwhile, and rests at the place where its motion is to be left at the latest. So
no lead time has to be guessed: a splice is right whenever it comes, as up to that place it is the
motion that is followed.
"""

import asyncio
import logging
from contextvars import Context
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np

from planning.errors import NotCertified, WayproofError
from service.executions.models import ExecutionStatus
from service.executions.motions.current_motion import CurrentMotion
from service.executions.proofs.tasks import SPLICE, SpliceWork
from service.executions.replanning.new_plan import KeptMotion, Terms, planned_anew
from service.executions.tasks import MOTION, Bounds, ExecutionWork, NextMotion
from service.jobs.job import Job, JobSummary
from service.jobs.service import JobService
from service.plans.models.request import PlanRequest
from service.plans.resource import motion_of, work_of
from service.scenes.store.scene_store import SceneStore
from service.settings import Settings

# How often it is looked whether a robot rests, or has gone on with a motion, and for how long [s].
_PERIOD, _PATIENCE, _LONGEST_REST = 0.02, 5.0, 60.0
# Where a plan to be spliced in begins: at this share of what holds of the motion after it is left.
# A robot that moves goes on along it for a while.
_TURN = 0.6
_MAX_TRIES = 3
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Conflict:
    """An execution whose motion does not hold.

    Attributes:
        job: Of the execution.
        work: What it carries out.
        motion: That it follows.
        bounds: Between which places it stays; `ahead` and `leave` are there.
    """

    job: JobSummary
    work: ExecutionWork
    motion: CurrentMotion
    bounds: Bounds


class Replanner:
    """Finds other motions in the background, one at a time for each execution."""

    def __init__(self, jobs: JobService, scenes: SceneStore, settings: Settings) -> None:
        """Ask for plans as a client would.

        Args:
            jobs: Has executions and plans.
            scenes: Where they are.
            settings: How plans are made.
        """
        self._jobs = jobs
        self._scenes = scenes
        self._terms = Terms(jobs, settings)
        self._tasks: dict[str, asyncio.Task[None]] = {}

    async def __aenter__(self) -> Self:
        """Begin."""
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give all up."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def begin(self, conflict: Conflict) -> None:
        """Look for another motion, instead of one that was looked for before."""
        self.drop(conflict.job.id)
        # Not for the client that has edited the scene: it may be gone long before this has ended.
        task = asyncio.get_running_loop().create_task(self._replan(conflict), context=Context())
        self._tasks[conflict.job.id] = task
        task.add_done_callback(lambda done: self._forget(conflict.job.id, done))

    def drop(self, execution: str) -> None:
        """Look for no other motion any more: the one that is followed holds, or is looked at."""
        if (task := self._tasks.pop(execution, None)) is not None:
            task.cancel()

    def _forget(self, execution: str, done: asyncio.Task[None]) -> None:
        if self._tasks.get(execution) is done:
            del self._tasks[execution]

    async def _replan(self, conflict: Conflict) -> None:
        try:
            if not await self._go_on(conflict):
                await self._go_on_from_rest(conflict)
        except (WayproofError, TimeoutError) as fault:
            _log.info("execution %s finds no other motion: %s", conflict.job.id, fault)
            await self._give_up(conflict)

    async def _give_up(self, conflict: Conflict) -> None:
        block = conflict.bounds.ahead
        try:
            await self._jobs.control(conflict.job, {"block": block and block.model_dump()})
        except WayproofError as fault:  # it has ended meanwhile
            _log.info("execution %s was not stopped: %s", conflict.job.id, fault)

    async def _go_on(self, conflict: Conflict) -> bool:
        """Splice a new plan in where the motion is to be left; return whether it is followed."""
        leave, block = conflict.bounds.leave or 0.0, conflict.bounds.ahead
        blocked = leave if block is None else block.time
        plan = await self._planned(conflict, leave + _TURN * (blocked - leave))
        record = await self._scenes.fresh(conflict.work.scene_id)
        loaded = self._scenes.work(record)
        work = SpliceWork(
            library=loaded.library,
            scene=loaded.scene,
            planned=conflict.work.planned,
            own=conflict.work.own,
            running=conflict.motion.trajectory,
            time=leave,
            onto=motion_of(plan).polynomial,
        )
        whole = (await self._jobs.call(SPLICE, work)).trajectory
        if whole is None:
            return False
        following = NextMotion(
            number=conflict.motion.number + 1,
            revision=record.revision,
            plan=plan.id,
            trajectory=whole,
            is_spliced=True,
        )
        return await self._is_followed(conflict, following)

    async def _go_on_from_rest(self, conflict: Conflict) -> None:
        """Begin a new plan where the robot has come to rest.

        Raises:
            NotCertified: The robot was always elsewhere by then.
        """
        for _ in range(_MAX_TRIES):
            place = await self._place_at_rest(conflict)
            plan = await self._planned(conflict, place)
            following = NextMotion(
                number=conflict.motion.number + 1,
                revision=work_of(plan).revision,
                plan=plan.id,
                trajectory=motion_of(plan).polynomial,
                is_spliced=False,
            )
            if await self._is_followed(conflict, following):
                return
        message = f"the robot left the place of its new plan {_MAX_TRIES} times"
        raise NotCertified(message, {})

    async def _planned(self, conflict: Conflict, place: float) -> Job:
        """Return a plan from a place of the motion to its end, in the newest revision.

        Raises:
            WayproofError: There is none.
        """
        request = _request(conflict, place)
        return await planned_anew(request, self._terms, self._scenes)

    async def _place_at_rest(self, conflict: Conflict) -> float:
        """Return where on its path the robot rests.

        Raises:
            TimeoutError: It does not rest.
        """
        async with asyncio.timeout(_LONGEST_REST):
            while True:
                told = await self._jobs.latest_event(conflict.job, "status")
                status = None if told is None else ExecutionStatus.model_validate(told)
                if status is not None and _rests(status, conflict):
                    return status.time
                await asyncio.sleep(_PERIOD)

    async def _is_followed(self, conflict: Conflict, following: NextMotion) -> bool:
        """Have the execution go on with a motion, and return whether it does.

        Raises:
            WayproofError: It has ended.
        """
        await self._jobs.control(conflict.job, {"next": following.model_dump()})
        clock = asyncio.get_running_loop().time
        until, is_followed = clock() + _PATIENCE, False
        while not is_followed and clock() < until:
            await asyncio.sleep(_PERIOD)
            event = await self._jobs.latest_event(conflict.job, MOTION)
            is_followed = event is not None and event["number"] >= following.number
        # What is said once need not be told again with every command.
        await self._jobs.control(conflict.job, {"next": None})
        return is_followed


def _rests(status: ExecutionStatus, conflict: Conflict) -> bool:
    is_told = status.ahead is not None and status.motion == conflict.motion.number
    return is_told and status.path_velocity == 0.0


def _request(conflict: Conflict, place: float) -> PlanRequest:
    """Return the request of a plan from a place of the motion to its end."""
    trajectory = conflict.motion.trajectory.to_domain()
    start = trajectory.positions(np.array([place]))[0].tolist()
    work, goal = conflict.work, trajectory.end.tolist()
    kept = KeptMotion(work.scene_id, work.group, goal, work.planned, work.own)
    asked = kept.request(start)
    # A splice joins it in mid-motion, under limits on jerk; refinement takes longer than it gains.
    retime = asked.retime.model_copy(update={"method": "ruckig", "duration": None})
    refine = asked.refine.model_copy(update={"method": "none"})
    return asked.model_copy(update={"retime": retime, "refine": refine})
