"""Settling: what a simulation does once a motion has ended, before that is told.

Fingers press on what they shall hold by contact, and what was lost on the way falls.
"""

import numpy as np

from planning import World
from planning.errors import ExecutionFailure
from planning.execute.abort_reasons import grasp_failure
from planning.execute.driver import Driver
from planning.world.mechanics.settle_grip import settle_grip
from service.executions.gripping.held import HeldStatus
from service.executions.models import ExecutionState, ExecutionStatus
from service.executions.tasks import ExecutionWork

# How long what was lost is seen to fall [s].
_FALL = 0.5


class Settling:
    """Changes the last status of an execution to what is measured once all has settled."""

    def __init__(self, world: World, work: ExecutionWork, driver: Driver) -> None:
        """Have nothing to do yet.

        Args:
            world: In which it moves.
            work: What is carried out.
            driver: Of the robot.
        """
        self._world, self._work, self._driver = world, work, driver
        self._failures: list[ExecutionFailure] = []

    @property
    def failure(self) -> ExecutionFailure | None:
        """Why it has failed after all; None if it has not."""
        return self._failures[0] if self._failures else None

    def settled(self, status: ExecutionStatus, driver_time: float) -> ExecutionStatus:
        """Return the last status of an execution, once all has come to rest.

        Args:
            status: As the motion ended.
            driver_time: Then, on the driver's clock [s].
        """
        gripper = self._work.request.gripper
        if status.state is ExecutionState.SUCCEEDED and gripper is not None and gripper.grip:
            return self._pressed(status)
        if any(held.is_lost for held in status.held):
            fallen = self._driver.read(driver_time + _FALL).held
            return status.model_copy(update={"held": [*map(HeldStatus.from_domain, fallen)]})
        return status

    def _pressed(self, status: ExecutionStatus) -> ExecutionStatus:
        """Return the status once fingers press on an object that is held by contact."""
        gripper = self._work.request.gripper
        grasp = None if gripper is None else gripper.attached(self._tool_frame)
        if grasp is None:
            return status
        found = settle_grip(self._world, self._work.group, np.array(status.positions), grasp)
        told = {"positions": found.positions.tolist(), "held": [HeldStatus.from_domain(found.held)]}
        if found.held.is_lost:
            self._failures.append(grasp_failure(found.held, status.time))
            told["state"] = ExecutionState.ABORTED
        return status.model_copy(update=told)

    @property
    def _tool_frame(self) -> str:
        tools = self._world.group(self._work.group).tool_frames
        return tools[0] if tools else ""
