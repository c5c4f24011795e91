"""PlansInLine: new plans for executions at the head of the line, while the line goes on."""

import asyncio
from collections.abc import Collection

from planning.errors import NotCertified
from service.errors import StartMismatch
from service.executions.models import Replanned
from service.executions.motions.asked_motion import AskedMotion
from service.executions.replanning.planned_instead import planned_instead
from service.plans.submit import PlanTerms
from service.scenes.store.scene_store import SceneStore

type Instead = tuple[AskedMotion, Replanned]


class PlansInLine:
    """Plans motions anew that do not hold when their robots are free; belongs to one event loop."""

    def __init__(self, terms: PlanTerms, scenes: SceneStore) -> None:
        """Have no plan yet."""
        self._terms, self._scenes = terms, scenes
        self._tasks: dict[str, asyncio.Task[Instead]] = {}

    def begin(
        self, execution: str, asked: AskedMotion, fault: NotCertified | StartMismatch
    ) -> None:
        """Plan a motion anew from where the robot is.

        Args:
            execution: Its id.
            asked: The motion.
            fault: What it is refused for if there is no plan.
        """
        plan = planned_instead(asked, fault, self._terms, self._scenes)
        self._tasks[execution] = asyncio.get_running_loop().create_task(plan)

    def is_planning(self, execution: str) -> bool:
        """Return whether a plan is being made for an execution."""
        task = self._tasks.get(execution)
        return task is not None and not task.done()

    def made(self, execution: str) -> Instead | None:
        """Return the plan that was made for an execution, if one was asked for.

        Raises:
            NotCertified: There is none; evidence has why.
            StartMismatch: The same.
        """
        task = self._tasks.get(execution)
        return None if task is None else task.result()

    def forget(self, execution: str) -> None:
        """Have no plan for an execution."""
        if (task := self._tasks.pop(execution, None)) is not None:
            task.cancel()

    def keep(self, executions: Collection[str]) -> None:
        """Forget the plans of all other executions, and make them no longer."""
        for execution in self._tasks.keys() - set(executions):
            self.forget(execution)
